"""An exact, event-driven simulator of point neurons: spike times are real numbers, not grid points.

``synapse_laws.py`` names the kernel of each synapse law, ``plastic_connections.py`` the rules of plasticity.
"""

from nrp_brain_event.backend import EventBackend
from nrp_brain_event.options import EventOptions

__all__ = ["EventBackend", "EventOptions"]
