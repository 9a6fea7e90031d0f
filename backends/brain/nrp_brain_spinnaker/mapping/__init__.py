"""A network on a real machine: where it sits, what it costs and what it loses."""
