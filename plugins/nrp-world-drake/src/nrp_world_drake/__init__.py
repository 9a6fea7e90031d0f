"""Scenes in Drake, as worlds of nrp-core."""

from nrp_world_drake.backend import DrakeBackend

__all__ = ["DrakeBackend"]
