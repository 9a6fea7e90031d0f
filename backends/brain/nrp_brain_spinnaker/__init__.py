"""The ``spinnaker`` brain: reproduces sPyNNaker 7.4.1 on a SpiNNaker machine bit for bit."""

from nrp_brain_spinnaker.backend import SpinnakerBackend
from nrp_brain_spinnaker.options import SpinnakerOptions

__all__ = ["SpinnakerBackend", "SpinnakerOptions"]
