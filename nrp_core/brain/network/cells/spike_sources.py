"""Cells that only emit spikes."""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.cells.cell_type import CellType
from nrp_core.brain.network.parameters import NOT_NEGATIVE_OR_INFINITE, NUMBER, RATE, Parameter

POISSON: Final = CellType(
    "SpikeSourcePoisson",
    "Independent spikes at a mean rate.",
    {
        "rate": Parameter(1.0, "Hz", RATE),
        "start": Parameter(0.0, "ms", NUMBER),
        "duration": Parameter(1e10, "ms", NOT_NEGATIVE_OR_INFINITE),
    },
    stands_for=("SpikeSourcePoissonRefractory", "SpikeSourceGamma", "SpikeSourceInhGamma"),
)
ARRAY: Final = CellType("SpikeSourceArray", "Spikes at given times, ``spike_times`` (ms).", {})
