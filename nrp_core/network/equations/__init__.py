"""Cells that users write as equations: their units, what they mean, and whether they are linear."""
