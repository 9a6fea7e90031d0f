"""Izhikevich's cell (2003, IEEE Transactions on Neural Networks 14:1569); its voltage jumps by weights."""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.cells.cell_type import CURRENT_INPUT, CellType
from nrp_core.brain.network.parameters import Parameter

PEAK_MV: Final = 30.0
"""The voltage at which the cell spikes."""

IZHIKEVICH: Final = CellType(
    "Izhikevich",
    "Izhikevich's quadratic cell with recovery; its voltage jumps by the weight.",
    {
        "a": Parameter(0.02, "/ms"),
        "b": Parameter(0.2, "/ms"),
        "c": Parameter(-65.0, "mV"),
        "d": Parameter(2.0, "mV/ms"),
        **CURRENT_INPUT,
    },
    {"v": Parameter(-70.0, "mV"), "u": Parameter(-14.0, "mV/ms")},
    weight_unit="mV",
)
