"""The two synapses of a neuron: their input decays as ``(x + s dt) exp(-dt / tau_syn)``.

An exponential synapse has only x, an alpha synapse starts with only s; for delta synapses both stay zero. The
excitatory synapse is number 0, the inhibitory one number 1.
"""

from __future__ import annotations

from math import e, exp
from typing import Final

from nrp_brain_event.records import ALPHA, EXPONENTIAL, Cell
from nrp_core._support.jit import inlined
from nrp_core.brain.network import filters

_NEGLIGIBLE: Final = 1e-20
"""Conductance (uS) or current (nA) below which a synapse counts as silent."""

driven = inlined(filters.driven)


@inlined
def left_of(cell: Cell, k: int, dt: float) -> float:
    """Return the remaining share of synapse k ``dt`` ms after the last event; 1 if it is silent."""
    return exp(-dt * cell.fading[k]) if cell.x[k] != 0.0 or cell.s[k] != 0.0 else 1.0


@inlined
def fade(cell: Cell, k: int, dt: float, left: float) -> None:
    """Decay synapse k by ``dt`` ms to the remaining share."""
    x, s = (cell.x[k] + cell.s[k] * dt) * left, cell.s[k] * left
    if abs(x) < _NEGLIGIBLE and abs(s) < _NEGLIGIBLE:
        x = s = 0.0
    cell.x[k], cell.s[k] = x, s


@inlined
def charge(cell: Cell, k: int, dt: float, leak: float, left: float) -> float:
    """Return the charge (pC) of synapse k on a membrane after ``dt`` ms, given ``leak`` and ``left``."""
    if cell.x[k] == 0.0 and cell.s[k] == 0.0:
        return 0.0
    return driven(dt, leak, left, cell.fading[k] - cell.leak, cell.x[k], cell.s[k])


@inlined
def arrive(cell: Cell, k: int, weight: float) -> None:
    """Deliver a spike to synapse k; an alpha function peaks at the weight after one time constant."""
    if cell.synapse == EXPONENTIAL:
        cell.x[k] += weight
    elif cell.synapse == ALPHA:
        cell.s[k] += weight * e / cell.tau_syn[k]


@inlined
def remaining_at(cell: Cell, k: int, dt: float) -> float:
    """Return conductance (uS) or current (nA) of synapse k ``dt`` ms after the last event."""
    return float((cell.x[k] + cell.s[k] * dt) * left_of(cell, k, dt))


@inlined
def silent(cell: Cell) -> bool:
    """Return whether both synapses are silent."""
    return bool(cell.x[0] == 0.0 and cell.s[0] == 0.0 and cell.x[1] == 0.0 and cell.s[1] == 0.0)
