"""The common part of all simulators: PyNN builds the network; a driver steps it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Any

import numpy as np
from nrp_core.brain import (
    STATIC,
    STDP,
    Code,
    Findings,
    FloatArray,
    Grid,
    IntArray,
    Network,
    ParameterChange,
    Population,
    Projection,
    Spikes,
    SynapticEvents,
)
from nrp_core.errors import CapabilityError
from nrp_core.network.cells import settled_gates

from nrp_brain_pynn.checks import check_change
from nrp_brain_pynn.options import PyNNOptions
from nrp_brain_pynn.short_term import short_term

_STATE = ("v", "u", "w", "m", "h", "n")
_ON_THE_GRID_MS = 1e-6


class Driver(ABC):
    """A network in one simulator.

    Args:
        network: the network.
        grid: the time grid of the simulator.
        options: options of the backend.

    Attributes:
        sim: PyNN's module for the simulator.
        populations: PyNN's populations by label.
        projections: PyNN's projections by label.
        warnings: warnings about the simulator's deviations from the network.
    """

    sim: Any

    def __init__(self, network: Network, grid: Grid, options: PyNNOptions) -> None:
        self.network, self.grid, self.options = network, grid, options
        self.warnings = Findings()
        delays = [grid.delays(p.delay_ms).max() for p in network.projections if p.size]
        self._set_up(float(grid.time_ms(np.max(delays, initial=1))))
        self.populations = {
            label: self._sources(population) if population.is_source else self._cells(population)
            for label, population in network.populations.items()
            if population.size
        }
        self.projections: dict[str, Any] = {}
        for projection in network.projections:
            if projection.size:
                self.projections[projection.label] = self._connect(projection)
        self._offsets_na, self._currents_na = np.zeros(network.size), np.zeros(network.size)
        for label in self.cell_labels:
            offsets = network.populations[label].parameters["i_offset"]
            self._offsets_na[network.ids_of(label)] = offsets
        self._held_na = self._offsets_na.copy()
        self._parameters = {label: dict(network.populations[label].parameters) for label in self.cell_labels}
        self._begin()

    # -- building, by PyNN's interface

    def _cells(self, population: Population) -> Any:
        kind = self._kind(population.cell_type)
        values = {name: _simplified(array) for name, array in population.parameters.items()}
        cells = self.sim.Population(population.size, kind(**values), label=population.label)
        initial = dict(population.initial_values)
        if population.cell_type == "HH_cond_exp":
            initial = settled_gates(initial["v"] - population.parameters["v_offset"]) | initial
        starts = kind.default_initial_values
        for name, start in population.initial_values.items():
            if name not in _STATE and start.any():
                raise CapabilityError(
                    f"population '{population.label}': PyNN's {population.cell_type} cannot start with "
                    f"{name} = {start[start != 0][0]:g} on this simulator"
                )
        cells.initialize(**{name: initial[name] for name in _STATE if name in initial and name in starts})
        return cells

    def _kind(self, cell_type: str) -> Any:
        """Return PyNN's class of a cell type."""
        return getattr(self.sim, cell_type)

    def _connect(self, projection: Projection) -> Any:
        return self._projection(projection, self.populations[projection.pre], self._delays_ms(projection))

    def _projection(self, projection: Projection, pre: Any, delays_ms: FloatArray) -> Any:
        """Create a projection; the parameters of its synapses, except those of STDP, are columns."""
        columns = {"weight": projection.weight, "delay": delays_ms}
        columns |= short_term(self.network, projection)
        if projection.synapse_type == STDP:
            kind = self._stdp(projection)
        elif projection.synapse_type == STATIC:
            kind = self.sim.StaticSynapse()
        else:
            kind = self._short_term()
        return self.sim.Projection(
            pre,
            self.populations[projection.post],
            self._connector(projection, columns),
            kind,
            receptor_type=projection.receptor,
            label=projection.label,
        )

    def _short_term(self) -> Any:
        """Return a Tsodyks-Markram synapse type; its parameters are set later."""
        return self.sim.TsodyksMarkramSynapse()

    def _connector(self, projection: Projection, columns: dict[str, FloatArray]) -> Any:
        rows = np.column_stack([projection.pre_index, projection.post_index, *columns.values()])
        return self.sim.FromListConnector(rows, column_names=tuple(columns), safe=False)

    def _stdp(self, projection: Projection) -> Any:
        given = self._stdp_parameters(projection)
        rule = projection.plasticity
        parts = {}
        for part in ("timing_dependence", "weight_dependence"):
            kind = getattr(self.sim, rule[part])
            names = (
                [*kind.default_parameters, "A_plus", "A_minus"] if part[0] == "t" else kind.default_parameters
            )
            parts[part] = kind(**{name: given[name] for name in names if name in given})
        fraction = given.get("dendritic_delay_fraction", 1.0)
        weight, delay = float(projection.weight[0]), self.grid.step_ms
        return self.sim.STDPMechanism(**parts, dendritic_delay_fraction=fraction, weight=weight, delay=delay)

    def _stdp_parameters(self, projection: Projection) -> dict[str, float]:
        return {name: float(values[0]) for name, values in projection.synapse_parameters.items()}

    def _delays_ms(self, projection: Projection) -> FloatArray:
        delays_ms = self.grid.time_ms(self.grid.delays(projection.delay_ms))
        if np.abs(delays_ms - projection.delay_ms).max() > _ON_THE_GRID_MS:
            self.warnings.add(
                Code.NRP217,
                f"projection '{projection.label}': delays are whole numbers of {self.grid.step_ms:g} ms in "
                f"{self.grid.owner}",
                subject=projection.label,
            )
        return delays_ms

    # -- cells by global id

    @property
    def cell_labels(self) -> list[str]:
        """Labels of the populations that are not sources."""
        return [label for label in self.populations if not self.network.populations[label].is_source]

    def by_population(self, neurons: IntArray) -> Iterator[tuple[str, IntArray, IntArray]]:
        """Yield each population with some of the neurons, the indices in it, and those in ``neurons``."""
        for label in self.populations:
            first, size = self.network.offsets[label], self.network.populations[label].size
            which = np.flatnonzero((neurons >= first) & (neurons < first + size))
            if which.size:
                yield label, neurons[which] - first, which

    # -- changes between steps

    def set_currents(self, currents_na: FloatArray) -> None:
        """Set constant currents into all cells in addition to their own, shape ``(network.size,)``."""
        self._currents_na = currents_na
        wanted = self._offsets_na + currents_na
        changed = np.flatnonzero(wanted != self._held_na)
        for label, index, which in self.by_population(changed):
            if not self.network.populations[label].is_source:
                self._hold(label, index, wanted[changed[which]])
        self._held_na = wanted

    def set_parameters(self, change: ParameterChange) -> None:
        """Change parameters of cells.

        Raises:
            CapabilityError: the simulator does not support it.
        """
        check_change(self.network, change)
        label, cells = change.label, np.unique(change.index)
        now = {name: values.copy() for name, values in self._parameters[label].items()}
        for name, values in change.values.items():
            now[name][change.index] = values
        self._parameters[label] = now
        self._offsets_na[self.network.offsets[label] + cells] = now["i_offset"][cells]
        names = change.values.keys() - {"i_offset"}
        # in cells with a leak conductance cm would change tau_m
        for some in (names - {"tau_m"}, {"tau_m"} if names & {"cm", "tau_m"} and "tau_m" in now else ()):
            if some:
                self.populations[label][cells].set(**{name: now[name][cells] for name in some})
        self.set_currents(self._currents_na)

    # -- implemented by each simulator

    @abstractmethod
    def _set_up(self, longest_delay_ms: float) -> None:
        """Reset the simulator to an empty state."""

    @abstractmethod
    def _sources(self, population: Population) -> Any:
        """Create a population of cells that emit the spikes of :meth:`fire`."""

    @abstractmethod
    def _begin(self) -> None:
        """Prepare the first step."""

    @abstractmethod
    def fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        """Add spikes of source cells (global ids) in the next window."""

    @abstractmethod
    def inject(self, events: SynapticEvents) -> None:
        """Add events at cells, possibly after the next window."""

    @abstractmethod
    def _hold(self, label: str, index: IntArray, currents_na: FloatArray) -> None:
        """Set constant currents into cells of a population, replacing earlier ones."""

    @abstractmethod
    def read_weights(self, projection: Projection) -> FloatArray:
        """Return the present weights of a projection."""

    @abstractmethod
    def set_weights(self, projection: Projection, weights: FloatArray) -> None:
        """Change the weights of a projection; spikes in transit keep the old ones."""

    @abstractmethod
    def run_until(self, step: int) -> None:
        """Simulate to a grid point."""

    @abstractmethod
    def take_spikes(self) -> Spikes:
        """Return and remove the spikes of cells since the last call."""

    @abstractmethod
    def read(self, variable: str, neurons: IntArray) -> FloatArray:
        """Return a state variable of cells (global ids) in PyNN's unit.

        Raises:
            CapabilityError: one of them does not have it.
        """

    @abstractmethod
    def close(self) -> None:
        """Release the network."""


def _simplified(values: FloatArray) -> float | FloatArray:
    """Return a single number for equal ones, which is faster in PyNN."""
    return float(values[0]) if (values == values[0]).all() else values
