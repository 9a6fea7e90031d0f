"""One neuron through one window: what arrives and when it wakes, in the order of time."""

from __future__ import annotations

from math import inf
from typing import Final

from nrp_core.jit import jit

from nrp_brain_event.agenda import release
from nrp_brain_event.linear import linear_voltage, plan_search, search
from nrp_brain_event.records import (
    ADAPTIVE_EXPONENTIAL, HODGKIN_HUXLEY, IZHIKEVICH, JUMP, LINEAR, SEARCH, FIRE, START, Array, Record,
)  # fmt: skip
from nrp_brain_event.runge_kutta import rise_within_step, stand_at, state_at, take_step
from nrp_brain_event.synapses import excite, fade, inhibit

_SIMULTANEOUS: Final = 1e-9
"""ms by which times that are equal on paper may differ in floating point."""


@jit
def advance(cell: Record, clock: Record, events: Array, work: Record, end: float) -> bool:
    """Take a neuron to the end of the window, or to its next spike: then it wakes with ``FIRE`` before ``end``.

    Returns:
        False where its equations cannot be integrated.
    """
    while True:
        arrival = events[cell.arrivals].time if cell.arrivals >= 0 else inf
        if min(arrival, cell.wake) >= end:
            return True
        if arrival < cell.wake:
            move(cell, arrival)
            _receive(cell, clock, events)
        elif cell.on_wake == FIRE:
            return True
        elif cell.on_wake == SEARCH:
            search(cell, work)
            continue
        else:
            move(cell, cell.wake)
        if not _begin(cell, work):
            return False


@jit
def move(cell: Record, t: float) -> None:
    """Bring the state of a neuron to a time at which nothing has happened yet."""
    dt = t - cell.t
    if cell.membrane != LINEAR:
        stand_at(cell, t)
    elif cell.t >= cell.free_at:
        cell.path[0, 0] = linear_voltage(cell, dt)
    fade(cell, dt)
    cell.t = t


@jit
def voltage_at(cell: Record, t: float) -> float:
    """Return the voltage at a time up to which nothing happens, without moving the neuron."""
    if cell.membrane != LINEAR:
        return state_at(cell, 0, t)
    return cell.path[0, 0] if cell.t < cell.free_at else linear_voltage(cell, t - cell.t)


@jit
def fire(cell: Record) -> None:
    """Let a neuron that wakes with ``FIRE`` fire: reset it and begin its refractory time."""
    move(cell, cell.wake)
    if cell.membrane == IZHIKEVICH:
        cell.path[0, 0] = cell.c
        cell.path[1, 0] += cell.d
    elif cell.membrane == HODGKIN_HUXLEY:
        cell.path[0, 0] = cell.threshold  # nothing is reset: it has to fall before it can rise again
        cell.armed = 0
    else:
        cell.path[0, 0] = cell.v_reset
        if cell.membrane == ADAPTIVE_EXPONENTIAL:
            cell.path[1, 0] += cell.b
    cell.free_at = cell.t + cell.tau_refrac
    cell.on_wake, cell.wake = START, cell.t


@jit
def _receive(cell: Record, clock: Record, events: Array) -> None:
    """Take in everything that arrives now."""
    while cell.arrivals >= 0 and events[cell.arrivals].time <= cell.t:
        event = events[cell.arrivals]
        if cell.synapse == JUMP:
            if cell.free_at - cell.t <= _SIMULTANEOUS:  # else the voltage is held
                cell.path[0, 0] += event.weight
        elif event.receptor == 0:
            excite(cell, event.weight)
        else:
            inhibit(cell, event.weight)
        release(clock, events, cell)


@jit
def _begin(cell: Record, work: Record) -> bool:
    """Plan what follows an event: when the neuron wakes, and what for."""
    held = cell.t < cell.free_at
    if not held and cell.path[0, 0] >= cell.threshold:
        if cell.armed:
            cell.on_wake, cell.wake = FIRE, cell.t
            return True
    elif not held:
        cell.armed = 1
    if cell.membrane != LINEAR:
        return _integrate(cell, work, held)
    if held:
        cell.on_wake, cell.wake = START, cell.free_at
    else:
        plan_search(cell)
    return True


@jit
def _integrate(cell: Record, work: Record, held: bool) -> bool:
    if not take_step(cell, work):
        return False
    if not held:
        rise = rise_within_step(cell, work)
        if rise <= cell.wake:
            cell.on_wake, cell.wake = FIRE, rise
    return True
