"""The simulators that PyNN drives as brains of the platform, from the same networks as every other."""

from nrp_brain_pynn.backend import PyNNBackend
from nrp_brain_pynn.options import PyNNOptions

__all__ = ["PyNNBackend", "PyNNOptions"]
