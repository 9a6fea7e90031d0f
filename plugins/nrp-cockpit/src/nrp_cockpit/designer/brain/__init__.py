"""Brains that are drawn: populations and projections as boxes and wires, which write a PyNN script."""
