"""Cells that users define by equations: units, meaning, and whether the equations are linear."""
