"""Codes of kinds and rows of arrays in the compiled code.

The neurons of all populations are consecutive; a population is a range of them. An array of state or
constants has one row per variable and one column per neuron.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from nrp_core._support.arrays import IntArray

# The time course of a synapse after an input.
EXPONENTIAL: Final = 0
ALPHA: Final = 1
DELTA: Final = 2
PEAKED_ALPHA: Final = 3

# The effect of that time course on the membrane.
CURRENT: Final = 0
CONDUCTANCE: Final = 1
IMPULSE: Final = 2
JUMP: Final = 3
FINE_CONDUCTANCE: Final = 4

# The kinds of membranes.
LIF: Final = 0
IZHIKEVICH: Final = 1
ADAPTIVE_EXPONENTIAL: Final = 2
HODGKIN_HUXLEY: Final = 3

# Columns of the table of populations.
FIRST, LAST, SYNAPSE, INPUT, NEURON, SUBSTEPS, SHIFT_EXC, SHIFT_INH = range(8)
POPULATION_COLUMNS: Final = 8

# Rows of a synapse's constants and state, for each receptor.
DECAY, INIT, GAIN = range(3)
VALUE, RISE, PENDING = range(3)
SYNAPSE_ROWS: Final = 3

# Rows of a neuron's constants: those of all kinds, then those of one kind.
I_OFFSET, E_REV_E, E_REV_I, IMPULSE_GAIN = range(4)
R_MEMBRANE, EXP_TC, V_REST, V_RESET, V_THRESH, T_REFRACTORY = range(4, 10)
V_SOFT, SLOPE, INVERSE_SLOPE, MEMBRANE_DECAY = range(10, 14)
ADAPTATION, ADAPTATION_DECAY, ADAPTATION_JUMP = range(14, 17)
IZK_A, IZK_B, IZK_C, IZK_D, H_RESET = range(4, 9)
G_SODIUM, G_POTASSIUM, G_LEAK, E_SODIUM, E_POTASSIUM, E_LEAK, V_OFFSET, LIFT, STEP = range(4, 13)
CONSTANT_ROWS: Final = 17

# Rows of a neuron's state.
V: Final = 0
REFRACTORY, W = 1, 2
U, H = 1, 2
GATE_M, GATE_H, GATE_N, V_FINE = 1, 2, 3, 4
STATE_ROWS: Final = 5


class Cells(NamedTuple):
    """The neurons of a network.

    Args:
        populations: shape ``(n_populations, POPULATION_COLUMNS)``.
        constants: s16.15, shape ``(CONSTANT_ROWS, n)``.
        state: s16.15, shape ``(STATE_ROWS, n)``.
        synapse_constants: u0.32, shape ``(2, SYNAPSE_ROWS, n)``; the first index is the receptor.
        synapse_state: s16.15, same shape.
        current: external current, s16.15, shape ``(n,)``.
        ids: global ids, shape ``(n,)``.
        arrived, value: scratch per receptor, shape ``(2, n)``.
        drive: scratch, the total current, shape ``(n,)``.
        fired: the neurons that spiked in the current tick, with room for one entry per (sub-)step.
        n_fired: number of these entries, shape ``(1,)``.
    """

    populations: IntArray
    constants: IntArray
    state: IntArray
    synapse_constants: IntArray
    synapse_state: IntArray
    current: IntArray
    ids: IntArray
    arrived: IntArray
    value: IntArray
    drive: IntArray
    fired: IntArray
    n_fired: IntArray

    def neurons(self, population: int) -> slice:
        """Return the range of a population's neurons."""
        first, last = self.populations[population, [FIRST, LAST]].tolist()
        return slice(first, last)
