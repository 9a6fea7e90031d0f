"""Convert experiments of the platform to our own format, for ``nrp import``."""
