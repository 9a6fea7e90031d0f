"""Izhikevich's cell (2003, IEEE Transactions on Neural Networks 14:1569).

PyNN's has a voltage that jumps by weights; those of sPyNNaker have synapses that decay exponentially, and an
input that enters the equation in nA as it is, so that their ``i_offset`` is 1000 times PyNN's.
"""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.cells.cell_type import (
    CONDUCTANCES,
    CURRENT_INPUT,
    CURRENTS,
    CellType,
    reversal_potentials,
    synaptic_times,
)
from nrp_core.brain.network.parameters import Parameter

PEAK_MV: Final = 30.0
"""The voltage at which the cell spikes."""

_RECOVERY: Final = {
    "a": Parameter(0.02, "/ms"),
    "b": Parameter(0.2, "/ms"),
    "c": Parameter(-65.0, "mV"),
    "d": Parameter(2.0, "mV/ms"),
    **CURRENT_INPUT,
}
_STATE: Final = {"v": Parameter(-70.0, "mV"), "u": Parameter(-14.0, "mV/ms")}

IZHIKEVICH: Final = CellType(
    "Izhikevich",
    "Izhikevich's quadratic cell with recovery; its voltage jumps by the weight.",
    _RECOVERY,
    _STATE,
    weight_unit="mV",
)
CURR_EXP: Final = CellType(
    "IZK_curr_exp",
    "Izhikevich's cell of sPyNNaker, with exponentially decaying synaptic currents.",
    {**_RECOVERY, **synaptic_times(5.0, 5.0)},
    {**_STATE, **CURRENTS},
    weight_unit="nA",
)
COND_EXP: Final = CellType(
    "IZK_cond_exp",
    "Izhikevich's cell of sPyNNaker, with exponentially decaying synaptic conductances.",
    {**_RECOVERY, **synaptic_times(5.0, 5.0), **reversal_potentials(-70.0)},
    {**_STATE, **CONDUCTANCES},
    weight_unit="uS",
)
