"""The operations on one neuron: advance it, deliver a spike, fire, schedule its next update."""

from __future__ import annotations

from nrp_brain_event.linear import is_linear, linear_voltage, plan_search
from nrp_brain_event.records import (
    ADAPTIVE_EXPONENTIAL,
    FIRE,
    FROZEN,
    HODGKIN_HUXLEY,
    IZHIKEVICH,
    JUMP,
    START,
    Cell,
    Work,
)
from nrp_brain_event.rise import arrive, fade, left_of
from nrp_brain_event.runge_kutta import rise_within_step, stand_at, state_at, take_step
from nrp_brain_event.synapse_kernels import SIMULTANEOUS
from nrp_core._support.jit import inlined, jit


@inlined
def move(cell: Cell, t: float) -> None:
    """Advance the state of a neuron to a time before its next event."""
    dt = t - cell.t
    left_e, left_i = left_of(cell, 0, dt), left_of(cell, 1, dt)
    if not is_linear(cell):
        stand_at(cell, t)
    elif cell.t >= cell.free_at:
        cell.path[0, 0] = linear_voltage(cell, dt, left_e, left_i)
    fade(cell, 0, dt, left_e)
    fade(cell, 1, dt, left_i)
    cell.t = t


@jit
def voltage_at(cell: Cell, t: float) -> float:
    """Return the voltage at a time before the next event, without advancing the neuron."""
    if is_linear(cell) and cell.t >= cell.free_at:
        dt = t - cell.t
        return linear_voltage(cell, dt, left_of(cell, 0, dt), left_of(cell, 1, dt))
    return state_at(cell, 0, t)


@jit
def fire(cell: Cell) -> None:
    """Fire a neuron at its scheduled time: reset it and start its refractory period."""
    move(cell, cell.wake)
    if cell.membrane == HODGKIN_HUXLEY:
        cell.path[0, 0] = cell.threshold  # without a reset it must fall before it can cross again
        cell.armed = 0
    elif cell.membrane == IZHIKEVICH:
        cell.path[0, 0] = cell.c
        cell.path[1, 0] += cell.d
    else:
        cell.path[0, 0] = cell.v_reset
        if cell.membrane == ADAPTIVE_EXPONENTIAL:
            cell.path[1, 0] += cell.b
        elif cell.synapse == FROZEN:
            cell.x[0] = cell.x[1] = 0.0
    cell.free_at = cell.t + cell.tau_refrac
    cell.on_wake, cell.wake = START, cell.t


@inlined
def receive(cell: Cell, inhibitory: int, weight: float) -> None:
    """Deliver a spike now."""
    if cell.synapse < JUMP:
        arrive(cell, inhibitory, weight)
    elif cell.free_at - cell.t <= SIMULTANEOUS:  # else the voltage is clamped, or everything is frozen
        if cell.synapse == JUMP:
            cell.path[0, 0] += weight
        else:
            cell.x[inhibitory] += weight / cell.resistance


@inlined
def plan(cell: Cell, work: Work) -> bool:
    """Schedule a neuron's next update after an event; False if it cannot be computed."""
    held = cell.t < cell.free_at
    if not held:
        above = cell.path[0, 0] >= cell.threshold
        if above and cell.armed:
            cell.on_wake, cell.wake = FIRE, cell.t
            return True
        if not above:
            cell.armed = 1
    if not is_linear(cell):
        return _integrate(cell, work, held)
    if held:
        cell.on_wake, cell.wake = START, cell.free_at
    else:
        plan_search(cell)
    return True


@jit
def _integrate(cell: Cell, work: Work, held: bool) -> bool:
    if not take_step(cell, work):
        return False
    if not held:
        rise = rise_within_step(cell, work)
        if rise <= cell.wake:
            cell.on_wake, cell.wake = FIRE, rise
    return True
