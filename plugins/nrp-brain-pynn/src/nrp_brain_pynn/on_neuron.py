"""NEURON through pyNN.neuron. Importing this loads it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
import numpy.typing as npt
import pyNN.neuron as sim
from neuron import h, hclass
from nrp_core.brain import (
    FloatArray,
    IntArray,
    ParameterChange,
    Population,
    Projection,
    Spikes,
    SynapticEvents,
    no_variable,
)
from nrp_core.clock import milliseconds
from nrp_core.errors import CapabilityError
from pyNN.neuron.cells import NativeCellType

from nrp_brain_pynn.late_weights import LateWeightsDriver
from nrp_brain_pynn.neuron_synapses import in_order, weight_of
from nrp_brain_pynn.short_term import short_term

BoolArray = npt.NDArray[np.bool_]

_APART_MS: Final = 1e-6
"""Offset between simultaneous events, of which NEURON's artificial cells answer only one."""
_STEPS_BETWEEN_PROCESSES: Final = 2
_CRANK_NICOLSON: Final = 2
"""Order of NEURON's fixed-step method; its default is implicit Euler, of first order."""
_GATE: Final = 2.0
"""A weight that makes the relay fire, whose threshold is 1."""

_STATE: Final[dict[str, Callable[[Any], float]]] = {
    "v": lambda cell: cell.seg.v,
    "gsyn_exc": lambda cell: cell.esyn.g,
    "gsyn_inh": lambda cell: cell.isyn.g,
    "u": lambda cell: cell.izh.u,
    "w": lambda cell: cell.adexp.w,
}


class Relay(hclass(h.IntFire1)):  # type: ignore[misc]
    """An artificial cell that emits a spike for each event sent to it."""

    def __new__(cls, *_: Any, **__: Any) -> Relay:
        return super().__new__(cls)  # type: ignore[no-any-return]

    def __init__(self) -> None:
        self.tau, self.refrac = 1e-9, 0.0
        self.source, self.source_section, self.rec = self, None, None
        self.trigger = h.NetCon(None, self)
        self.trigger.weight[0] = _GATE


class RelayType(NativeCellType):  # type: ignore[misc]
    """PyNN's description of :class:`Relay`."""

    default_parameters: dict[str, float] = {}  # noqa: RUF012
    default_initial_values: dict[str, float] = {}  # noqa: RUF012
    receptor_types = ()
    injectable = conductance_based = False
    model = Relay


class ThresholdWatch:
    """The membranes of all cells of this process, and their thresholds.

    Args:
        cells: PyNN's objects by global id.
    """

    def __init__(self, cells: dict[int, Any]) -> None:
        self.neurons = np.array(list(cells), np.int64)
        self._pointers = h.PtrVector(max(1, len(cells)))
        self._found = h.Vector(max(1, len(cells)))
        self._thresholds = np.zeros(len(cells))
        for i, cell in enumerate(cells.values()):
            self._pointers.pset(i, cell.seg._ref_v)
            own = hasattr(cell, "get_threshold")
            self._thresholds[i] = cell.get_threshold() if own else cell.v_thresh

    def below(self) -> BoolArray:
        """Return which membranes are not above their threshold."""
        if not len(self.neurons):
            return np.empty(0, np.bool_)
        self._pointers.gather(self._found)
        below: BoolArray = np.asarray(self._found) <= self._thresholds  # as_numpy() leaks an object
        return below


