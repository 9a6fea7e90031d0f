"""The two synapses of a neuron: what has arrived fades as ``(x + s dt) exp(-dt / tau_syn)``.

An exponential synapse has only x, an alpha synapse starts with only s; on the neurons whose synapses
are jumps of the voltage both stay zero.
"""

from __future__ import annotations

from math import e, exp
from typing import Final

from nrp_core.brain.filters import driven as _driven
from nrp_core.jit import jit

from nrp_brain_event.records import ALPHA, EXPONENTIAL, Record

driven = jit(_driven)

_NEGLIGIBLE: Final = 1e-30
"""uS or nA below which a synapse counts as silent."""


@jit
def fade(cell: Record, dt: float) -> None:
    """Let both synapses fade for ``dt`` ms."""
    if cell.x_e != 0.0 or cell.s_e != 0.0:
        remaining = exp(-dt / cell.tau_syn_E)
        cell.x_e = (cell.x_e + cell.s_e * dt) * remaining
        cell.s_e *= remaining
        if abs(cell.x_e) < _NEGLIGIBLE and abs(cell.s_e) < _NEGLIGIBLE:
            cell.x_e = cell.s_e = 0.0
    if cell.x_i != 0.0 or cell.s_i != 0.0:
        remaining = exp(-dt / cell.tau_syn_I)
        cell.x_i = (cell.x_i + cell.s_i * dt) * remaining
        cell.s_i *= remaining
        if abs(cell.x_i) < _NEGLIGIBLE and abs(cell.s_i) < _NEGLIGIBLE:
            cell.x_i = cell.s_i = 0.0


@jit
def excite(cell: Record, weight: float) -> None:
    """Let a spike arrive at the excitatory synapse."""
    if cell.synapse == EXPONENTIAL:
        cell.x_e += weight
    elif cell.synapse == ALPHA:
        cell.s_e += weight * e / cell.tau_syn_E


@jit
def inhibit(cell: Record, weight: float) -> None:
    """Let a spike arrive at the inhibitory synapse."""
    if cell.synapse == EXPONENTIAL:
        cell.x_i += weight
    elif cell.synapse == ALPHA:
        cell.s_i += weight * e / cell.tau_syn_I


@jit
def excitation(cell: Record, dt: float) -> float:
    """Return conductance (uS) or current (nA) of the excitatory synapse ``dt`` ms from now."""
    if cell.x_e == 0.0 and cell.s_e == 0.0:
        return 0.0
    return (cell.x_e + cell.s_e * dt) * exp(-dt / cell.tau_syn_E)


@jit
def inhibition(cell: Record, dt: float) -> float:
    """Return conductance (uS) or current (nA) of the inhibitory synapse ``dt`` ms from now."""
    if cell.x_i == 0.0 and cell.s_i == 0.0:
        return 0.0
    return (cell.x_i + cell.s_i * dt) * exp(-dt / cell.tau_syn_I)


@jit
def silent(cell: Record) -> bool:
    """Return whether nothing is left of what has arrived."""
    return cell.x_e == 0.0 and cell.s_e == 0.0 and cell.x_i == 0.0 and cell.s_i == 0.0
