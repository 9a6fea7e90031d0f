"""Musculoskeletal models of OpenSim as worlds: excitations are commands, states are topics."""

from nrp_world_opensim.backend import OpensimBackend

__all__ = ["OpensimBackend"]
