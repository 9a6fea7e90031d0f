"""The kernel of :mod:`nrp_core.brain.network.synapses.tsodyks_markram`, exact between spikes."""

from __future__ import annotations

from math import exp
from typing import Any, Final

from nrp_core._support.jit import jit
from nrp_core.brain.network import filters
from nrp_core.brain.network.synapses.tsodyks_markram import LAW

CONSTANTS: Final = tuple(LAW.parameters)

driven = jit(filters.driven)


@jit
def facilitated(synapse: Any, dt: float) -> float:
    """Return u for a spike dt (ms) after the last one; ``U`` without facilitation."""
    left = synapse.u * exp(-dt / synapse.tau_facil) if synapse.tau_facil > 0.0 else 0.0
    return float(left + synapse.U * (1.0 - left))


@jit
def released_share(synapse: Any, t: float) -> float:
    """Return the fraction of the weight that a spike emitted at t transmits, and update the synapse.

    Args:
        synapse: a record with the constants, ``tau_psc`` of the target's synapse (ms, 0 where nothing stays
            active), and the state after the last spike at ``t``: ``u``, ``y``, ``z``; all 0 at rest.
        t: ms.
    """
    dt = t - synapse.t
    if synapse.tau_psc > 0.0:
        recovery, decay = exp(-dt / synapse.tau_rec), exp(-dt / synapse.tau_psc)
        gap = 1.0 / synapse.tau_psc - 1.0 / synapse.tau_rec
        inflow = driven(dt, recovery, decay, gap, synapse.y / synapse.tau_psc, 0.0)
        synapse.z = synapse.z * recovery + inflow
        synapse.y *= decay
    else:
        synapse.z = (synapse.z + synapse.y) * exp(-dt / synapse.tau_rec)
        synapse.y = 0.0
    synapse.u = facilitated(synapse, dt)
    released = float(synapse.u * (1.0 - synapse.y - synapse.z))
    synapse.y += released
    synapse.t = t
    return released
