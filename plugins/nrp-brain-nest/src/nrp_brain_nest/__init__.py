"""NEST as a brain backend: the same networks and devices, simulated by NEST on its time grid."""

from nrp_brain_nest.backend import NestBackend
from nrp_brain_nest.options import NestOptions

__all__ = ["NestBackend", "NestOptions"]
