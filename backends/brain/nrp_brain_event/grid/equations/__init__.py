"""Cells that users write as equations: a kernel is written and compiled for each."""
