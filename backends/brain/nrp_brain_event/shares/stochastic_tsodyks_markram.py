"""The kernel of :mod:`nrp_core.brain.network.synapses.stochastic_tsodyks_markram`."""

from __future__ import annotations

from math import exp
from typing import Any

from nrp_brain_event.random_numbers import uniform
from nrp_core._support.jit import jit
from nrp_core.brain.network.synapses.tsodyks_markram_kernel import facilitated


@jit
def share(synapse: Any, t: float) -> float:
    """Return 1 if a spike emitted at t (ms) releases the vesicle, else 0."""
    dt = t - synapse.t
    synapse.u, synapse.t = facilitated(synapse, dt), t
    if synapse.empty and uniform(synapse) < 1.0 - exp(-dt / synapse.tau_rec):
        synapse.empty = 0.0
    if not synapse.empty and uniform(synapse) < synapse.u:
        synapse.empty = 1.0
        return 1.0
    return 0.0
