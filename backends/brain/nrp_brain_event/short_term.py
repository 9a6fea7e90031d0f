"""Short-term plasticity, as devices have it: see :mod:`nrp_core.brain.network.synapses.short_term`."""

from nrp_core.brain.network.synapses.short_term import released_share

__all__ = ["released_share"]
