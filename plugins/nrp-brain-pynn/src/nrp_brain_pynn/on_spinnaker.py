"""SpiNNaker boards through sPyNNaker. Importing this loads it.

The machine is mapped at the first step. A step is one run of the machine, which then pauses: its spikes are
read and those for the next step are written. So it runs in lockstep with the loop, not in real time.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pyNN.spiNNaker as sim  # noqa: N813
from nrp_core.brain import FloatArray, IntArray, Population, Projection, Spikes, SynapticEvents, TrainQueue
from nrp_core.clock import milliseconds
from nrp_core.errors import BackendLoadError, CapabilityError
from spinn_utilities.configs.no_config_found_exception import NoConfigFoundException

from nrp_brain_pynn.driver import Driver
from nrp_brain_pynn.loading import quietly

_CELLS_A_CORE: Final = 64
"""Limits of a core in real time with steps of 1 ms; a spike can have 255 synapses on one core."""


class SpinnakerDriver(Driver):
    """See :class:`~nrp_brain_pynn.driver.Driver`.

    An event of a device is a spike of a separate source cell, because weights belong to synapses there. These
    must be known when the machine is mapped.
    """

    sim = sim

    def _set_up(self, longest_delay_ms: float) -> None:
        try:
            sim.setup(timestep=self.grid.step_ms, min_delay=self.grid.step_ms)
        except NoConfigFoundException:
            raise BackendLoadError(
                "sPyNNaker does not know which board to use; write machineName and version, or "
                "virtual_board = True to map only, into the section [Machine] of ~/.spynnaker.cfg"
            ) from None
        for cell_type in self.options.chosen.cells:
            sim.set_number_of_neurons_per_core(self._kind(cell_type), _CELLS_A_CORE)
        self._queues: dict[Any, TrainQueue] = {}
        self._devices: dict[tuple[str, str, float], Any] = {}
        self._step = 0

    def _cells(self, population: Population) -> Any:
        kind = self._kind(population.cell_type)
        cells = sim.Population(population.size, kind(**population.parameters), label=population.label)
        initial = population.initial_values
        cells.initialize(**{name: initial[name] for name in ("v", "u") if name in initial})
        cells.record("spikes")
        return cells

    def _sources(self, population: Population) -> Any:
        return self._source(population.size, population.label)

    def _source(self, size: int, label: str) -> Any:
        made = sim.Population(size, sim.SpikeSourceArray(spike_times=[]), label=label)
        self._queues[made] = TrainQueue(self.grid)
        return made

    def _begin(self) -> None:
        """Do nothing, because the first run maps the machine."""

    def fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        steps = self.grid.first_at(times_ms)
        for label, index, which in self.by_population(neurons):
            self._queues[self.populations[label]].put(index, steps[which], np.ones(len(index)))

    def inject(self, events: SynapticEvents) -> None:
        steps = np.maximum(self.grid.first_at(events.times_ms) - 1, self._step)
        for label, index, which in self.by_population(events.neurons):
            for weight in np.unique(events.weights[which]).tolist():
                chosen = events.weights[which] == weight
                source = self._device(label, events.receptor, weight)
                self._queues[source].put(index[chosen], steps[which][chosen], np.ones(int(chosen.sum())))

    def _device(self, label: str, receptor: str, weight: float) -> Any:
        key = label, receptor, weight
        if key not in self._devices:
            if self._step:
                raise CapabilityError(
                    f"a device drives population '{label}' with the weight {weight:g}, which no device had "
                    "in the first step; SpiNNaker gets no new synapses while it runs"
                )
            cells = self.populations[label]
            source = self._source(cells.size, f"{label} < {receptor} {weight:g}")
            static = sim.StaticSynapse(weight=weight, delay=self.grid.step_ms)
            sim.Projection(source, cells, sim.OneToOneConnector(), static, receptor_type=receptor)
            self._devices[key] = source
        return self._devices[key]

    def run_until(self, step: int) -> None:
        for source, queue in self._queues.items():
            self._emit(source, queue, step)
        with quietly():
            sim.run(milliseconds((step - self._step) * self.grid.step_ns))
        self._since_ms, self._step = self._step * self.grid.step_ms, step

    def _emit(self, source: Any, queue: TrainQueue, until: int) -> None:
        """Set the due spikes of source cells; ``set`` of sPyNNaker 7.4.1 fails with individual trains."""
        busy, trains = queue.take(until)
        if not trains:
            return
        steps = np.empty(source.size, object)
        steps[:] = [np.empty(0, np.int64)] * source.size
        for cell, (times_ms, _) in zip(busy.tolist(), trains, strict=True):
            steps[cell] = self.grid.first_at(np.array(times_ms))
        source._vertex.send_buffer_times = steps

    def take_spikes(self) -> Spikes:
        neurons, times_ms = [np.empty(0, np.int64)], [np.empty(0)]
        for label in self.cell_labels:
            with quietly():
                found = self.populations[label].spinnaker_get_data("spikes").reshape(-1, 2)  # since the start
            fresh = found[found[:, 1] >= self._since_ms]
            neurons.append(self.network.offsets[label] + fresh[:, 0].astype(np.int64))
            times_ms.append(fresh[:, 1] + self.grid.step_ms)  # they are at the end of their step
        return Spikes(np.concatenate(neurons), np.concatenate(times_ms))

    def _hold(self, label: str, index: IntArray, currents_na: FloatArray) -> None:
        ids = self.network.ids_of(label)
        wanted = self._held_na[ids]
        wanted[index] = currents_na
        self.populations[label].set(i_offset=wanted)

    def read(self, variable: str, neurons: IntArray) -> FloatArray:
        raise NotImplementedError(variable)  # without declared ones

    def read_weights(self, projection: Projection) -> FloatArray:
        raise NotImplementedError(projection.label)

    def set_weights(self, projection: Projection, weights: FloatArray) -> None:
        raise NotImplementedError(projection.label)

    def close(self) -> None:
        self.populations.clear()
        self._queues.clear()
        with quietly():
            sim.end()
