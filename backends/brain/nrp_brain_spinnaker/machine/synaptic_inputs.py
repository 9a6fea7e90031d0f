"""Synapses convert input to a current or conductance over time: exponential, alpha, delta.

A tick has three phases: input is added, the value is read, the state decays. The alpha function with a peak
is ours: its value is the mean over the step, as for the machine's exponential, so the charge of an event is
right on any grid.
"""

from __future__ import annotations

from nrp_brain_spinnaker.machine import kinds
from nrp_brain_spinnaker.machine.fixed_point import ONE, div, mul, scale, wrap
from nrp_brain_spinnaker.machine.kinds import Cells
from nrp_core._support.arrays import IntArray
from nrp_core._support.jit import jit


@jit
def add_arrived(cells: Cells, population: int) -> None:
    """Add the input of this tick to each synapse; no input differs from an input of 0."""
    first, last = cells.populations[population, kinds.FIRST], cells.populations[population, kinds.LAST]
    kind = cells.populations[population, kinds.SYNAPSE]
    for receptor in range(2):
        arrived, state = cells.arrived[receptor], cells.synapse_state[receptor]
        constants = cells.synapse_constants[receptor]
        for i in range(first, last):
            x = arrived[i]
            if x == 0:
                continue
            if kind == kinds.EXPONENTIAL:
                state[kinds.VALUE, i] = wrap(state[kinds.VALUE, i] + scale(x, constants[kinds.INIT, i]))
            elif kind == kinds.PEAKED_ALPHA:
                state[kinds.RISE, i] = wrap(state[kinds.RISE, i] + x)
                state[kinds.VALUE, i] = wrap(state[kinds.VALUE, i] + scale(x, constants[kinds.INIT, i]))
            elif kind == kinds.DELTA:
                state[kinds.VALUE, i] = wrap(state[kinds.VALUE, i] + x)
            elif x > 0:
                _add_alpha(state, constants[kinds.DECAY, i], constants[kinds.GAIN, i], i, x)


@jit
def _add_alpha(state: IntArray, decay: int, gain: int, i: int, x: int) -> None:
    """Add input to the machine's alpha synapse, a line times an exponential; the earlier slope is lost."""
    exponential = wrap(scale(state[kinds.RISE, i], decay) + ONE)
    share = wrap(ONE - div(ONE, exponential)) if exponential > 0 else ONE
    state[kinds.PENDING, i] = x
    state[kinds.RISE, i] = exponential
    state[kinds.VALUE, i] = mul(wrap(state[kinds.VALUE, i] + mul(x, gain)), share)


@jit
def read_values(cells: Cells, population: int) -> None:
    """Write the value of each synapse to ``cells.value``."""
    first, last = cells.populations[population, kinds.FIRST], cells.populations[population, kinds.LAST]
    product = cells.populations[population, kinds.SYNAPSE] == kinds.ALPHA
    for receptor in range(2):
        value, state = cells.value[receptor], cells.synapse_state[receptor]
        for i in range(first, last):
            value[i] = mul(state[kinds.VALUE, i], state[kinds.RISE, i]) if product else state[kinds.VALUE, i]


@jit
def decay_synapses(cells: Cells, population: int) -> None:
    """Advance the synapses by one step."""
    first, last = cells.populations[population, kinds.FIRST], cells.populations[population, kinds.LAST]
    kind = cells.populations[population, kinds.SYNAPSE]
    for receptor in range(2):
        state, constants = cells.synapse_state[receptor], cells.synapse_constants[receptor]
        if kind == kinds.EXPONENTIAL:
            for i in range(first, last):
                state[kinds.VALUE, i] = scale(state[kinds.VALUE, i], constants[kinds.DECAY, i])
        elif kind == kinds.DELTA:
            state[kinds.VALUE, first:last] = 0
        elif kind == kinds.PEAKED_ALPHA:
            _decay_peaked(state, constants, first, last)
        else:
            _decay_alpha(state, constants, first, last)


@jit
def _decay_peaked(state: IntArray, constants: IntArray, first: int, last: int) -> None:
    for i in range(first, last):
        decay, gain, rise = constants[kinds.DECAY, i], constants[kinds.GAIN, i], state[kinds.RISE, i]
        state[kinds.VALUE, i] = wrap(scale(state[kinds.VALUE, i], decay) + scale(rise, gain))
        state[kinds.RISE, i] = scale(rise, decay)


@jit
def _decay_alpha(state: IntArray, constants: IntArray, first: int, last: int) -> None:
    for i in range(first, last):
        slope = mul(state[kinds.PENDING, i], constants[kinds.GAIN, i])
        state[kinds.VALUE, i] = wrap(state[kinds.VALUE, i] + slope)
        state[kinds.RISE, i] = scale(state[kinds.RISE, i], constants[kinds.DECAY, i])
