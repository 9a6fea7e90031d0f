"""The kernel of :mod:`nrp_core.brain.network.synapses.multiquantal`."""

from __future__ import annotations

from math import exp
from typing import Any

from nrp_brain_event.random_numbers import uniform
from nrp_core._support.jit import jit
from nrp_core.brain.network.synapses.tsodyks_markram_kernel import facilitated


@jit
def share(synapse: Any, t: float) -> float:
    """Return the share of the sites that a spike emitted at t (ms) empties."""
    dt = t - synapse.t
    synapse.u, synapse.t = facilitated(synapse, dt), t
    synapse.empty -= _count(synapse, synapse.empty, 1.0 - exp(-dt / synapse.tau_rec))
    released = _count(synapse, synapse.n - synapse.empty, synapse.u)
    synapse.empty += released
    return float(released / synapse.n)


@jit
def _count(synapse: Any, n: float, probability: float) -> float:
    """Return how many of n sites change."""
    count = 0.0
    for _ in range(int(n)):
        if uniform(synapse) < probability:
            count += 1.0
    return count
