"""Robots and rooms as data."""
