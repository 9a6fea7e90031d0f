"""A running experiment: its control and its result."""
