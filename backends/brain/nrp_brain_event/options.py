"""Options of the ``event`` backend.

Whether a network runs on the lazy grid. Importing this does not load a compiler.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Final, Literal, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from nrp_brain_event.grid.equations import settling
from nrp_core._support.arrays import BoolArray, FloatArray, IntArray
from nrp_core.brain.backend import BrainOptions
from nrp_core.clock import NS_PER_MS
from nrp_core.network.data import Network, Population
from nrp_core.network.equations.model import INPUT
from nrp_core.network.limits import distinct
from nrp_core.quantities import DurationNs

_TOLERANCE_MV: Final = 1e-9


class EventOptions(BrainOptions):
    """Options of the ``event`` backend."""

    before: ClassVar[Mapping[str, Any]] = {"integration": "steps"}
    tolerance: float = Field(
        default=_TOLERANCE_MV,
        gt=1e-13,
        le=1e-2,
        description="largest local error (mV) of an integration step, for cells without a closed form: "
        "conductance-based, adaptive exponential, Izhikevich, Hodgkin-Huxley",
    )
    integration: Literal["quadrature", "steps"] = Field(
        default="quadrature",
        description="how the exact mode computes the voltage of `IF_cond_exp` below its threshold: as an "
        "integral, or by steps as for the other cells, many times slower with the same error bound",
    )
    resolution: DurationNs | None = Field(
        default=None,
        description="a time grid, e.g. `0.1 ms`, on which all spikes lie; many times faster for dense "
        "networks; by default spike times are exact, which `exact` asks for in the place of a simulator of "
        "PyNN that has a grid",
    )
    poisson: Literal["core", "grid"] = Field(
        default="core",
        description="which part draws SpikeSourcePoisson spikes: the core, so that all backends get the same "
        "spikes, or the grid, many times faster, for populations of equal cells with one synapse each",
    )

    lazy: Literal["auto", "always", "never"] = Field(
        default="auto",
        description="whether the grid works only for the neurons that events reach, with the same spikes: "
        "where that is expected to be faster, wherever it is possible, or never",
    )
    threads: int = Field(
        default=1,
        ge=1,
        le=64,
        description="number of threads for the neurons on the grid, with the same result to the last bit: "
        "for many thousands of neurons, delays of 1 ms or more, and free cores",
    )

    @field_validator("resolution", mode="before")
    @classmethod
    def _exact_is_none(cls, value: object) -> object:
        return None if value == "exact" else value

    @model_validator(mode="after")
    def _check_grid(self) -> Self:
        if self.resolution is None and self.poisson == "grid":
            raise ValueError("poisson: grid needs a resolution, e.g. 0.1 ms")
        if self.resolution is None and self.threads > 1:
            raise ValueError(
                f"threads: {self.threads} needs a resolution, e.g. 0.1 ms; the exact mode uses one thread"
            )
        if self.resolution is None and self.lazy == "always":
            raise ValueError("lazy: always needs a resolution, e.g. 0.1 ms; the exact mode is lazy by itself")
        if self.resolution is not None and self.tolerance != _TOLERANCE_MV:
            raise ValueError(
                f"tolerance: {self.tolerance:g} has no effect with a resolution, whose steps are fixed"
            )
        if self.resolution is not None and self.resolution > NS_PER_MS:
            raise ValueError(f"resolution must be 1 ms or finer, not {self.resolution / NS_PER_MS:g} ms")
        return self


_CELLS: Final = frozenset({"IF_curr_exp", "IF_curr_alpha", "IF_curr_delta", "IF_curr_exp_frozen"})
"""Cells whose course between two events has a closed form on the grid."""
MOST_KINDS: Final = 64
"""Of cells with different parameters; each has a table of its course."""
_FEWEST: Final = 2000
_MOST_SYNAPSES: Final = 500
"""Mean number of synapses onto a cell, or Poisson spikes per second, above which events are too frequent."""
_MOST_RESTLESS: Final = 0.05
"""Share of cells that fire without input: these are looked at in each step."""


def lazy_grid_obstacle(network: Network, options: EventOptions) -> str:
    """Return why a network does not run on the lazy grid under these options; empty if it does."""
    if options.lazy == "never":
        return "`lazy: never`"
    return _impossible(network, options) or ("" if options.lazy == "always" else _dear(network))


def _impossible(network: Network, options: EventOptions) -> str:
    """Return why the lazy grid cannot run a network, or an empty text."""
    if options.threads > 1:
        return "several threads share the plain grid only"
    if options.poisson == "grid":
        return "`poisson: grid` gives input to all neurons in each step"
    for projection in network.projections:
        if projection.is_continuous:
            return f"the synapses of projection '{projection.label}' act in each step"
    kinds = 0
    for population in _simulated(network):
        obstacle = _obstacle_of(population)
        if obstacle:
            return f"{population.cell_type} of population '{population.label}' {obstacle}"
        kinds += len(combinations(population.parameters, population.size)[0])
    if kinds > MOST_KINDS:
        return f"the cells have {kinds} combinations of parameters, more than {MOST_KINDS}"
    return ""


def _dear(network: Network) -> str:
    """Return why the plain grid is expected to be faster, or an empty text."""
    cells = _simulated(network)
    size = sum(population.size for population in cells)
    if size < _FEWEST:
        return f"the network has fewer than {_FEWEST} cells"
    restless = sum(int(_restless(population).sum()) for population in cells)
    if restless > _MOST_RESTLESS * size:
        return f"{restless} of {size} cells fire without input"
    load = 0.0
    for projection in network.projections:
        pre = network.populations[projection.pre]
        if pre.cell_type == "SpikeSourcePoisson" and pre.size:
            load += projection.size * float(pre.parameters["rate"].mean())
        elif not pre.is_source:
            load += projection.size
    if load > _MOST_SYNAPSES * size:
        return f"{load / size:.0f} synapses, or Poisson spikes a second, reach a cell on average"
    return ""


def _simulated(network: Network) -> list[Population]:
    return [population for population in network.populations.values() if not population.is_source]


def combinations(parameters: Mapping[str, FloatArray], size: int) -> tuple[IntArray, IntArray]:
    """Return the first cell of each combination of parameters, and the combination of each cell.

    The constant current does not count.

    Args:
        parameters: by name, shape ``(size,)``.
        size: number of cells.
    """
    codes = np.zeros(size, np.int64)
    for name, values in parameters.items():
        if name != INPUT and (distinct(values) != values[:1]).any():
            _, own = np.unique(values, return_inverse=True)
            _, codes = np.unique(codes * size + own, return_inverse=True)
    _, first, codes = np.unique(codes, return_index=True, return_inverse=True)
    return first, codes


def _obstacle_of(population: Population) -> str:
    """Return why the state of cells between events cannot be predicted, or an empty text."""
    if population.equations is not None:
        return settling.obstacle(population.equations.model)
    return "" if population.cell_type in _CELLS else "has no closed form between events"


def _restless(population: Population) -> BoolArray:
    of = {name: distinct(values) for name, values in population.parameters.items()}
    if population.equations is None:
        above = of["v_rest"] + of["i_offset"] * of["tau_m"] / of["cm"] - of["v_thresh"]
    else:
        above = settling.excess_at_rest(population.equations.model, population.equations.in_si(of))
    return np.broadcast_to(above >= 0.0, population.size)
