"""The equations of the membranes that are integrated numerically (PyNN's standard cells).

Conductance-based integrate-and-fire; adaptive exponential (Brette & Gerstner 2005, J Neurophysiol
94:3637); Izhikevich (2003, IEEE Trans Neural Netw 14:1569); Hodgkin-Huxley with the rates of Traub &
Miles (1991, Neuronal Networks of the Hippocampus).
"""

from __future__ import annotations

from math import exp, expm1
from typing import Final

from nrp_brain_event.records import ADAPTIVE_EXPONENTIAL, CONDUCTANCE, HODGKIN_HUXLEY, Cell, Work
from nrp_core._support.jit import inlined, jit

_PER_NA: Final = 1000.0
"""PyNN's factor between nA and the unit of current of Izhikevich's model."""
_STEEPEST: Final = 200.0
"""Maximum exponent in a spike's upstroke: an integration step is refused well below it."""


@inlined
def slopes(cell: Cell, work: Work, s: int) -> None:
    """Store the derivatives of the state variables at stage s of a step, per ms, in ``work.stages``.

    The state is ``work.y``: v in mV, then w in nA, or u in mV/ms, or the gates m, h, n. The conductances of
    the synapses at that stage are in ``work.conductances``.
    """
    y, g, out = work.y, work.conductances, work.stages
    v = y[0]
    current = g[s, 0] * (cell.e_rev_E - v) + g[s, 1] * (cell.e_rev_I - v) + cell.i_offset + cell.current
    if cell.membrane == CONDUCTANCE:
        out[s, 0] = (cell.v_rest - v) * cell.leak + current * cell.per_cm
    elif cell.membrane == ADAPTIVE_EXPONENTIAL:
        _adaptive_exponential(cell, current, work, s)
    elif cell.membrane == HODGKIN_HUXLEY:
        _hodgkin_huxley(cell, current, work, s)
    else:
        out[s, 0] = (0.04 * v + 5.0) * v + 140.0 - y[1] + _PER_NA * current
        out[s, 1] = cell.a * (cell.b * v - y[1])
    if cell.t < cell.free_at:
        out[s, 0] = 0.0


@jit
def _adaptive_exponential(cell: Cell, current: float, work: Work, s: int) -> None:
    v, w = work.y[0], work.y[1]
    above_rest = v - cell.v_rest
    upstroke = 0.0
    if cell.delta_T > 0.0:
        upstroke = cell.delta_T * exp(min((v - cell.v_thresh) / cell.delta_T, _STEEPEST))
    work.stages[s, 0] = (upstroke - above_rest) * cell.leak + (current - w) * cell.per_cm
    work.stages[s, 1] = (cell.a * 1e-3 * above_rest - w) / cell.tau_w  # a is in nS


@jit
def _hodgkin_huxley(cell: Cell, current: float, work: Work, s: int) -> None:
    y, out = work.y, work.stages
    v, m, h, n = y[0], y[1], y[2], y[3]
    sodium = cell.gbar_Na * m * m * m * h * (cell.e_rev_Na - v)
    potassium = cell.gbar_K * n * n * n * n * (cell.e_rev_K - v)
    leak = cell.g_leak * (cell.e_rev_leak - v)
    out[s, 0] = (sodium + potassium + leak + current) * cell.per_cm
    for gate in range(1, 4):
        opening, closing = gate_rates(gate, v - cell.v_offset)
        out[s, gate] = opening * (1.0 - y[gate]) - closing * y[gate]


@jit
def gate_rates(gate: int, v: float) -> tuple[float, float]:
    """Return the opening and closing rates, per ms, of gate m (1), h (2) or n (3) at ``v`` mV."""
    if gate == 1:
        return 0.32 * _linear_over_exponential(13.0 - v, 4.0), 0.28 * _linear_over_exponential(v - 40.0, 5.0)
    if gate == 2:
        return 0.128 * exp((17.0 - v) / 18.0), 4.0 / (exp((40.0 - v) / 5.0) + 1.0)
    return 0.032 * _linear_over_exponential(15.0 - v, 5.0), 0.5 * exp((10.0 - v) / 40.0)


@jit
def _linear_over_exponential(x: float, scale: float) -> float:
    """Return ``x / (exp(x / scale) - 1)`` and its limit at 0."""
    if x == 0.0:
        return scale
    return x / expm1(x / scale)
