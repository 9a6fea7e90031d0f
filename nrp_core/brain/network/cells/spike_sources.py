"""Cells that only emit spikes."""

from __future__ import annotations

from typing import Final

from nrp_core.brain.network.cells.cell_type import CellType
from nrp_core.brain.network.parameters import (
    NOT_NEGATIVE,
    NOT_NEGATIVE_OR_INFINITE,
    NUMBER,
    POSITIVE,
    RATE,
    Parameter,
)

_WINDOW: Final = {
    "start": Parameter(0.0, "ms", NUMBER),
    "duration": Parameter(1e10, "ms", NOT_NEGATIVE_OR_INFINITE),
}

POISSON: Final = CellType(
    "SpikeSourcePoisson",
    "Independent spikes at a mean rate.",
    {
        "rate": Parameter(1.0, "Hz", RATE),
        **_WINDOW,
    },
    stands_for=("SpikeSourceInhGamma",),
)
REFRACTORY: Final = CellType(
    "SpikeSourcePoissonRefractory",
    "Independent spikes at a mean rate, each followed by a dead time.",
    {"rate": Parameter(1.0, "Hz", RATE), "tau_refrac": Parameter(0.0, "ms", NOT_NEGATIVE), **_WINDOW},
)
GAMMA: Final = CellType(
    "SpikeSourceGamma",
    "Spikes whose intervals have a gamma distribution of shape alpha, with a mean of alpha / beta seconds.",
    {"alpha": Parameter(2.0, "dimensionless", POSITIVE), "beta": Parameter(1.0, "Hz", RATE), **_WINDOW},
)
ARRAY: Final = CellType("SpikeSourceArray", "Spikes at given times, ``spike_times`` (ms).", {})
