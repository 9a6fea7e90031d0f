"""Executors perform the runs of a sweep: one module each; entry points add others."""
