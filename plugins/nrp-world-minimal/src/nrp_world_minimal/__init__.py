"""A complete world backend in plain NumPy, to read and to start from."""

from nrp_world_minimal.engine import MinimalBackend

__all__ = ["MinimalBackend"]
