"""The parts of an experiment, made from its file."""
