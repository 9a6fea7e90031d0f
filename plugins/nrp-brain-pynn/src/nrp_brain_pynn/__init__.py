"""The simulators of PyNN as brain backends, with the same networks as all others."""

from nrp_brain_pynn.backend import PyNNBackend
from nrp_brain_pynn.options import PyNNOptions

__all__ = ["PyNNBackend", "PyNNOptions"]
