"""The membranes: leaky integrate-and-fire and Izhikevich, in the rounding order of the released binaries.

An update takes the current in ``cells.drive``, advances each membrane by one (sub-)step and stores the
neurons that crossed the threshold. A crossing is ``V >= threshold``, tested in every step, refractory or not.

The adaptive exponential membrane (Brette & Gerstner 2005, J Neurophysiol 94:3637), in fixed point.

Not part of the machine's software. The exponential current is held over a step, as conductances are, so
steps are short; therefore decays have 32 bits and the adaptation current is kept as 1024 times its value.

The list of neurons that spiked.

The Hodgkin-Huxley membrane of Traub & Miles, PyNN's HH_cond_exp, in the machine's arithmetic.

Not part of the machine's software. Gates are fractions in units of 2**-30; gates and voltage are updated
alternately by the trapezoidal rule. A spike is an upward crossing of -20 mV. ``V`` is the voltage for other
code, ``V_FINE`` has more bits.
"""

from __future__ import annotations

from typing import Final

from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.fixed_point import HALF, ONE, clamp, exp_accum, mul, scale, wrap
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import jit


@jit
def note_spike(cells: Cells, i: int) -> None:
    """Add neuron ``i`` to the list of neurons that spiked in this tick."""
    cells.fired[cells.n_fired[0]] = i
    cells.n_fired[0] += 1


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


_STEEPEST: Final = 8 * ONE
"""Maximum argument of the exponential; it suffices to cross any threshold in one step."""


@jit
def update_adaptive(cells: Cells, population: int) -> None:
    """Advance a population by a (sub-)step."""
    first, last = cells.populations[population, kinds.FIRST], cells.populations[population, kinds.LAST]
    state, constants = cells.state, cells.constants
    for i in range(first, last):
        v, w = state[kinds.V, i], state[kinds.W, i]
        above = wrap(v - constants[kinds.V_REST, i])
        settled_w = mul(constants[kinds.ADAPTATION, i], above)
        state[kinds.W, i] = wrap(settled_w + scale(wrap(w - settled_w), constants[kinds.ADAPTATION_DECAY, i]))
        if state[kinds.REFRACTORY, i] > 0:
            state[kinds.REFRACTORY, i] -= 1
        else:
            steepness = mul(wrap(v - constants[kinds.V_SOFT, i]), constants[kinds.INVERSE_SLOPE, i])
            spike = mul(constants[kinds.SLOPE, i], exp_accum(min(steepness, _STEEPEST)))
            driven = mul(wrap(cells.drive[i] - (w >> 10)), constants[kinds.R_MEMBRANE, i])
            settled = wrap(constants[kinds.V_REST, i] + driven + spike)
            v = wrap(settled + scale(wrap(v - settled), constants[kinds.MEMBRANE_DECAY, i]))
        if v >= constants[kinds.V_THRESH, i]:
            v = constants[kinds.V_RESET, i]
            state[kinds.W, i] = wrap(state[kinds.W, i] + constants[kinds.ADAPTATION_JUMP, i])
            state[kinds.REFRACTORY, i] = constants[kinds.T_REFRACTORY, i]
            note_spike(cells, i)
        state[kinds.V, i] = v


_IZK_SQUARE = 1311
"""0.04, as the constant 0.040008544921875 of the Izhikevich code."""
_IZK_LINEAR = 5 * ONE
_IZK_CONSTANT = 140 * ONE
_IZK_THRESHOLD = 30 * ONE
_IZK_LONGER = 60620
"""1.85, the factor of the step after a spike, which corrects for crossings between ticks."""


