"""Experiments: read, check and run them, and evaluate the results.

``reading`` reads files, ``making`` makes the parts, ``running`` runs them; ``model`` defines the contents of
a file.
"""
