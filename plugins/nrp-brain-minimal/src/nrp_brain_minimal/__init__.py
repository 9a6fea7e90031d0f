"""A complete brain backend in plain NumPy, to read and to start from."""

from nrp_brain_minimal.brain import MinimalBackend

__all__ = ["MinimalBackend"]
