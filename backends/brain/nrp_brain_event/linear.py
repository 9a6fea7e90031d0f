"""Membranes whose equation has a closed-form solution.

They are IF_curr_exp, IF_curr_alpha and IF_curr_delta, and IF_cond_exp and IF_cond_alpha without input.

A neuron is advanced from event to event. After each event a cheap bound gives a time before which it cannot
fire; only if nothing arrives until then is its next spike computed. Both depend only on the state at the
event, not on the division of the run.
"""

from __future__ import annotations

from math import e, exp, inf
from typing import Final

from nrp_brain_event import rise
from nrp_brain_event.records import CONDUCTANCE, FIRE, LINEAR, SEARCH, Cell, Work
from nrp_brain_event.synaptic_inputs import charge, left_of, silent
from nrp_core._support.jit import inlined, jit

NEAR: Final = 0.01
"""Distance from the threshold, in time constants, below which a spike is computed instead of excluded."""
_SOON: Final = 0.05
"""Time constants within which it is searched first."""
_LONG: Final = 80.0
"""Time constants after which nothing remains, in double precision, of an earlier state."""


@inlined
def is_linear(cell: Cell) -> bool:
    """Return whether the neuron's trajectory after its last event has a closed form."""
    return cell.membrane == LINEAR or (cell.membrane == CONDUCTANCE and silent(cell))


@inlined
def settled_voltage(cell: Cell) -> float:
    """Return the steady-state voltage for the constant currents alone, mV."""
    return float(cell.v_rest + (cell.i_offset + cell.current) * cell.resistance)


@inlined
def linear_voltage(cell: Cell, dt: float, left_e: float, left_i: float) -> float:
    """Return the voltage ``dt`` ms after the last event, mV, outside the refractory period.

    Args:
        cell: the neuron.
        dt: ms.
        left_e: the remaining share of the excitatory synapse then.
        left_i: the remaining share of the inhibitory one.
    """
    settled, leak = settled_voltage(cell), exp(-dt * cell.leak)
    driven = charge(cell, 0, dt, leak, left_e) + charge(cell, 1, dt, leak, left_i)
    return float(settled + (cell.path[0, 0] - settled) * leak + driven * cell.per_cm)


@inlined
def plan_search(cell: Cell) -> None:
    """Set a time before which the neuron, now below threshold, cannot fire without input."""
    strongest = _strongest(cell, 0, 0.0, 1.0) + _strongest(cell, 1, 0.0, 1.0)
    _wait(cell, cell.t, cell.path[0, 0], strongest)


@jit
def search(cell: Cell, work: Work) -> None:
    """Set the time of the next spike of a neuron without input until its wake-up, or a later bound."""
    t, dt = cell.wake, cell.wake - cell.t
    left_e, left_i = left_of(cell, 0, dt), left_of(cell, 1, dt)
    strongest = _strongest(cell, 0, dt, left_e) + _strongest(cell, 1, dt, left_i)
    _wait(cell, t, linear_voltage(cell, dt, left_e, left_i), strongest)
    if cell.wake <= t + NEAR * cell.tau_m:
        _find(cell, work, dt, _weakest(cell, 0, dt, left_e) + _weakest(cell, 1, dt, left_i))


@inlined
def _strongest(cell: Cell, k: int, dt: float, left: float) -> float:
    """Return an upper bound of the current (nA) of synapse k from ``dt`` ms after the last event on."""
    later = max(0.0, cell.s[k] * cell.tau_syn[k] * left / e) if cell.s[k] != 0.0 else 0.0
    return float(max(0.0, (cell.x[k] + cell.s[k] * dt) * left) + later)


@jit
def _weakest(cell: Cell, k: int, dt: float, left: float) -> float:
    """Return a lower bound of the current for the period ``_SOON`` from then on."""
    x, s, moment = (cell.x[k] + cell.s[k] * dt) * left, cell.s[k] * left, _SOON * cell.tau_m
    return float(max(0.0, x * (1.0 - moment * cell.fading[k])) + min(0.0, x) + min(0.0, s * moment))


@inlined
def _wait(cell: Cell, t: float, voltage: float, strongest: float) -> None:
    """Schedule the search for a spike of a neuron that is below threshold at t.

    Its voltage stays below the trajectory under the largest future current, which is concave: it takes at
    least the same share of a time constant as of the distance.
    """
    ceiling = settled_voltage(cell) + strongest * cell.resistance
    cell.on_wake, cell.wake = SEARCH, inf
    if ceiling > cell.threshold:
        cell.wake = t + cell.tau_m * (cell.threshold - voltage) / (ceiling - voltage)


@jit
def _find(cell: Cell, work: Work, dt: float, weakest: float) -> None:
    """Set the time of the next spike: the first rise to the threshold from ``dt`` ms after the last event on.

    If even the smallest current in a period makes the voltage rise until it reaches the threshold within the
    period, this crossing is the only one.
    """
    settled, c = settled_voltage(cell), work.function
    c[rise.SETTLED], c[rise.ABOVE] = settled - cell.threshold, cell.path[0, 0] - settled
    c[rise.TAU_M], c[rise.CM] = cell.tau_m, cell.cm
    c[rise.X_E], c[rise.S_E], c[rise.X_I], c[rise.S_I] = cell.x[0], cell.s[0], cell.x[1], cell.s[1]
    tau_e = _active_tau(cell, 0, _active_tau(cell, 1, cell.tau_m))
    tau_i = _active_tau(cell, 1, tau_e)
    c[rise.TAU_E], c[rise.TAU_I] = tau_e, tau_i
    found = inf
    if c[rise.SETTLED] * cell.leak + weakest * cell.per_cm > 0.0:
        found = rise.only_rise(rise.RESPONSE, work, dt, dt + _SOON * cell.tau_m)
    if found == inf:
        found = rise.first_rise(rise.RESPONSE, work, _LONG * max(cell.tau_m, max(tau_e, tau_i)))
    cell.on_wake, cell.wake = FIRE, cell.t + found


@jit
def _active_tau(cell: Cell, k: int, otherwise: float) -> float:
    """Return the time constant of an active synapse."""
    return float(cell.tau_syn[k]) if cell.x[k] != 0.0 or cell.s[k] != 0.0 else otherwise
