"""Recordings as they are read."""
