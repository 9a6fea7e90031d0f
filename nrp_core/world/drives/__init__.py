"""Drives: robots that move as a whole."""
