"""The kernel of :mod:`nrp_core.brain.network.synapses.simple_stochastic`."""

from __future__ import annotations

from typing import Any

from nrp_brain_event.random_numbers import uniform
from nrp_core._support.jit import jit


@jit
def share(synapse: Any, t: float) -> float:
    """Return 1 with the probability ``p``, else 0."""
    synapse.t = t
    return 1.0 if uniform(synapse) < synapse.p else 0.0
