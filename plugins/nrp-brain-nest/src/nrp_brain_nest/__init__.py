"""NEST as a brain of the platform: the same networks and devices, simulated by NEST on its grid."""

from nrp_brain_nest.backend import NestBackend
from nrp_brain_nest.options import NestOptions

__all__ = ["NestBackend", "NestOptions"]
