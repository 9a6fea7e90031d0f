"""Membranes whose equation has a solution in closed form.

They are IF_curr_exp, IF_curr_alpha and IF_curr_delta, and IF_cond_exp and IF_cond_alpha without input.

A neuron is moved from event to event. After each event a bound that costs a few multiplications says
until when it cannot fire; only a neuron that is still undisturbed by then has its next spike
computed. Both depend on the state at the event alone, never on how the run is divided.
"""

from __future__ import annotations

from math import e, exp, inf
from typing import Final

from nrp_brain_event import rise
from nrp_brain_event.records import CONDUCTANCE, FIRE, LINEAR, SEARCH, Cell, Work
from nrp_brain_event.synapses import driven, silent
from nrp_core.jit import jit

_NEAR: Final = 0.01
"""Time constants before the threshold from which on a spike is computed rather than excluded."""
_LONG: Final = 80.0
"""Time constants after which nothing is left, in double precision, of what was."""


@jit
def is_linear(cell: Cell) -> bool:
    """Return whether the course of the neuron after its last event is known in closed form."""
    return cell.membrane == LINEAR or (cell.membrane == CONDUCTANCE and silent(cell))


@jit
def settled_voltage(cell: Cell) -> float:
    """Return the voltage that the constant currents alone would lead to, mV."""
    return cell.v_rest + (cell.i_offset + cell.current) * cell.tau_m / cell.cm


@jit
def linear_voltage(cell: Cell, dt: float) -> float:
    """Return the voltage ``dt`` ms after the last event, mV, if it is free to move."""
    settled = settled_voltage(cell)
    leak = exp(-dt / cell.tau_m)
    voltage = float(settled + (cell.path[0, 0] - settled) * leak)
    if silent(cell):
        return voltage
    charge = 0.0
    for k in range(2):
        rate = 1.0 / cell.tau_syn[k]
        charge += driven(dt, leak, exp(-dt * rate), rate - cell.leak, cell.x[k], cell.s[k])
    return voltage + charge / cell.cm


@jit
def plan_search(cell: Cell, t: float) -> None:
    """Set the time until which the neuron surely does not fire, left alone; at t it is below threshold.

    Its voltage stays below the course towards what the largest current to come would lead to, and
    that course is concave: it takes at least the same share of a time constant as of the way.
    """
    dt = t - cell.t
    strongest = 0.0
    for k in range(2):
        fade = exp(-dt / cell.tau_syn[k]) if dt > 0.0 else 1.0
        strongest += max(0.0, (cell.x[k] + cell.s[k] * dt) * fade)
        strongest += max(0.0, cell.s[k]) * fade * cell.tau_syn[k] / e
    ceiling = settled_voltage(cell) + strongest * cell.tau_m / cell.cm
    cell.on_wake, cell.wake = SEARCH, inf
    if ceiling > cell.threshold:
        voltage = linear_voltage(cell, dt) if dt > 0.0 else cell.path[0, 0]
        cell.wake = t + cell.tau_m * (cell.threshold - voltage) / (ceiling - voltage)


@jit
def search(cell: Cell, work: Work) -> None:
    """Set the time of the next spike of a neuron that was left alone until it wakes, or a later bound."""
    t = cell.wake
    plan_search(cell, t)
    if cell.wake > t + _NEAR * cell.tau_m:
        return
    settled, c = settled_voltage(cell), work.function
    c[rise.SETTLED], c[rise.ABOVE] = settled - cell.threshold, cell.path[0, 0] - settled
    c[rise.TAU_M], c[rise.CM] = cell.tau_m, cell.cm
    c[rise.X_E], c[rise.S_E], c[rise.X_I], c[rise.S_I] = cell.x[0], cell.s[0], cell.x[1], cell.s[1]
    tau_e = _active_tau(cell, 0, _active_tau(cell, 1, cell.tau_m))
    tau_i = _active_tau(cell, 1, tau_e)
    c[rise.TAU_E], c[rise.TAU_I] = tau_e, tau_i
    until = _LONG * max(cell.tau_m, max(tau_e, tau_i))
    cell.on_wake, cell.wake = FIRE, cell.t + rise.first_rise(rise.RESPONSE, work, until)


@jit
def _active_tau(cell: Cell, k: int, otherwise: float) -> float:
    """Return the time constant of a synapse where something is left of what has arrived."""
    return float(cell.tau_syn[k]) if cell.x[k] != 0.0 or cell.s[k] != 0.0 else otherwise
