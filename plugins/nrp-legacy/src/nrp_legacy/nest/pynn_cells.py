"""Cells of PyNN that a script passes to NEST as its nodes."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import Any

from nrp_core.brain.network.nest_models import LEAK_NS, CellModel
from nrp_core.brain.pynn.export import cell_type_of
from nrp_core.errors import NetworkError, did_you_mean
from nrp_legacy.nest.models import CELLS

NEST_OF = {model.cell_type: name for name, model in reversed(list(CELLS.items()))}
"""NEST's name of each cell type."""


class PyNNCells:
    """The cells of a script's populations, by the numbers that PyNN gives them, in NEST's names and units.

    Args:
        sim: the simulator of PyNN.
    """

    def __init__(self, sim: ModuleType) -> None:
        self._sim = sim

    def __len__(self) -> int:
        return int(self._sim.state.n_cells)

    def get(self, cell: int) -> dict[str, Any]:
        """Return the parameters of a cell."""
        population, place = self._found(cell)
        base, model = model_of(population)
        own = {name: float(values[place]) for name, values in population.parameter_arrays.items()}
        found = {theirs.name: own[ours] / theirs.scale for ours, theirs in model.parameters.items()}
        if base in LEAK_NS:
            found["g_L"] = own["cm"] * 1e3 / own["tau_m"]
        return {"global_id": cell, "model": base, "element_type": "neuron", **found}

    def set(self, cell: int, values: Mapping[str, Any]) -> None:
        """Change parameters of a cell, and its first voltage ``V_m``.

        Raises:
            NetworkError: cells of its type do not have them.
        """
        population, place = self._found(cell)
        base, model = model_of(population)
        ours = {theirs.name: (own, theirs.scale) for own, theirs in model.parameters.items()}
        known = {*ours, "V_m"} | ({"g_L"} if base in LEAK_NS else set())
        for name in values:
            if name not in known:
                raise NetworkError(
                    f"nest: cells of the population '{population.label}' have no '{name}'"
                    f"{did_you_mean(name, known)}"
                )
        changed = {ours[name][0]: value * ours[name][1] for name, value in values.items() if name in ours}
        if base in LEAK_NS and {"C_m", "g_L"} & values.keys():
            conductance = values.get("g_L", self.get(cell)["g_L"])
            changed["tau_m"] = values.get("C_m", self.get(cell).get("C_m")) / conductance
        view = population[place : place + 1]
        view.set(**changed)
        if "V_m" in values:
            view.initialize(v=values["V_m"])

    def _found(self, cell: int) -> tuple[Any, int]:
        for population in self._sim.state.populations:
            if 0 <= cell - int(population.first_id) < population.size:
                return population, cell - int(population.first_id)
        raise NetworkError(f"nest: node {cell} does not exist")


def model_of(population: Any) -> tuple[str, CellModel]:
    """Return the model of NEST that the cells of a population have.

    Raises:
        NetworkError: there is none.
    """
    kind = cell_type_of(population)
    if kind not in NEST_OF:
        raise NetworkError(
            f"nest: cells of the population '{population.label}' are {kind}, which NEST has not"
        )
    return NEST_OF[kind], CELLS[NEST_OF[kind]]


def scale_of(population: Any) -> float:
    """Return the factor from NEST's unit of weights to PyNN's: nS to µS, pA to nA, or mV to mV."""
    kind = cell_type_of(population)
    return CELLS[NEST_OF[kind]].weight_scale if kind in NEST_OF else 1e-3
