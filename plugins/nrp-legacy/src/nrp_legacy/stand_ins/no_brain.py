"""A brain without neurons, for an experiment that has none."""
