"""Every cell type; limits, PyNN's classes, file readers and conformance samples follow this table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from nrp_core.brain.network.cells import (
    adaptive_exponential,
    hodgkin_huxley,
    integrate_and_fire,
    izhikevich,
    spike_sources,
)
from nrp_core.brain.network.cells.cell_type import CellType

CELLS: Final[Mapping[str, CellType]] = {
    cell.name: cell
    for cell in (
        integrate_and_fire.CURR_EXP,
        integrate_and_fire.CURR_ALPHA,
        integrate_and_fire.CURR_DELTA,
        integrate_and_fire.CURR_EXP_FROZEN,
        integrate_and_fire.COND_EXP,
        integrate_and_fire.COND_ALPHA,
        izhikevich.IZHIKEVICH,
        izhikevich.CURR_EXP,
        izhikevich.COND_EXP,
        adaptive_exponential.COND_EXP,
        adaptive_exponential.COND_ALPHA,
        hodgkin_huxley.COND_EXP,
        spike_sources.POISSON,
        spike_sources.REFRACTORY,
        spike_sources.GAMMA,
        spike_sources.ARRAY,
    )
}
