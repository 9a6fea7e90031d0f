"""Drawn brains: populations and projections as boxes and wires, saved as a PyNN script."""
