"""Experiments of the platform turned into our own format, for ``nrp import``."""
