"""NEST, by way of pyNN.nest. Importing this loads it."""

from __future__ import annotations

from typing import Any, Final

import nest
import numpy as np
import pyNN.nest as sim
from nrp_core.brain.network import RECEPTORS, STATIC, FloatArray, IntArray, Population, Projection
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import milliseconds
from nrp_core.errors import CapabilityError

from nrp_brain_pynn.driver import Driver

_MILLI: Final = 1000.0
_RELAYED: Final = " (relayed)"


class Direct(sim.SpikeSourceArray):  # type: ignore[misc]
    """Spike generators without the relays that PyNN puts behind them, which take a delay."""

    uses_parrot = False


class NestDriver(Driver):
    """See :class:`~nrp_brain_pynn.driver.Driver`. Spikes lie on the grid.

    NEST's generators have no plastic synapses: there PyNN's relays emit the spikes, one step later.
    """

    sim = sim

    def _set_up(self, longest_delay_ms: float) -> None:
        step_ms = self.grid.step_ms
        longest_ms = max(10.0, longest_delay_ms)
        sim.setup(timestep=step_ms, min_delay=step_ms, max_delay=longest_ms, spike_precision="on_grid")
        self._step = 0
        self._generators: dict[str, Any] = {}
        self._relayed: dict[str, Any] = {}
        self._trains: list[tuple[str, IntArray, IntArray, FloatArray]] = []

    def _sources(self, population: Population) -> Any:
        made = sim.Population(population.size, Direct(), label=population.label)
        self._generators[population.label] = made.node_collection
        return made

    def _cells(self, population: Population) -> Any:
        cells = super()._cells(population)
        if not hasattr(cells.celltype, "variable_map"):  # PyNN does not know where such cells keep v
            cells.node_collection.set(V_m=population.initial_values["v"].tolist())
        return cells

    def _connect(self, projection: Projection) -> None:
        pre, delays_ms = self.populations[projection.pre], self._delays_ms(projection)
        source = self.network.populations[projection.pre].is_source
        if source and projection.synapse_type != STATIC:
            pre = self._relays(projection.pre)
            delays_ms = np.maximum(delays_ms - self.grid.step_ms, self.grid.step_ms)
        self._projection(projection, pre, delays_ms)

    def _relays(self, label: str) -> Any:
        if label not in self._relayed:
            size = self.network.populations[label].size
            self._relayed[label] = made = sim.Population(size, sim.SpikeSourceArray(), label=label)
            self._generators[label + _RELAYED] = made.node_collection_source
        return self._relayed[label]

    def _begin(self) -> None:
        sim.simulator.state.run(0.0)  # connects the relays
        size = self.network.size
        self._recorder = nest.Create("spike_recorder", params={"time_in_steps": True})
        self._offsets_na = np.zeros(size)
        self._factors = np.ones((len(RECEPTORS), size))
        nodes = np.zeros(size, np.int64)
        for label in self.cell_labels:
            cells, ids = self.populations[label], self.network.ids_of(label)
            nest.Connect(cells.node_collection, self._recorder)
            nodes[ids] = cells.node_collection.tolist()
            self._offsets_na[ids] = self.network.populations[label].parameters["i_offset"]
            self._factors[:, ids] = _MILLI * getattr(cells.celltype, "receptor_scale", 1.0)
            if cells.celltype.conductance_based:
                self._factors[RECEPTORS.index("inhibitory"), ids] *= -1.0
        self._nodes = nodes
        self._ids = np.zeros(nodes.max(initial=0) + 1, np.int64)
        self._ids[nodes] = np.arange(size)
        self._held_na = self._offsets_na

    def fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        steps = self.grid.first_at(times_ms)
        for label, index, which in self.by_population(neurons):
            for key in (label, label + _RELAYED):
                if key in self._generators:
                    self._trains.append((key, index, steps[which], np.ones(len(index))))

    def inject(self, events: SynapticEvents) -> None:
        receptor = RECEPTORS.index(events.receptor)
        weights = events.weights * self._factors[receptor, events.neurons]
        # known a step before it arrives, an event arrives at the point after its time
        steps = np.maximum(self.grid.first_at(events.times_ms) - 1, self._step + 1)
        for label, index, which in self.by_population(events.neurons):
            key = f"{label} < {events.receptor}"
            if key not in self._generators:
                self._generators[key] = self._device_generators(label)
            self._trains.append((key, index, steps[which], weights[which]))

    def _device_generators(self, label: str) -> Any:
        cells = self.populations[label].node_collection
        generators = nest.Create("spike_generator", len(cells))
        nest.Connect(generators, cells, "one_to_one", {"weight": 1.0, "delay": self.grid.step_ms})
        return generators

    def run_until(self, step: int) -> None:
        self._feed(step)
        self._simulate(milliseconds((step - self._step) * self.grid.step_ns))
        self._step = step

    def _simulate(self, duration_ms: float) -> None:
        nest.Simulate(duration_ms)  # PyNN's own call asks NEST for its whole status, which grows

    def _feed(self, until: int) -> None:
        """Give the generators what they emit up to a grid point, and keep the rest."""
        later: list[tuple[str, IntArray, IntArray, FloatArray]] = []
        due: dict[str, list[tuple[IntArray, IntArray, FloatArray]]] = {}
        for key, index, steps, weights in self._trains:
            now = steps <= until
            if now.any():
                due.setdefault(key, []).append((index[now], steps[now], weights[now]))
            if not now.all():
                later.append((key, index[~now], steps[~now], weights[~now]))
        self._trains = later
        for key, parts in due.items():
            index, steps, weights = (np.concatenate(column) for column in zip(*parts, strict=True))
            self._hand_over(self._generators[key], index, steps, weights)

    def _hand_over(self, generators: Any, index: IntArray, steps: IntArray, weights: FloatArray) -> None:
        """Set the trains of generators by ``SetStatus``, which, unlike their ``set``, first reads nothing."""
        order = np.lexsort((steps, index))
        if 2 * len(np.unique(index)) > len(generators):  # choosing some takes longer than setting all
            borders = np.searchsorted(index[order], np.arange(1, len(generators)))
        else:
            busy, first = np.unique(index[order], return_index=True)
            generators, borders = generators[busy.tolist()], first[1:]
        times = np.split(self.grid.time_ms(steps[order]), borders)
        trains = zip(times, np.split(weights[order], borders), strict=True)
        nest.SetStatus(generators, [{"spike_times": at, "spike_weights": own} for at, own in trains])

    def set_currents(self, currents_na: FloatArray) -> None:
        wanted = self._offsets_na + currents_na
        for label, index, which in self.by_population(changed := np.flatnonzero(wanted != self._held_na)):
            amplitudes = (wanted[changed[which]] * _MILLI).tolist()
            self.populations[label].node_collection[index.tolist()].set(I_e=amplitudes)
        self._held_na = wanted

    def take_spikes(self) -> Spikes:
        (events,) = nest.GetStatus(self._recorder, "events")
        if not len(events["senders"]):
            return Spikes()
        nest.SetStatus(self._recorder, {"n_events": 0})
        return Spikes(self._ids[events["senders"]], self.grid.time_ms(events["times"]))

    def read(self, variable: str, neurons: IntArray) -> FloatArray:
        values = np.zeros(len(neurons))
        for label, index, which in self.by_population(neurons):
            kind = self.populations[label].celltype
            names = getattr(kind, "variable_map", {"v": "V_m"})
            if variable not in names:
                raise CapabilityError(f"the cells of population '{label}' have no '{variable}'")
            distinct, where = np.unique(index, return_inverse=True)
            nodes = self.populations[label].node_collection[distinct.tolist()]
            try:
                found = np.atleast_1d(np.asarray(nodes.get(names[variable]), dtype=float))
            except KeyError:  # NEST records it, but does not show it
                raise CapabilityError(f"NEST does not show '{variable}' of population '{label}'") from None
            values[which] = found[where] * getattr(kind, "scale_factors", {}).get(variable, 1.0)
        return values

    def close(self) -> None:
        self.populations.clear()
        nest.ResetKernel()
