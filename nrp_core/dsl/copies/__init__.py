"""One call of a transfer function for all copies of an experiment."""
