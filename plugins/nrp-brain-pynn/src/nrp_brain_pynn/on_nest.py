"""NEST through pyNN.nest. Importing this loads it."""

from __future__ import annotations

from typing import Any, Final

import nest
import numpy as np
import pyNN.nest as sim
from nrp_core.brain import (
    RECEPTORS,
    STATIC,
    FloatArray,
    IntArray,
    Population,
    Projection,
    Spikes,
    SynapticEvents,
    flushing_subnormals,
    no_variable,
    same_order,
)
from nrp_core.clock import milliseconds
from nrp_core.errors import CapabilityError

from nrp_brain_pynn.driver import Driver
from nrp_brain_pynn.nest_trains import Trains, put
from nrp_brain_pynn.short_term import short_term

_MILLI: Final = 1000.0
_NO_POTENTIATION: Final = 1e-12
"""PyNN passes depression to NEST as a ratio to potentiation, which therefore cannot be 0."""


class Direct(sim.SpikeSourceArray):  # type: ignore[misc]
    """Spike generators without PyNN's relays, which add a delay."""

    uses_parrot = False


class NestDriver(Driver):
    """See :class:`~nrp_brain_pynn.driver.Driver`. Spikes are on the grid.

    NEST's generators cannot have plastic synapses: for these PyNN's relays emit the spikes, one step later.
    """

    sim = sim

    def _set_up(self, longest_delay_ms: float) -> None:
        step_ms = self.grid.step_ms
        longest_ms = max(10.0, longest_delay_ms)
        sim.setup(timestep=step_ms, min_delay=step_ms, max_delay=longest_ms, spike_precision="on_grid")
        self._step = 0
        self._trains = Trains(self.grid)
        self._relayed: dict[str, Any] = {}
        self._weights: dict[str, FloatArray] = {}
        self._of_sources = np.full((2, self.network.size), -1)
        self._of_devices = np.full((len(RECEPTORS), self.network.size), -1)

    def _sources(self, population: Population) -> Any:
        made = sim.Population(population.size, Direct(), label=population.label)
        self._of_sources[0, self.network.ids_of(population.label)] = self._trains.add(made.node_collection)
        return made

    def _cells(self, population: Population) -> Any:
        cells = super()._cells(population)
        if not hasattr(cells.celltype, "variable_map"):  # PyNN does not know the name of v in such cells
            cells.node_collection.set(V_m=population.initial_values["v"].tolist())
        return cells

    def _connect(self, projection: Projection) -> Any:
        pre, delays_ms = self.populations[projection.pre], self._delays_ms(projection)
        if self._is_relayed(projection):
            pre, delays_ms = self._relays(projection.pre), self.grid.time_ms(self._steps(projection))
        return self._projection(projection, pre, delays_ms)

    def _stdp_parameters(self, projection: Projection) -> dict[str, float]:
        """Return the parameters of a rule; PyNN scales weights onto delta cells, but not their limits."""
        given = super()._stdp_parameters(projection)
        given["A_plus"] = given["A_plus"] or _NO_POTENTIATION
        scale = getattr(self.populations[projection.post].celltype, "receptor_scale", 1.0)
        return given | {name: given[name] * scale for name in ("w_min", "w_max") if name in given}

    def _is_relayed(self, projection: Projection) -> bool:
        return self.network.populations[projection.pre].is_source and projection.synapse_type != STATIC

    def _steps(self, projection: Projection) -> IntArray:
        """Return delays in steps, minus one for a relay."""
        return np.maximum(self.grid.delays(projection.delay_ms) - self._is_relayed(projection), 1)

    def _relays(self, label: str) -> Any:
        if label not in self._relayed:
            size = self.network.populations[label].size
            self._relayed[label] = made = sim.Population(size, sim.SpikeSourceArray(), label=label)
            numbers = self._trains.add(made.node_collection_source)
            self._of_sources[1, self.network.ids_of(label)] = numbers
        return self._relayed[label]

    def _begin(self) -> None:
        sim.simulator.state.run(0.0)  # connects the relays
        size = self.network.size
        self._recorder = nest.Create("spike_recorder", params={"time_in_steps": True})
        self._factors = np.ones((len(RECEPTORS), size))
        nodes = np.zeros(size, np.int64)
        for label in self.cell_labels:
            cells, ids = self.populations[label], self.network.ids_of(label)
            nest.Connect(cells.node_collection, self._recorder)
            nodes[ids] = cells.node_collection.tolist()
            self._factors[:, ids] = _MILLI * getattr(cells.celltype, "receptor_scale", 1.0)
            if cells.celltype.conductance_based:
                self._factors[RECEPTORS.index("inhibitory"), ids] *= -1.0
        self._nodes = nodes
        self._ids = np.zeros(nodes.max(initial=0) + 1, np.int64)
        self._ids[nodes] = np.arange(size)

    def fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        steps = self.grid.first_at(times_ms)
        for numbers in self._of_sources[:, neurons]:
            used = numbers >= 0
            if used.any():
                self._trains.send(numbers[used], steps[used], np.ones(used.sum()))

    def inject(self, events: SynapticEvents) -> None:
        receptor = RECEPTORS.index(events.receptor)
        numbers = self._of_devices[receptor]
        if (unknown := numbers[events.neurons] < 0).any():
            new = np.unique(events.neurons[unknown])
            numbers[new] = self._trains.add(self._device_generators(new))
        # an event known one step before arrives at the grid point after its time
        steps = np.maximum(self.grid.first_at(events.times_ms) - 1, self._step + 1)
        weights = events.weights * self._factors[receptor, events.neurons]
        self._trains.send(numbers[events.neurons], steps, weights)

    def _device_generators(self, neurons: IntArray) -> Any:
        generators = nest.Create("spike_generator", neurons.size)
        synapse = {"weight": np.ones(neurons.size), "delay": np.full(neurons.size, self.grid.step_ms)}
        nest.Connect(np.array(generators.tolist()), self._nodes[neurons], "one_to_one", synapse)
        return generators

    def run_until(self, step: int) -> None:
        self._trains.feed(step)
        self._simulate(milliseconds((step - self._step) * self.grid.step_ns))
        self._step = step

    def _simulate(self, duration_ms: float) -> None:
        with flushing_subnormals():  # silent cells decay to such numbers
            nest.Simulate(duration_ms)  # PyNN's own call reads NEST's whole status, which grows

    def _hold(self, label: str, index: IntArray, currents_na: FloatArray) -> None:
        cells = self.populations[label].node_collection[index.tolist()]
        cells.set(I_e=(currents_na * _MILLI).tolist())

    def read_weights(self, projection: Projection) -> FloatArray:
        now = np.empty(projection.size)
        if projection.size:
            synapses, ours, theirs = self._synapses(projection)
            now[ours] = np.atleast_1d(synapses.get("weight"))[theirs]
        return now / self._factors_of(projection)

    def set_weights(self, projection: Projection, weights: FloatArray) -> None:
        if projection.size:
            synapses, ours, theirs = self._synapses(projection)
            wanted = np.empty(projection.size)
            wanted[theirs] = (weights * self._factors_of(projection))[ours]
            synapses.set([{"weight": weight} for weight in wanted.tolist()])
            self._weights[projection.label] = weights

    def _factors_of(self, projection: Projection) -> FloatArray:
        post = self.network.offsets[projection.post] + projection.post_index
        factors: FloatArray = self._factors[RECEPTORS.index(projection.receptor), post]
        return factors

    def _synapses(self, projection: Projection) -> tuple[Any, IntArray, IntArray]:
        """Return NEST's synapses of a projection, and the sort orders that match ours to NEST's."""
        made = self.projections[projection.label]
        synapses = nest.GetConnections(synapse_label=made.nest_synapse_label)
        weights = self._weights.get(projection.label, projection.weight)
        ours = {
            "source": np.array(made.pre.node_collection.tolist())[projection.pre_index],
            "target": np.array(made.post.node_collection.tolist())[projection.post_index],
            "weight": weights * self._factors_of(projection),
        }
        for name, values in short_term(self.network, projection).items():
            ours[name.removesuffix("il")] = values
        theirs = synapses.get([*ours, "delay"])
        ours["delay"] = self._steps(projection)
        theirs["delay"] = self.grid.delays(np.asarray(theirs["delay"]))
        return synapses, *same_order(ours, theirs)

    def take_spikes(self) -> Spikes:
        events = self._recorder.get("events")
        if not len(events["senders"]):
            return Spikes()
        put(self._recorder, [{"n_events": 0}])
        return Spikes(self._ids[events["senders"]], self.grid.time_ms(events["times"]))

    def read(self, variable: str, neurons: IntArray) -> FloatArray:
        values = np.zeros(len(neurons))
        for label, index, which in self.by_population(neurons):
            kind = self.populations[label].celltype
            names = getattr(kind, "variable_map", {"v": "V_m"})
            if variable not in names:
                raise no_variable(label, variable)
            distinct, where = np.unique(index, return_inverse=True)
            nodes = self.populations[label].node_collection[distinct.tolist()]
            try:
                found = np.atleast_1d(np.asarray(nodes.get(names[variable]), dtype=float))
            except KeyError:  # NEST can record it, but not read it
                raise CapabilityError(f"NEST does not expose '{variable}' of population '{label}'") from None
            values[which] = found[where] * getattr(kind, "scale_factors", {}).get(variable, 1.0)
        return values

    def close(self) -> None:
        self.populations.clear()
        nest.ResetKernel()
