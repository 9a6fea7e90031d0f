"""Populations and projections with the arguments and methods that only sPyNNaker has."""

# mypy: disable-error-code="misc"

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.pynn import populations, projections
from nrp_core.brain.pynn.spynnaker import neo_convertor
from nrp_core.brain.pynn.spynnaker.settings import cells_per_core, hints_of, remarks_on
from nrp_core.errors import NetworkError


class Population(populations.Population):
    """A group of cells, with the settings of sPyNNaker.

    Args:
        constraints: ignored, as they place cells on a machine.
        additional_parameters: settings of the population on the machine.
        settings: the same, as keyword arguments.
    """

    def __init__(
        self, size: Any, cellclass: Any, cellparams: Mapping[str, Any] | None = None, structure: Any = None,
        initial_values: Mapping[str, Any] | None = None, label: str | None = None, constraints: Any = None,
        additional_parameters: Mapping[str, Any] | None = None, **settings: Any,
    ) -> None:  # fmt: skip
        if isinstance(cellclass, type):
            cellclass, cellparams = cellclass(**(cellparams or {})), None
        size = int(size) if isinstance(size, (float, np.floating)) and float(size).is_integer() else size
        state = {**getattr(cellclass, "given_state", {}), **(initial_values or {})}
        super().__init__(size, cellclass, cellparams, structure, state, label)
        own = getattr(cellclass, "settings", {})
        owner, given = f"population '{self.label}'", {**own, **(additional_parameters or {}), **settings}
        defaults = self._simulator.state.hints_by_cell.get(type(cellclass), {})
        self.hints = {**defaults, **hints_of(owner, given)}
        if constraints:
            self._place()
        if hasattr(cellclass, "hub"):
            cellclass.hub.inject_into(self, given.pop("port", None), given.pop("virtual_key", None))
            if cellclass.program is not None:
                cellclass.hub.notify(*cellclass.program)
        for text in remarks_on(owner, given):
            self._simulator.state.remark(text)

    def record(self, variables: Any, *arguments: Any, **options: Any) -> None:
        """Record variables of all cells; ``all`` are those that its cells have."""
        super().record(self.celltype.recordable if variables == "all" else variables, *arguments, **options)

    def set_max_atoms_per_core(self, max_atoms_per_core: Any) -> None:
        """Set the largest number of cells on a core of the machine."""
        count = cells_per_core(f"population '{self.label}'", max_atoms_per_core)
        self.hints = {**self.hints, "neurons_per_core": count}

    def _place(self, *_: Any, **__: Any) -> None:
        self._simulator.state.remark(
            f"population '{self.label}' is placed by the mapper; the place in the script has no effect"
        )

    add_placement_constraint = set_constraint = set_mapping_constraint = _place

    def spinnaker_get_data(
        self, variable: Any, as_matrix: bool = False, view_indexes: Any = None
    ) -> FloatArray:
        """Return recorded data as rows of cell, time (ms) and value.

        Args:
            variable: one name, or a list of one.
            as_matrix: return the values only, shape ``(n_samples, n_cells)``; not for spikes.
            view_indexes: the cells to return, by default all.
        """
        names = [variable] if isinstance(variable, str) else list(variable)
        if len(names) != 1:
            raise NetworkError(
                f"population '{self.label}': spinnaker_get_data takes one variable, not {names}"
            )
        data = self.get_data(names)
        if as_matrix and names != ["spikes"]:
            values = np.asarray(data.segments[-1].filter(name=names[0])[0].magnitude)
            return values if view_indexes is None else values[:, list(view_indexes)]
        rows = neo_convertor.convert_data(data, names[0], run=len(data.segments) - 1)
        return rows if view_indexes is None else rows[np.isin(rows[:, 0], list(view_indexes))]

    def set_initial_value(self, variable: str, value: Any, selector: Any = None) -> None:
        """Set the initial value of a state variable, of all cells or of those at an index."""
        (self if selector is None else self[selector]).initialize(**{variable: value})

    def get_initial_value(self, variable: str, selector: Any = None) -> FloatArray:
        """Return the initial values of a state variable."""
        values = self.initial_arrays[variable]
        return values if selector is None else values[selector]


class Projection(projections.Projection):
    """Synapses whose weights on the inhibitory receptor may have either sign, as in sPyNNaker."""

    def __init__(
        self, pre_synaptic_population: Any, post_synaptic_population: Any, connector: Any,
        synapse_type: Any = None, source: Any = None, receptor_type: str | None = None, space: Any = None,
        label: str | None = None, download_synapses: bool = False, partition_id: Any = None,
    ) -> None:  # fmt: skip
        super().__init__(
            pre_synaptic_population, post_synaptic_population, connector, synapse_type, source,
            receptor_type, space, label,
        )  # fmt: skip

    def _meant(self, values: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
        weight = values.get("weight")
        mixed = weight is not None and (weight < 0).any() and (weight > 0).any()
        if self.receptor_type != "inhibitory" or weight is None or mixed:
            return values
        return {**values, "weight": abs(weight) if self.post.conductance_based else -abs(weight)}
