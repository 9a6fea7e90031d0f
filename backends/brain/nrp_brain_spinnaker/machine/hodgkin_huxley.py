"""The Hodgkin-Huxley membrane of Traub & Miles, PyNN's HH_cond_exp, in the machine's arithmetic.

Not part of the machine's software. Gates are fractions in units of 2**-30; gates and voltage are updated
alternately by the trapezoidal rule. A spike is an upward crossing of -20 mV. ``V`` is the voltage for other
code, ``V_FINE`` has more bits.
"""

from __future__ import annotations

from typing import Final

from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.fixed_point import ONE, clamp, exp_accum, mul
from nrp_brain_spinnaker.machine.kinds import Cells, note_spike
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import jit

OPEN: Final = 1 << 30
"""A gate that is fully open."""
FINE_BITS: Final = 12
"""Additional bits of the voltage beyond s16.15: in a short step it changes by less than 2**-15 mV."""
LIFT_BITS: Final = 20
"""Binary point of the change of voltage by 1 nA in a step."""
_THRESHOLD: Final = -20 * ONE


@jit
def update_hodgkin_huxley(cells: Cells, population: int) -> None:
    """Advance a population by a (sub-)step."""
    first, last = cells.populations[population, kinds.FIRST], cells.populations[population, kinds.LAST]
    state = cells.state
    for i in range(first, last):
        v = state[kinds.V, i]
        _move_gates(state, i, v - cells.constants[kinds.V_OFFSET, i], cells.constants[kinds.STEP, i])
        state[kinds.V_FINE, i] += _voltage_change(cells.constants, state, i, cells.drive[i])
        state[kinds.V, i] = state[kinds.V_FINE, i] >> FINE_BITS
        if v < _THRESHOLD <= state[kinds.V, i]:
            note_spike(cells, i)


@jit
def gate_rates(u: int) -> tuple[int, int, int, int, int, int]:
    """Return opening and closing rates (1/ms) of m, h and n, all s16.15, at ``u`` mV above the offset."""
    return (
        _linear_over_exp(13 * ONE - u, 4, 10486),
        _linear_over_exp(u - 40 * ONE, 5, 9175),
        mul(4194, exp_accum((17 * ONE - u) // 18)),
        4 * ONE * ONE // (ONE + exp_accum((40 * ONE - u) // 5)),
        _linear_over_exp(15 * ONE - u, 5, 1049),
        mul(16384, exp_accum((10 * ONE - u) // 40)),
    )


@jit
def _linear_over_exp(x: int, width: int, factor: int) -> int:
    """Return ``factor x / (exp(x / width) - 1)``, continued at 0."""
    if abs(x) < ONE >> 2:
        return mul(factor, width * ONE - (x >> 1))
    return mul(factor, clamp((x << 15) // (exp_accum(x // width) - ONE)))


@jit
def _move_gates(state: IntArray, i: int, u: int, step: int) -> None:
    open_m, close_m, open_h, close_h, open_n, close_n = gate_rates(u)
    state[kinds.GATE_M, i] = _moved(state[kinds.GATE_M, i], open_m * step, close_m * step)
    state[kinds.GATE_H, i] = _moved(state[kinds.GATE_H, i], open_h * step, close_h * step)
    state[kinds.GATE_N, i] = _moved(state[kinds.GATE_N, i], open_n * step, close_n * step)


@jit
def _moved(gate: int, opening: int, closing: int) -> int:
    """Take a trapezoidal step; rates times step are fractions in units of 2**-30."""
    half = (opening + closing) >> 1
    return (((gate * (OPEN - half)) >> 30) + opening) * OPEN // (OPEN + half)


@jit
def _voltage_change(constants: IntArray, state: IntArray, i: int, drive: int) -> int:
    """Return the change of the fine voltage in a step; conductances (uS) and currents (nA) have 30 bits."""
    m, h, n = state[kinds.GATE_M, i], state[kinds.GATE_H, i], state[kinds.GATE_N, i]
    squared_m, squared_n, v = (m * m) >> 30, (n * n) >> 30, state[kinds.V, i]
    sodium = (constants[kinds.G_SODIUM, i] * ((((squared_m * m) >> 30) * h) >> 30)) >> 15
    potassium = (constants[kinds.G_POTASSIUM, i] * ((squared_n * squared_n) >> 30)) >> 15
    leak, lift = constants[kinds.G_LEAK, i] << 15, constants[kinds.LIFT, i]
    inward = sodium * (constants[kinds.E_SODIUM, i] - v)
    outward = potassium * (constants[kinds.E_POTASSIUM, i] - v) + leak * (constants[kinds.E_LEAK, i] - v)
    current = (drive << 15) + ((inward + outward) >> 15)
    brake = ONE + ((((sodium + potassium + leak) >> 15) * lift) >> (LIFT_BITS + 1))
    change = (current * lift) >> (30 + LIFT_BITS - 15 - FINE_BITS)
    return int((change << 15) // brake)
