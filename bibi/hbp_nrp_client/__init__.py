"""The transfer function framework under its name in the paper."""
