"""Experiments: read one from a file, check it, run it, and judge the result.

``find`` reads, ``validate`` checks, ``run`` runs; ``model`` and ``happenings`` say what a file can hold.
"""
