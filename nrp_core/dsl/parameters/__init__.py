"""Parameters of transfer functions: bindings, topics, messages."""
