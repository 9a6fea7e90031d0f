"""Membranes whose equation is linear (IF_curr_exp, IF_curr_alpha, IF_curr_delta): closed forms throughout.

A neuron is moved from event to event. After each event a bound that costs a few multiplications says
until when it cannot fire; only a neuron that is still undisturbed by then has its next spike
computed. Both depend on the state at the event alone, never on how the run is divided.
"""

from __future__ import annotations

from math import e, exp, inf
from typing import Final

from nrp_core.jit import jit

from nrp_brain_event.records import FIRE, SEARCH, Record
from nrp_brain_event.rise import (
    ABOVE, CM, RESPONSE, S_E, S_I, SETTLED, TAU_E, TAU_I, TAU_M, X_E, X_I, first_rise,
)  # fmt: skip
from nrp_brain_event.synapses import driven, silent

_LONG: Final = 80.0
"""Time constants after which nothing is left, in double precision, of what was."""


@jit
def settled_voltage(cell: Record) -> float:
    """Return the voltage that the constant currents alone would lead to, mV."""
    return cell.v_rest + (cell.i_offset + cell.current) * cell.tau_m / cell.cm


@jit
def linear_voltage(cell: Record, dt: float) -> float:
    """Return the voltage ``dt`` ms after the last event, mV, if it is free to move."""
    settled = settled_voltage(cell)
    leak = exp(-dt / cell.tau_m)
    above = (cell.path[0, 0] - settled) * leak
    if silent(cell):
        return settled + above
    rate = 1.0 / cell.tau_m
    rate_e, rate_i = 1.0 / cell.tau_syn_E, 1.0 / cell.tau_syn_I
    charge = driven(dt, leak, exp(-dt * rate_e), rate_e - rate, cell.x_e, cell.s_e)
    charge += driven(dt, leak, exp(-dt * rate_i), rate_i - rate, cell.x_i, cell.s_i)
    return settled + above + charge / cell.cm


@jit
def plan_search(cell: Record) -> None:
    """Set the time until which the neuron surely does not fire, left alone.

    Its voltage stays below the course towards what the largest current to come would lead to, and
    that course is concave: it takes at least the same share of a time constant as of the way.
    """
    strongest = max(0.0, cell.x_e + max(0.0, cell.s_e) * cell.tau_syn_E / e)
    strongest += max(0.0, cell.x_i + max(0.0, cell.s_i) * cell.tau_syn_I / e)
    ceiling = settled_voltage(cell) + strongest * cell.tau_m / cell.cm
    cell.on_wake = SEARCH
    cell.wake = inf
    if ceiling > cell.threshold:
        voltage = cell.path[0, 0]
        cell.wake = cell.t + cell.tau_m * (cell.threshold - voltage) / (ceiling - voltage)


@jit
def search(cell: Record, work: Record) -> None:
    """Set the time of the next spike of a neuron that is left alone."""
    settled, c = settled_voltage(cell), work.function
    c[SETTLED], c[ABOVE] = settled - cell.threshold, cell.path[0, 0] - settled
    c[TAU_M], c[CM] = cell.tau_m, cell.cm
    c[TAU_E], c[X_E], c[S_E] = cell.tau_syn_E, cell.x_e, cell.s_e
    c[TAU_I], c[X_I], c[S_I] = cell.tau_syn_I, cell.x_i, cell.s_i
    until = _LONG * max(cell.tau_m, max(cell.tau_syn_E, cell.tau_syn_I))
    cell.on_wake = FIRE
    cell.wake = cell.t + first_rise(RESPONSE, work, until)
