"""The capabilities of a brain backend, and its reports on a network before it runs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from nrp_core.clock import from_milliseconds, milliseconds
from nrp_core.findings import Finding
from nrp_core.findings.refusals import (
    no_cells,
    no_initial_synapses,
    no_neuromodulation,
    no_rewiring,
    no_synapses,
    no_voltages,
    other_step,
)
from nrp_core.network.data import Network
from nrp_core.simulation import Determinism

Value: TypeAlias = str | int | float | bool | None


@dataclass(frozen=True, slots=True)
class Quantity:
    """The name, unit and format of a value.

    Args:
        name: identifier in JSON, with the unit: ``sdram_bytes``.
        title: heading in text: ``SDRAM``.
        form: Python format specification of a value; empty for ``str``.
        unit: unit written after the value.
        meaning: one sentence of explanation, if the title is not enough.
        is_detail: whether a short report omits it.
    """

    name: str
    title: str
    form: str = ""
    unit: str = ""
    meaning: str = ""
    is_detail: bool = False

    def value_text(self, value: Value) -> str:
        """Return a value as text with its unit; a dash for None."""
        if value is None:
            return "-"
        if isinstance(value, bool):
            return "yes" if value else "no"
        text = value if isinstance(value, str) else format(value, self.form)
        return f"{text} {self.unit}" if self.unit else text


@dataclass(frozen=True, slots=True)
class Fact:
    """One value about the whole network."""

    quantity: Quantity
    value: Value

    def __str__(self) -> str:
        return self.quantity.value_text(self.value)


@dataclass(frozen=True, slots=True)
class Table:
    """A table of values about parts of the network.

    Args:
        name: identifier in JSON.
        title: heading in text.
        columns: the quantity of each column.
        rows: the values, row by row.
        is_detail: whether a short report omits it.
    """

    name: str
    title: str
    columns: tuple[Quantity, ...]
    rows: tuple[tuple[Value, ...], ...]
    is_detail: bool = False

    def cell_texts(self) -> list[list[str]]:
        """Return all values as text with their units."""
        return [
            [c.value_text(value) for c, value in zip(self.columns, row, strict=True)] for row in self.rows
        ]

    def is_number(self, column: int) -> bool:
        """Whether a column holds only numbers, which are aligned to the right."""
        return not any(isinstance(row[column], (str, bool)) for row in self.rows)


@dataclass(frozen=True, slots=True)
class Report:
    """One report on a network.

    Args:
        name: identifier in JSON.
        title: heading in text.
        facts: values about the whole network.
        tables: values about its parts.
        warnings: features that would be lost or would not work.
        advice: possible improvements, one sentence each.
        notes: how accurate the numbers are.
    """

    name: str
    title: str
    facts: tuple[Fact, ...] = ()
    tables: tuple[Table, ...] = ()
    warnings: tuple[Finding, ...] = ()
    advice: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return the report as JSON-compatible values: facts by name, table rows as objects."""
        return {
            "name": self.name,
            "title": self.title,
            "facts": {fact.quantity.name: fact.value for fact in self.facts},
            "tables": {table.name: _rows(table) for table in self.tables},
            "warnings": [warning.to_dict() for warning in self.warnings],
            "advice": list(self.advice),
            "notes": list(self.notes),
        }


def _rows(table: Table) -> list[dict[str, Value]]:
    names = [column.name for column in table.columns]
    return [dict(zip(names, row, strict=True)) for row in table.rows]


@dataclass(frozen=True, slots=True)
class BrainCapabilities:
    """The capabilities of a brain backend.

    Args:
        cells: the PyNN standard cells that it simulates.
        synapses: the synapse types that it simulates.
        extensions: the cells and synapses that the original simulator does not have.
        approximate: the cells whose error is larger than the resolution explains.
        resolution_ns: the time grid of its events; None if event times are exact.
        determinism: how closely two runs agree.
        state_variables: the state variables that can be read while it runs.
        changes: properties that can change while it runs: ``parameters`` of cells, ``weights`` of synapses,
            ``plasticity``, i.e. whether plastic synapses learn, ``equations``, i.e. parameters of synapses in
            equations.
            Parameters of source cells whose spikes the core draws can always change.
        initial_synapses: whether the state of synapses at time 0 can be given.
        rewiring: whether synapses can form and vanish while it runs.
        neuromodulation: whether rewards and punishments can decide on STDP.
        rewards: whether rewards can also come from outside the network, for example from a transfer function.
        synapse_state: the state variables of synapses that learn from rewards, which can be read while it
            runs: ``eligibility``, ``dopamine``; with these also those of synapses in equations.
        snapshot: whether its state can be saved and restored.
        releases_gil: whether it can step while Python code runs in another thread.
        late_spikes: whether source cells can emit spikes of the past that have not arrived anywhere yet.
        spike_lag_ns: how much later than for its synapses a spike of a cell is reported.
    """

    cells: frozenset[str]
    synapses: frozenset[str]
    extensions: frozenset[str] = frozenset()
    approximate: frozenset[str] = frozenset()
    resolution_ns: int | None = None
    determinism: Determinism = Determinism.MACHINE
    state_variables: frozenset[str] = frozenset()
    changes: frozenset[str] = frozenset()
    initial_synapses: bool = False
    rewiring: bool = False
    neuromodulation: bool = False
    rewards: bool = False
    synapse_state: frozenset[str] = frozenset()
    snapshot: bool = False
    releases_gil: bool = False
    late_spikes: bool = False
    spike_lag_ns: int = 0

    def extended(self, network: Network) -> BrainCapabilities:
        """Return these capabilities with the state variables that the network's own equations add."""
        models = [one.equations.model for one in network.populations.values() if one.equations is not None]
        own = frozenset(name for model in models for name in (*model.variables, *model.recorded))
        return replace(self, state_variables=self.state_variables | own) if own else self

    def require(self, network: Network, name: str) -> None:
        """Check that the backend has all cells and synapses of a network.

        Args:
            network: the network.
            name: the backend, for the message.

        Raises:
            CapabilityError: a type is missing; the message names its owner and the nearest supported type. Or
                cells are made for another step.
        """
        for population in network.populations.values():
            if not population.is_source and population.cell_type not in self.cells:
                raise no_cells(name, population.cell_type, population.label, self.cells)
            step_ms = None if population.equations is None else population.equations.step_ms
            if step_ms and self.resolution_ns and from_milliseconds(step_ms) != self.resolution_ns:
                raise other_step(name, milliseconds(self.resolution_ns), step_ms, population.label)
        for projection in network.projections:
            if projection.synapse_type not in self.synapses:
                if projection.is_continuous:
                    raise no_voltages(name, projection.synapse_type, projection.label)
                raise no_synapses(name, projection.synapse_type, projection.label, self.synapses)
            if projection.initial_values and not self.initial_synapses:
                raise no_initial_synapses(name, projection.label, projection.initial_values)
            if projection.rewiring is not None and not self.rewiring:
                raise no_rewiring(name, projection.label)
            if projection.neuromodulation is not None and not self.neuromodulation:
                raise no_neuromodulation(name, projection.label)