@jit
def gather_currents(cells: Cells, population: int) -> None:
    """Sum the currents into each membrane in ``cells.drive``."""
    first, last = cells.populations[population, kinds.FIRST], cells.populations[population, kinds.LAST]
    kind = cells.populations[population, kinds.INPUT]
    excitatory, inhibitory = cells.value[0], cells.value[1]
    v, constants = cells.state[kinds.V], cells.constants
    for i in range(first, last):
        plus, minus = excitatory[i], inhibitory[i]
        if kind == kinds.CONDUCTANCE:
            plus = mul(plus >> 10, wrap(constants[kinds.E_REV_E, i] - v[i]))
            minus = mul(-(minus >> 10), wrap(constants[kinds.E_REV_I, i] - v[i]))
        elif kind == kinds.FINE_CONDUCTANCE:  # keeps ten bits that the machine drops
            plus = wrap((plus * (constants[kinds.E_REV_E, i] - v[i])) >> 25)
            minus = -wrap((minus * (constants[kinds.E_REV_I, i] - v[i])) >> 25)
        elif kind == kinds.IMPULSE:
            gain = constants[kinds.IMPULSE_GAIN, i]
            plus, minus = mul(plus, gain), mul(minus, gain)
        elif kind == kinds.JUMP:  # above the threshold the square would overflow
            v[i] = min(v[i] + plus - minus, max(v[i], _IZK_THRESHOLD))
            plus, minus = 0, 0
        cells.drive[i] = wrap(plus - minus + constants[kinds.I_OFFSET, i] + cells.current[i])


@jit
def update_neurons(cells: Cells, population: int) -> None:
    """Advance the membranes of a population by a (sub-)step."""
    kind = cells.populations[population, kinds.NEURON]
    if kind == kinds.LIF:
        _update_lif(cells, population)
    elif kind == kinds.IZHIKEVICH:
        _update_izhikevich(cells, population)
    elif kind == kinds.ADAPTIVE_EXPONENTIAL:
        update_adaptive(cells, population)
    else:
        update_hodgkin_huxley(cells, population)


@jit
def _update_lif(cells: Cells, population: int) -> None:
    first, last = cells.populations[population, kinds.FIRST], cells.populations[population, kinds.LAST]
    state, constants, drive = cells.state, cells.constants, cells.drive
    for i in range(first, last):
        v = state[kinds.V, i]
        if state[kinds.REFRACTORY, i] <= 0:
            settled = wrap(mul(drive[i], constants[kinds.R_MEMBRANE, i]) + constants[kinds.V_REST, i])
            v = wrap(settled - mul(constants[kinds.EXP_TC, i], wrap(settled - v)))
        else:
            state[kinds.REFRACTORY, i] -= 1
        if v >= constants[kinds.V_THRESH, i]:
            v = constants[kinds.V_RESET, i]
            state[kinds.REFRACTORY, i] = constants[kinds.T_REFRACTORY, i]
            note_spike(cells, i)
        state[kinds.V, i] = v


@jit
def _update_izhikevich(cells: Cells, population: int) -> None:
    first, last = cells.populations[population, kinds.FIRST], cells.populations[population, kinds.LAST]
    state, constants = cells.state, cells.constants
    for i in range(first, last):
        h_reset, a, b = constants[kinds.H_RESET, i], constants[kinds.IZK_A, i], constants[kinds.IZK_B, i]
        v, u, h = state[kinds.V, i], state[kinds.U, i], state[kinds.H, i]
        v, u = _izhikevich_step(v, u, h, cells.drive[i], a, b)
        state[kinds.H, i] = h_reset
        if v >= _IZK_THRESHOLD:
            v = constants[kinds.IZK_C, i]
            u = wrap(u + constants[kinds.IZK_D, i])
            state[kinds.H, i] = mul(h_reset, _IZK_LONGER)
            note_spike(cells, i)
        state[kinds.V, i], state[kinds.U, i] = v, u


@jit
def _izhikevich_step(v: int, u: int, h: int, current: int, a: int, b: int) -> tuple[int, int]:
    """Take one midpoint step; the order of the products determines the last bits and later whole ticks."""
    before = wrap(_IZK_CONSTANT - u + current)
    slope = wrap(before + mul(wrap(mul(v, _IZK_SQUARE) + _IZK_LINEAR), v))
    middle = wrap(v + mul(mul(slope, h), HALF))
    ah = mul(h, a)
    recovery = mul(mul(wrap(mul(v, b) - u), ah), HALF)
    dv = wrap(wrap(before - recovery) + mul(wrap(mul(middle, _IZK_SQUARE) + _IZK_LINEAR), middle))
    du = wrap(mul(b, middle) - wrap(u + recovery))
    return wrap(v + mul(dv, h)), wrap(u + mul(du, ah))