class NeuronDriver(LateWeightsDriver):
    """See :class:`~nrp_brain_pynn.driver.Driver`. In an MPI job each process has a part of the cells."""

    sim = sim
    arrival_steps = 1  # an event at the end of a step acts in the next one

    def _set_up(self, longest_delay_ms: float) -> None:
        step_ms = self.grid.step_ms
        self._check_parallel()
        sim.setup(timestep=step_ms, min_delay=step_ms, max_delay=longest_delay_ms)
        h.secondorder = _CRANK_NICOLSON
        self._parallel = sim.simulator.state.parallel_context
        self._parallel.spike_compress(0, 0)  # PyNN's processes exchange times rounded to steps
        self._events: dict[tuple[int, str, float], Any] = {}
        self._connections: dict[str, list[Any]] = {}
        self._times, self._gids = h.Vector(), h.Vector()

    def _check_parallel(self) -> None:
        """Refuse delays too short for several processes, which exchange spikes once per shortest delay."""
        if sim.num_processes() == 1:
            return
        for projection in self.network.projections:
            if projection.size and self.grid.delays(projection.delay_ms).min() < _STEPS_BETWEEN_PROCESSES:
                shortest_ms = _STEPS_BETWEEN_PROCESSES * self.grid.step_ms
                raise CapabilityError(
                    f"projection '{projection.label}' has delays of less than {shortest_ms:g} ms, "
                    "the shortest for NEURON in several processes"
                )

    def _sources(self, population: Population) -> Any:
        return sim.Population(population.size, RelayType(), label=population.label)

    def _begin(self) -> None:
        super()._begin()
        size = self.network.size
        self._objects: list[Any] = [None] * size
        self._gid_to_id = np.zeros(sim.simulator.state.gid_counter, np.int64)
        for label, population in self.populations.items():
            for neuron, ident in zip(self.network.ids_of(label), population.all_cells, strict=True):
                self._gid_to_id[int(ident)] = neuron
                if ident.local:
                    self._objects[neuron] = ident._cell
                    if not self.network.populations[label].is_source:
                        self._parallel.spike_record(int(ident), self._times, self._gids)
        self._watch_thresholds()
        self._crossed = np.empty(0, np.int64)
        self._taken = self._finished = 0  # steps up to which spikes were returned, and simulated
        sim.run_until(0.0)  # later calls need an initialised simulator

    def _watch_thresholds(self) -> None:
        cells = {
            neuron: cell
            for neuron, cell in enumerate(self._objects)
            if cell is not None and not isinstance(cell, Relay)
        }
        self._watch = ThresholdWatch(cells)

    def fire(self, neurons: IntArray, times_ms: FloatArray) -> None:
        before: dict[int, float] = {}
        for neuron, time_ms in zip(neurons.tolist(), times_ms.tolist(), strict=True):
            last = before.get(neuron, -1.0)
            before[neuron] = at = time_ms if time_ms > last else last + _APART_MS
            if self._objects[neuron] is not None:
                self._objects[neuron].trigger.event(at)

    def inject(self, events: SynapticEvents) -> None:
        receptor, now_ms = events.receptor, sim.simulator.state.t
        columns = events.neurons.tolist(), events.times_ms.tolist(), events.weights.tolist()
        for neuron, time_ms, weight in zip(*columns, strict=True):
            if self._objects[neuron] is not None:
                synapse = self._events.get((neuron, receptor, weight))
                if synapse is None:
                    synapse = self._event(neuron, receptor, weight)
                synapse.event(max(time_ms, now_ms))

    def _event(self, neuron: int, receptor: str, weight: float) -> Any:
        synapse = h.NetCon(None, getattr(self._objects[neuron], receptor))
        synapse.weight[0] = weight
        self._events[neuron, receptor, weight] = synapse
        return synapse

    def _hold(self, label: str, index: IntArray, currents_na: FloatArray) -> None:
        for neuron, current_na in zip(index + self.network.offsets[label], currents_na.tolist(), strict=True):
            if self._objects[neuron] is not None:
                self._objects[neuron].i_offset = current_na

    def set_parameters(self, change: ParameterChange) -> None:
        super().set_parameters(change)
        self._watch_thresholds()

    def _synapses(self, projection: Projection) -> list[Any]:
        """Return PyNN's connections in the order of a projection, None for those of other processes."""
        if projection.label not in self._connections:
            made = list(self.projections[projection.label].connections)
            self._connections[projection.label] = in_order(
                made, projection, short_term(self.network, projection), self.grid
            )
        return self._connections[projection.label]

    def _write(self, projection: Projection, index: IntArray, weights: FloatArray) -> None:
        synapses = self._synapses(projection)
        for i, weight in zip(index.tolist(), weights.tolist(), strict=True):
            if synapses[i] is not None:
                weight_of(synapses[i], projection)[0] = weight

    def _weights_now(self, projection: Projection) -> FloatArray:
        synapses = self._synapses(projection)
        now = np.array([0.0 if one is None else one.nc.weight[0] for one in synapses])
        if self._parallel.nhost() > 1:
            now = np.sum(self._parallel.py_allgather(now), axis=0)
        return now

    def _pass(self, step: int) -> None:
        sim.run_until(milliseconds(step * self.grid.step_ns))

    def _finish(self, step: int) -> None:
        sim.run_until(milliseconds((step - 1) * self.grid.step_ns))
        below = self._watch.below()
        sim.run_until(milliseconds(step * self.grid.step_ns))
        self._crossed = self._watch.neurons[below & ~self._watch.below()]
        self._finished = step

    def take_spikes(self) -> Spikes:
        """Return spikes; those of the last step, which NEURON checks only in the next one, are found here."""
        # NEURON sums its steps, with rounding
        steps = np.rint(np.asarray(self._times) / self.grid.step_ms).astype(np.int64)
        neurons = self._gid_to_id[np.asarray(self._gids).astype(np.int64)]
        self._times.resize(0)
        self._gids.resize(0)
        fresh = steps > self._taken
        neurons = np.concatenate([neurons[fresh], self._crossed])
        steps = np.concatenate([steps[fresh], np.full(len(self._crossed), self._finished)])
        self._taken = self._finished
        if self._parallel.nhost() > 1:
            parts = self._parallel.py_allgather((neurons, steps))
            neurons, steps = (np.concatenate(column) for column in zip(*parts, strict=True))
        return Spikes(neurons, self.grid.time_ms(steps))

    def read(self, variable: str, neurons: IntArray) -> FloatArray:
        show = _STATE[variable]
        values = np.zeros(len(neurons))
        for i, neuron in enumerate(neurons.tolist()):
            if self._objects[neuron] is None:
                continue  # it is in another process
            try:
                values[i] = show(self._objects[neuron])
            except AttributeError:
                values[i] = np.nan
        if self._parallel.nhost() > 1:
            values = np.sum(self._parallel.py_allgather(values), axis=0)
        if np.isnan(values).any():
            label, _ = self.network.label_of(int(neurons[np.isnan(values)][0]))
            raise no_variable(label, variable)
        return values

    def close(self) -> None:
        sim.projections._projections.clear()  # PyNN keeps all of them, and NEURON would simulate their cells
        self.populations.clear()
        self._objects, self._events, self._connections = [], {}, {}
        sim.setup(timestep=self.grid.step_ms)
