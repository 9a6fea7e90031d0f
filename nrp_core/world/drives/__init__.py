"""Drives: they move a robot as a whole."""
