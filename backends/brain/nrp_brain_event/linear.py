"""Membranes whose equation has a closed-form solution.

They are IF_curr_exp, IF_curr_alpha and IF_curr_delta, and IF_cond_exp and IF_cond_alpha without input.

A neuron is advanced from event to event. After each event a cheap bound gives a time before which it cannot
fire; only if nothing arrives until then is its next spike computed. Both depend only on the state at the
event, not on the division of the run.

Integrate-and-fire neurons with exponential currents, or with jumps of the voltage, as sums of exponentials.

Between two events the voltage is ``settled + m exp(-u/tau_m) + sum of x_k reach_k exp(-u/tau_k)``, where u
is the time since a fixed moment, the beginning of an epoch. Waiting changes none of the coefficients, and an
arriving spike only adds to them. So the exponentials of an arrival are computed once for all neurons of a
kind that it reaches. Epochs are short, so that the coefficients neither overflow nor lose digits. A jump
changes only the coefficient of the membrane; the currents of such a neuron stay zero.

The state of such a neuron is its coefficients. For all that is rarer than an arrival, :func:`thaw` brings its
:class:`~nrp_brain_event.records.Cell` up to date, and :func:`freeze` takes the coefficients from it again.
"""

from __future__ import annotations

from math import e, exp, floor, inf, nan
from typing import Final

import numpy as np

from nrp_brain_event import rise
from nrp_brain_event.records import (
    CONDUCTANCE,
    EXPONENTIAL,
    FIRE,
    JUMP,
    LINEAR,
    SEARCH,
    Array,
    Cell,
    Kind,
    Modes,
    Work,
)
from nrp_brain_event.rise import charge, left_of, silent
from nrp_brain_event.synapse_kernels import SIMULTANEOUS
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


_EPOCH: Final = 16.0
"""Maximum length of an epoch, in time constants."""
_DISTINCT: Final = 0.1
"""Relative difference of time constants below which the coefficients would cancel each other."""
_ROUNDING_MV: Final = 1e-12
"""Distance from the threshold at which a jump reaches it: weights often add up to it, but for rounding."""


def modes_of(cells: Array) -> tuple[Array, Array]:
    """Return the coefficients of all neurons from their records, and their kinds."""
    fits, own = _parameters(cells)
    codes, first = np.zeros(len(own), np.int64), np.zeros(min(len(own), 1), np.int64)
    for values in own.T:
        _, one = np.unique(values, return_inverse=True)
        _, first, codes = np.unique(codes * len(own) + one, return_index=True, return_inverse=True)
    kinds = _kinds(own[first])
    modes = np.zeros(len(cells), Modes.dtype())
    modes["kind"] = -1
    modes[fits] = _coefficients(cells[fits], kinds[codes])
    modes["kind"][fits] = codes
    return modes, kinds


def _coefficients(cells: Array, kind: Array) -> Array:
    """Return the coefficients of neurons, given the kind of each."""
    modes = np.zeros(len(cells), Modes.dtype())
    for name in ("t", "wake", "on_wake", "listed"):
        modes[name] = cells[name]
    modes["settled"] = cells["v_rest"] + (cells["i_offset"] + cells["current"]) * cells["resistance"]
    since = modes["t"] - np.floor(modes["t"] / kind["epoch"]) * kind["epoch"]
    modes["x_e"] = cells["x"][:, 0] * np.exp(since * kind["rate_e"])
    modes["x_i"] = cells["x"][:, 1] * np.exp(since * kind["rate_i"])
    driven = cells["x"][:, 0] * kind["reach_e"] + cells["x"][:, 1] * kind["reach_i"]
    above = cells["path"][:, 0, 0] - modes["settled"] - driven
    held = modes["t"] < cells["free_at"]
    modes["membrane"] = np.where(held, np.nan, above * np.exp(since * kind["rate_m"]))
    return modes


def _parameters(cells: Array) -> tuple[Array, Array]:
    """Return which neurons can be represented, and their time constants, capacitances and thresholds."""
    taus = np.column_stack([cells["tau_m"], cells["tau_syn"]])
    gaps = abs(taus[:, 1:] - taus[:, :1])
    distinct = (gaps > _DISTINCT * np.maximum(taus[:, 1:], taus[:, :1])).all(axis=1)
    jumps = cells["synapse"] == JUMP
    taus[jumps, 1:] = inf
    fits = (cells["membrane"] == LINEAR) & (jumps | ((cells["synapse"] == EXPONENTIAL) & distinct))
    return fits, np.column_stack([taus, cells["cm"], cells["threshold"]])[fits]


def _kinds(parameters: Array) -> Array:
    kinds = np.zeros(len(parameters), Kind.dtype())
    taus, cm = parameters[:, :3], parameters[:, 3]
    kinds["tau_m"], kinds["threshold"], kinds["resistance"] = taus[:, 0], parameters[:, 4], taus[:, 0] / cm
    kinds["rate_m"], kinds["rate_e"], kinds["rate_i"] = 1.0 / taus.T
    for k in "ei":
        reach = 1.0 / (cm * (kinds["rate_m"] - kinds[f"rate_{k}"]))
        kinds[f"reach_{k}"] = np.where(np.isinf(taus[:, 1]), 0.0, reach)
    kinds["epoch"] = np.exp2(np.floor(np.log2(_EPOCH * taus.min(axis=1, initial=np.inf))))
    kinds["t"] = -1.0
    return kinds


