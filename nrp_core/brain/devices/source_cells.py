"""The spikes that the source populations of a network emit according to their parameters.

The k-th intervals of all cells are drawn together, in the order of k. So a train depends neither on how a run
is split nor on the other cells' rates.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from math import inf, nextafter
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.ports import NO_EVENTS
from nrp_core.brain.devices.trains import PoissonPort, PoissonSource
from nrp_core.brain.spikes import Spikes, SynapticEvents
from nrp_core.clock import MS_PER_S, NS_PER_MS, nanoseconds, without_rounding_errors
from nrp_core.errors import CapabilityError
from nrp_core.network.data import Population
from nrp_core.network.grid import Grid
from nrp_core.seeds import Seeds

Parameters = Mapping[str, FloatArray]


def _gamma(rng: np.random.Generator, own: Parameters) -> FloatArray:
    """Return an interval of each cell, ms: the mean is ``alpha / beta`` seconds."""
    with np.errstate(divide="ignore"):
        return np.asarray(rng.standard_gamma(own["alpha"]) * (MS_PER_S / own["beta"]))


def _refractory(rng: np.random.Generator, own: Parameters) -> FloatArray:
    """Return an interval of each cell, ms: the dead time, and an exponential for the rest of the mean."""
    with np.errstate(divide="ignore"):
        free_ms = MS_PER_S / own["rate"] - own["tau_refrac"]
    return np.asarray(own["tau_refrac"] + rng.standard_exponential(len(free_ms)) * free_ms)


INTERVALS: Final[Mapping[str, Callable[[np.random.Generator, Parameters], FloatArray]]] = {
    "SpikeSourceGamma": _gamma,
    "SpikeSourcePoissonRefractory": _refractory,
}
"""The law of the intervals of each cell type."""


class RenewalTrains:
    """The trains of some cells. The first interval begins at ``start``, or when the train is opened.

    Args:
        cell_type: one of :data:`INTERVALS`.
        parameters: its parameters, PyNN's names and units.
        neurons: global ids.
        seeds: the family of random streams.
        name: the name of the stream.
    """

    def __init__(
        self, cell_type: str, parameters: Parameters, neurons: IntArray, seeds: Seeds, name: str
    ) -> None:
        self._law, self._own, self._neurons = INTERVALS[cell_type], parameters, neurons
        borders_ns = nanoseconds(parameters["start"]) + nanoseconds(parameters["duration"])
        self._stop_ms = borders_ns / NS_PER_MS
        self._rng = seeds.stream(name)
        self._rows: deque[FloatArray] = deque()
        self._first_row = 0
        self._drawn = np.zeros(len(neurons), np.int64)
        self._next_ms: FloatArray | None = None

    def events(self, since_ms: float, until_ms: float) -> SynapticEvents:
        """Return the spikes with ``since_ms < t <= until_ms``."""
        cells = np.arange(len(self._neurons))
        if self._next_ms is None:
            begin_ms = np.maximum(self._own["start"], since_ms)
            self._next_ms = begin_ms + self._intervals(cells)
        times_ms, fired = [], []
        while (due := np.flatnonzero(self._next_ms <= until_ms)).size:
            spikes_ms = self._next_ms[due]
            goes_on = spikes_ms < self._stop_ms[due]
            times_ms.append(spikes_ms[goes_on])
            fired.append(self._neurons[due[goes_on]])
            self._next_ms[due] = np.where(goes_on, spikes_ms + self._intervals(due), inf)
        if not times_ms:
            return NO_EVENTS
        times, ids = np.concatenate(times_ms), np.concatenate(fired)
        return SynapticEvents(ids, times, np.ones(len(ids)))

    def _intervals(self, cells: IntArray) -> FloatArray:
        """Return the next interval of some cells, ms."""
        rows = self._drawn[cells]
        while self._first_row + len(self._rows) <= rows.max(initial=-1):
            self._rows.append(self._law(self._rng, self._own))
        table = np.array(self._rows)
        found: FloatArray = table[rows - self._first_row, cells]
        self._drawn[cells] += 1
        going = self._drawn if self._next_ms is None else self._drawn[np.isfinite(self._next_ms)]
        while self._rows and self._first_row < going.min(initial=self._first_row + len(self._rows)):
            self._rows.popleft()
            self._first_row += 1
        return found

    def save(self) -> object:
        """Return all state that changes while running."""
        next_ms = None if self._next_ms is None else self._next_ms.copy()
        rows = [row.copy() for row in self._rows]
        return self._rng.bit_generator.state, rows, self._first_row, self._drawn.copy(), next_ms

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        self._rng.bit_generator.state, rows, self._first_row, drawn, next_ms = saved
        self._rows, self._drawn = deque(rows), drawn.copy()
        self._next_ms = None if next_ms is None else next_ms.copy()


Train = tuple[list[float], list[float]]
"""Times (ms, ascending) and weights."""


class TrainQueue:
    """Queued spikes by the number of their emitter.

    Args:
        grid: the simulator's time grid.
    """

    def __init__(self, grid: Grid) -> None:
        self._grid = grid
        self._waiting: list[tuple[IntArray, IntArray, FloatArray]] = []

    def put(self, emitters: IntArray, steps: IntArray, weights: FloatArray) -> None:
        """Add spikes: numbers of emitters, points of the grid, weights, each of shape ``(n,)``."""
        self._waiting.append((emitters, steps, weights))

    def take(self, until_step: int) -> tuple[IntArray, list[Train]]:
        """Return and remove the spikes up to a grid point: the emitters, ascending, and a train for each."""
        if not self._waiting:
            return np.empty(0, np.int64), []
        emitters, steps, weights = map(np.concatenate, zip(*self._waiting, strict=True))
        later = steps > until_step
        self._waiting = [(emitters[later], steps[later], weights[later])] if later.any() else []
        order = np.lexsort((steps, emitters))
        order = order[~later[order]]
        if not order.size:
            return order, []
        emitters = emitters[order]
        times_ms, sizes = self._grid.time_ms(steps[order]).tolist(), weights[order].tolist()
        first = [0, *(np.flatnonzero(emitters[1:] != emitters[:-1]) + 1).tolist()]
        borders = pairwise([*first, emitters.size])
        return emitters[first], [(times_ms[a:b], sizes[a:b]) for a, b in borders]


class PopulationTrains:
    """The spike trains of one source population.

    Args:
        population: the cells.
        neurons: the cells' global ids.
        seeds: the brain's random seeds.

    Raises:
        CapabilityError: an unsupported type of source cells.
    """

    def __init__(self, population: Population, neurons: IntArray, seeds: Seeds) -> None:
        if population.cell_type not in ("SpikeSourcePoisson", "SpikeSourceArray", *INTERVALS):
            raise CapabilityError(
                f"source cells of type {population.cell_type} are not supported; use SpikeSourcePoisson"
            )
        self._population, self._neurons = population, neurons
        self._parameters: Mapping[str, FloatArray] = population.parameters
        self._ids, self._times_ms = np.empty(0, np.int64), np.empty(0)
        self.reset(seeds)

    @property
    def _renews(self) -> bool:
        return self._population.cell_type in INTERVALS

    @property
    def label(self) -> str:
        """Label of the population."""
        return self._population.label

    def emitted(self, since_ms: float, until_ms: float) -> tuple[IntArray, FloatArray]:
        """Return ids and times of the spikes with ``since_ms < t <= until_ms``; t = 0 counts as after 0."""
        first = int(self._times_ms.searchsorted(since_ms, "left" if since_ms == 0.0 else "right"))
        last = int(self._times_ms.searchsorted(until_ms, "right"))
        if first == last and not self._ports:
            return self._ids[:0], self._times_ms[:0]
        drawn = [port.events(since_ms, until_ms) for port in self._ports]
        parts = [Spikes(part.neurons, part.times_ms) for part in drawn]
        merged = Spikes.merged([Spikes(self._ids[first:last], self._times_ms[first:last]), *parts])
        return merged.neurons, merged.times_ms

    def set_parameters(self, index: IntArray, values: Mapping[str, FloatArray]) -> None:
        """Change parameters of the population's cells from now on; trains of intervals begin anew."""
        changed = {name: array.copy() for name, array in self._parameters.items()}
        for name, array in values.items():
            changed[name][index] = array
        self._parameters = changed
        if values.keys() == {"rate"} and not self._renews:
            for port, chosen in zip(self._ports, self._windows()[1], strict=True):
                assert isinstance(port, PoissonPort)
                port.rate = self._parameters["rate"][chosen]
        else:
            self._generation += 1
            self._open_ports()

    def set_spike_times(self, index: IntArray, trains: Sequence[FloatArray], now_ms: float) -> None:
        """Replace the spike trains of cells; spikes before the current time are ignored.

        A spike at exactly the current time is emitted unless the old train had one, which is already emitted.
        """
        chosen = self._neurons[index]
        done = self._ids[(self._times_ms == now_ms) & (now_ms > 0.0)]
        kept = ~np.isin(self._ids, chosen)
        ids = np.concatenate([self._ids[kept], np.repeat(chosen, [len(train) for train in trains])])
        times = np.concatenate([self._times_ms[kept], *map(without_rounding_errors, trains)])
        late = (times == now_ms) & ~np.isin(ids, done) & (now_ms > 0.0)
        self._take_trains(ids, np.where(late, nextafter(now_ms, inf), times))
        self._trains_changed = True

    def reset(self, seeds: Seeds) -> None:
        """Restart at time 0, with the parameters of the network."""
        self._seeds = seeds
        self._generation = 0
        self._parameters = self._population.parameters
        self._open_ports()
        self._take_given()

    def save(self) -> object:
        """Return all state that changes while running."""
        poisson = dict(self._parameters), self._generation, [port.save() for port in self._ports]
        return poisson, (self._ids, self._times_ms) if self._trains_changed else None

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        (self._parameters, self._generation, states), trains = saved
        self._take_given()
        if trains is not None:
            self._ids, self._times_ms = trains
            self._trains_changed = True
        self._open_ports()
        for port, state in zip(self._ports, states, strict=True):
            port.restore(state)

    def _take_given(self) -> None:
        trains = self._population.spike_times_ms
        lengths = [len(train) for train in trains]
        times_ms = without_rounding_errors(np.concatenate([[], *trains]))
        self._take_trains(np.repeat(self._neurons[: len(trains)], lengths), times_ms)
        self._trains_changed = False

    def _take_trains(self, ids: IntArray, times_ms: FloatArray) -> None:
        order = np.lexsort((ids, times_ms))
        self._ids, self._times_ms = ids[order], times_ms[order]

    def _open_ports(self) -> None:
        """Open one port for each distinct start and duration among Poisson cells; one for other laws."""
        self._ports: list[PoissonPort | RenewalTrains] = []
        again = f"/{self._generation}" if self._generation else ""
        if self._renews and "duration" in self._parameters:  # a description of a network has none
            name = f"population/{self.label}{again}"
            kind = self._population.cell_type
            self._ports = [RenewalTrains(kind, self._parameters, self._neurons, self._seeds, name)]
        if self._renews or "rate" not in self._parameters:
            return
        windows, members = self._windows()
        for i, ((start, duration), chosen) in enumerate(zip(windows.tolist(), members, strict=True)):
            rates = self._parameters["rate"][chosen]
            spec = PoissonSource(rate=rates, weight=1.0, delay=0.0, start=start, duration=duration)
            name = f"population/{self.label}/{i}{again}"
            self._ports.append(PoissonPort(spec, self._neurons[chosen], self._seeds, name))

    def _windows(self) -> tuple[FloatArray, list[IntArray]]:
        """Return the distinct starts and durations, shape ``(n, 2)``, and the index of each cell's pair."""
        pairs = np.stack([self._parameters["start"], self._parameters["duration"]], axis=1)
        distinct, which = np.unique(pairs, axis=0, return_inverse=True)
        return distinct, [np.flatnonzero(which == i) for i in range(len(distinct))]
