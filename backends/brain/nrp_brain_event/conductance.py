"""A membrane with exponential conductances, by its integrating factor and Gaussian quadrature.

Between two events ``v' = d - a (v - v0)``, where the rate a and the drive d at the voltage v0 of the last
event are sums of a constant and two exponentials. With P the integral of a, which has a closed form::

    v(t) = v0 + integral from 0 to t of exp(P(s) - P(t)) d(s) ds

Five nodes integrate polynomials of degree 9. With D the largest drive and ``r = a(0) + 2 / tau_syn``, with
the shorter of the two time constants, the error of a step h is below ``1e-12 r**10 D h**11``: the factor of
the tenth derivative is 3.9e-13 (Abramowitz & Stegun 25.4.30).

A step in which the voltage may reach the threshold is left to :mod:`nrp_brain_event.runge_kutta`.
"""

from __future__ import annotations

from math import exp
from typing import Final

import numpy as np

from nrp_brain_event.records import CONDUCTANCE, EXPONENTIAL, Cell
from nrp_core._support.jit import inlined, jit

INTEGRAL: Final = 0.0
"""The length of a step whose voltage is an integral, not a polynomial."""
_ORDER: Final = 5
_NODES: Final = (np.polynomial.legendre.leggauss(_ORDER)[0] + 1.0) / 2.0
_WEIGHTS: Final = np.polynomial.legendre.leggauss(_ORDER)[1] / 2.0
_ERROR: Final = 1e-12
_DIVISOR: Final = 4.0
"""How much shorter the second attempt is, if the voltage may reach the threshold in the first."""


@jit
def voltage_after(cell: Cell, dt: float) -> float:
    """Return the voltage (mV) of a cell that was not held ``dt`` ms after its last event."""
    v = cell.path[0, 0]
    g_e, g_i = cell.x[0] * cell.per_cm, cell.x[1] * cell.per_cm
    e_e, e_i = g_e * (cell.e_rev_E - v), g_i * (cell.e_rev_I - v)
    rest = cell.leak * (cell.v_rest - v) + (cell.i_offset + cell.current) * cell.per_cm
    all_e, all_i = g_e / cell.fading[0], g_i / cell.fading[1]
    whole = (
        cell.leak * dt + all_e * (1.0 - exp(-dt * cell.fading[0])) + all_i * (1.0 - exp(-dt * cell.fading[1]))
    )
    drive = 0.0
    for node in range(_ORDER):
        s = _NODES[node] * dt
        left_e, left_i = exp(-s * cell.fading[0]), exp(-s * cell.fading[1])
        until = cell.leak * s + all_e * (1.0 - left_e) + all_i * (1.0 - left_i)
        drive += _WEIGHTS[node] * exp(until - whole) * (rest + e_e * left_e + e_i * left_i)
    return float(v + dt * drive)


@inlined
def is_integral(cell: Cell) -> bool:
    """Return whether a cell can take such steps; its conductances are 0 or more."""
    exponential = cell.membrane == CONDUCTANCE and cell.synapse == EXPONENTIAL
    return bool(cell.quadrature and exponential and cell.x[0] >= 0.0 and cell.x[1] >= 0.0)


@jit
def length_below_threshold(cell: Cell) -> float:
    """Return the length (ms) of a step in which the voltage stays below the threshold; 0 if none is known."""
    v = cell.path[0, 0]
    g_e, g_i = cell.x[0] * cell.per_cm, cell.x[1] * cell.per_cm
    rest = cell.leak * (cell.v_rest - v) + (cell.i_offset + cell.current) * cell.per_cm
    drive = abs(rest) + abs(g_e * (cell.e_rev_E - v)) + abs(g_i * (cell.e_rev_I - v))
    fading = max(cell.fading[0] if g_e > 0.0 else 0.0, cell.fading[1] if g_i > 0.0 else 0.0)
    rate = cell.leak + g_e + g_i + 2.0 * fading
    step = cell.longest_step
    if drive > 0.0:
        step = min(step, (cell.tolerance / (_ERROR * drive * rate)) ** (1.0 / 11.0) / rate)
    if _stays_below(cell, step):
        return float(step)
    step /= _DIVISOR
    return float(step) if _stays_below(cell, step) else 0.0


@inlined
def _stays_below(cell: Cell, step: float) -> bool:
    """Return whether a bound on the voltage within a step is below the threshold.

    ``u = v - threshold`` obeys ``u' <= Q - a u`` with the largest Q of the step: each conductance counts at
    its start if its current at the threshold raises the voltage, else at its end.
    """
    left_e, left_i = exp(-step * cell.fading[0]), exp(-step * cell.fading[1])
    g_e, g_i = cell.x[0] * cell.per_cm, cell.x[1] * cell.per_cm
    at = cell.threshold
    up_e, up_i = g_e * (cell.e_rev_E - at), g_i * (cell.e_rev_I - at)
    q = cell.leak * (cell.v_rest - at) + (cell.i_offset + cell.current) * cell.per_cm
    q += (up_e if up_e > 0.0 else up_e * left_e) + (up_i if up_i > 0.0 else up_i * left_i)
    if q <= 0.0:
        return True
    whole = cell.leak * step + g_e / cell.fading[0] * (1.0 - left_e) + g_i / cell.fading[1] * (1.0 - left_i)
    return bool((cell.path[0, 0] - at) * exp(-whole) + q * step < 0.0)
