"""The two synapses of a neuron: what has arrived fades as ``(x + s dt) exp(-dt / tau_syn)``.

An exponential synapse has only x, an alpha synapse begins with only s; on neurons whose synapses are
jumps of the voltage both stay zero. The excitatory synapse is number 0, the inhibitory one number 1.
"""

from __future__ import annotations

from math import e, exp
from typing import Final

from nrp_brain_event.records import ALPHA, EXPONENTIAL, Cell
from nrp_core.brain import filters
from nrp_core.jit import jit

_NEGLIGIBLE: Final = 1e-20
"""uS or nA below which a synapse counts as silent."""

driven = jit(filters.driven)


@jit
def fade(cell: Cell, dt: float) -> None:
    """Let both synapses fade for ``dt`` ms."""
    for k in range(2):
        if cell.x[k] == 0.0 and cell.s[k] == 0.0:
            continue
        remaining = exp(-dt / cell.tau_syn[k])
        cell.x[k] = (cell.x[k] + cell.s[k] * dt) * remaining
        cell.s[k] *= remaining
        if abs(cell.x[k]) < _NEGLIGIBLE and abs(cell.s[k]) < _NEGLIGIBLE:
            cell.x[k] = cell.s[k] = 0.0


@jit
def arrive(cell: Cell, k: int, weight: float) -> None:
    """Let a spike arrive at synapse k; an alpha course peaks at the weight after one time constant."""
    if cell.synapse == EXPONENTIAL:
        cell.x[k] += weight
    elif cell.synapse == ALPHA:
        cell.s[k] += weight * e / cell.tau_syn[k]


@jit
def remaining_at(cell: Cell, k: int, dt: float) -> float:
    """Return conductance (uS) or current (nA) of synapse k ``dt`` ms after the last event."""
    if cell.x[k] == 0.0 and cell.s[k] == 0.0:
        return 0.0
    return float((cell.x[k] + cell.s[k] * dt) * exp(-dt / cell.tau_syn[k]))


@jit
def silent(cell: Cell) -> bool:
    """Return whether nothing is left of what has arrived."""
    return bool(cell.x[0] == 0.0 and cell.s[0] == 0.0 and cell.x[1] == 0.0 and cell.s[1] == 0.0)
