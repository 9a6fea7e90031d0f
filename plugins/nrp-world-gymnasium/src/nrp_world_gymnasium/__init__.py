"""Environments of Gymnasium as worlds: observations and actions are topics."""

from nrp_world_gymnasium.backend import GymnasiumBackend

__all__ = ["GymnasiumBackend"]