@inlined
def jumps(kind: Kind) -> bool:
    """Return whether a spike changes the voltage at once, by its weight in mV; the currents stay zero."""
    return kind.reach_e == 0.0


@jit
def set_time(kind: Kind, t: float) -> None:
    """Compute the factors of a kind of cell at t."""
    kind.t, kind.begin = t, _begin(kind, t)
    since = kind.begin - t
    kind.left_m = exp(since * kind.rate_m)
    if jumps(kind):
        kind.left_e = kind.left_i = 1.0
        kind.step_e = kind.step_i = -1.0 / kind.left_m
        return
    kind.left_e = exp(since * kind.rate_e)
    kind.left_i = kind.left_e if kind.rate_i == kind.rate_e else exp(since * kind.rate_i)
    kind.step_e, kind.step_i = kind.reach_e / kind.left_m, kind.reach_i / kind.left_m
    kind.grown_e, kind.grown_i = 1.0 / kind.left_e, 1.0 / kind.left_i


@inlined
def deliver(modes: Modes, kind: Kind, cell: Cell, inhibitory: int, weight: float) -> None:
    """Deliver a spike at the time of the kind to a neuron that has no event before it, and plan the next."""
    if modes.t < kind.begin:  # a new epoch
        since = _begin(kind, modes.t) - kind.begin
        modes.membrane *= exp(since * kind.rate_m)
        modes.x_e *= exp(since * kind.rate_e)
        modes.x_i *= exp(since * kind.rate_i)
    modes.t = kind.t
    if inhibitory:
        modes.x_i += weight * kind.grown_i
        modes.membrane -= weight * kind.step_i
    else:
        modes.x_e += weight * kind.grown_e
        modes.membrane -= weight * kind.step_e
    if modes.membrane == modes.membrane:  # not in its refractory period
        slack = _ROUNDING_MV if jumps(kind) else 0.0
        _wait_modes(modes, kind, kind.t, kind.left_m, kind.left_e, kind.left_i, slack)
    elif jumps(kind) and cell.free_at - kind.t <= SIMULTANEOUS:
        cell.path[0, 0] += weight


@jit
def postpone(modes: Modes, kind: Kind, cell: Cell) -> bool:
    """Postpone the search for a spike, if the neuron is far from its threshold.

    Returns:
        False if something is to be done now; the record of the neuron is up to date then.
    """
    if modes.on_wake == SEARCH:
        t = modes.wake
        since = _begin(kind, modes.t) - t
        _wait_modes(
            modes, kind, t, exp(since * kind.rate_m), exp(since * kind.rate_e), exp(since * kind.rate_i), 0.0
        )
        if modes.wake > t + NEAR * kind.tau_m:
            return True
        modes.on_wake, modes.wake = SEARCH, t
    thaw(modes, kind, cell)
    return False


@inlined
def _wait_modes(
    modes: Modes, kind: Kind, t: float, left_m: float, left_e: float, left_i: float, slack: float
) -> None:
    """Schedule the search for a spike of a neuron: as :func:`nrp_brain_event.linear.plan_search`."""
    x_e, x_i = modes.x_e * left_e, modes.x_i * left_i
    voltage = modes.settled + modes.membrane * left_m + x_e * kind.reach_e + x_i * kind.reach_i
    ceiling = modes.settled + (max(0.0, x_e) + max(0.0, x_i)) * kind.resistance
    modes.on_wake, modes.wake = SEARCH, inf
    if voltage >= kind.threshold - slack:
        modes.on_wake, modes.wake = FIRE, t
    elif ceiling > kind.threshold:
        modes.wake = t + kind.tau_m * (kind.threshold - voltage) / (ceiling - voltage)


@jit
def voltage_of(modes: Modes, kind: Kind, cell: Cell, t: float) -> float:
    """Return the voltage at a time before the next event."""
    if modes.membrane != modes.membrane:
        return float(cell.path[0, 0])
    since = _begin(kind, modes.t) - t
    driven = modes.x_e * kind.reach_e * exp(since * kind.rate_e)
    driven += modes.x_i * kind.reach_i * exp(since * kind.rate_i)
    return float(modes.settled + modes.membrane * exp(since * kind.rate_m) + driven)


@jit
def thaw(modes: Modes, kind: Kind, cell: Cell) -> None:
    """Bring the record of a neuron up to date."""
    cell.path[0, 0] = voltage_of(modes, kind, cell, modes.t)
    since = _begin(kind, modes.t) - modes.t
    cell.x[0] = modes.x_e * exp(since * kind.rate_e)
    cell.x[1] = modes.x_i * exp(since * kind.rate_i)
    cell.t, cell.wake, cell.on_wake = modes.t, modes.wake, modes.on_wake


@jit
def freeze(modes: Modes, kind: Kind, cell: Cell) -> None:
    """Continue from the record of a neuron, which has changed."""
    if kind.t != cell.t:
        set_time(kind, cell.t)
    modes.settled = settled_voltage(cell)
    modes.x_e, modes.x_i = cell.x[0] * kind.grown_e, cell.x[1] * kind.grown_i
    above = cell.path[0, 0] - modes.settled - cell.x[0] * kind.reach_e - cell.x[1] * kind.reach_i
    modes.membrane = above / kind.left_m if cell.t >= cell.free_at else nan
    modes.t, modes.wake, modes.on_wake = cell.t, cell.wake, cell.on_wake


@inlined
def _begin(kind: Kind, t: float) -> float:
    """Return the beginning of the epoch of a time."""
    return floor(t / kind.epoch) * kind.epoch
