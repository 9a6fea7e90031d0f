"""The spikes that the source populations of a network emit according to their parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, nextafter
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.renewal import INTERVALS, RenewalTrains
from nrp_core.brain.devices.trains import PoissonPort, PoissonSource
from nrp_core.brain.network.data import Population
from nrp_core.errors import CapabilityError
from nrp_core.seeds import Seeds


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
        parts = [port.events(since_ms, until_ms) for port in self._ports]
        ids = np.concatenate([self._ids[first:last], *(part.neurons for part in parts)])
        times = np.concatenate([self._times_ms[first:last], *(part.times_ms for part in parts)])
        order = np.lexsort((ids, times))
        return ids[order], times[order]

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
        times = np.concatenate([self._times_ms[kept], *trains])
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
        self._take_trains(np.repeat(self._neurons[: len(trains)], lengths), np.concatenate([[], *trains]))
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
