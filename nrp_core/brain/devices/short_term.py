"""Short-term plasticity of Tsodyks and Markram for devices; its kernel is exact between spikes."""

from __future__ import annotations

from collections.abc import Mapping
from math import exp
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.jit import jit
from nrp_core.errors import did_you_mean
from nrp_core.network import filters
from nrp_core.network.limits import OF_SYNAPSES, check_values
from nrp_core.network.synapses import TSODYKS_MARKRAM_LAW

CONSTANTS: Final = tuple(TSODYKS_MARKRAM_LAW.parameters)

driven = jit(filters.driven)


@jit
def utilization(synapse: Any, dt: float) -> float:
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
    synapse.u = utilization(synapse, dt)
    released = float(synapse.u * (1.0 - synapse.y - synapse.z))
    synapse.y += released
    synapse.t = t
    return released


_KIND: Final = "TsodyksMarkram"
_STATE: Final = ("t", *TSODYKS_MARKRAM_LAW.state)


class ShortTermSynapses:
    """Synapses of one device, one for each of its neurons.

    Args:
        given: ``{"type": "TsodyksMarkram", "U": ..., "tau_rec": ..., "tau_facil": ...}``, times in ms.
        tau_psc: the synaptic time constant of each target, ms.

    Raises:
        ValueError: another synapse type, or a constant is missing or unknown.
        NetworkError: a constant is invalid.
    """

    def __init__(self, given: Mapping[str, Any], tau_psc: FloatArray) -> None:
        if given.get("type") != _KIND:
            raise ValueError(f"synapse_type has the type {_KIND}, not {given.get('type')!r}")
        for name in CONSTANTS:
            if name not in given:
                raise ValueError(f"synapse_type {_KIND} needs '{name}'")
        for name in given.keys() - {"type", *CONSTANTS}:
            raise ValueError(f"synapse_type {_KIND} has no '{name}'{did_you_mean(name, CONSTANTS)}")
        values = {name: np.array([float(given[name])]) for name in CONSTANTS}
        check_values(f"synapse_type {_KIND}", values, limits=OF_SYNAPSES)
        fields = [(name, "f8") for name in (*CONSTANTS, "tau_psc", *_STATE)]
        self._table = np.zeros(len(tau_psc), np.dtype((np.record, fields)))
        for name, value in {**values, "tau_psc": tau_psc}.items():
            self._table[name] = value

    def released(self, index: IntArray, times_ms: FloatArray) -> FloatArray:
        """Return the fraction of the weight that each spike transmits; spikes are in the order of time."""
        spikes = zip(index.tolist(), times_ms.tolist(), strict=True)
        return np.array([released_share(self._table[i], t) for i, t in spikes])

    def reset(self) -> None:
        """Set the synapses to rest at time 0."""
        for name in _STATE:
            self._table[name] = 0.0

    def save(self) -> object:
        """Return the state."""
        return self._table.copy()

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        self._table[:] = saved
