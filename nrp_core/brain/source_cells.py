"""The spikes that the source populations of a network emit by their own parameters."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrp_core.brain.network import FloatArray, IntArray, Population
from nrp_core.brain.trains import PoissonPort, PoissonSource
from nrp_core.errors import CapabilityError
from nrp_core.seeds import Seeds


class PopulationTrains:
    """The trains of one source population (``SpikeSourcePoisson``, ``SpikeSourceArray``).

    Args:
        population: the cells.
        neurons: their global ids.
        seeds: of the brain.

    Raises:
        CapabilityError: another kind of source cells.
    """

    def __init__(self, population: Population, neurons: IntArray, seeds: Seeds) -> None:
        self._ports: list[PoissonPort] = []
        trains = population.spike_times_ms
        if population.cell_type == "SpikeSourcePoisson":
            self._ports = _poisson_ports(population, neurons, seeds)
        elif population.cell_type != "SpikeSourceArray":
            raise CapabilityError(
                f"source cells of type {population.cell_type} are not known; use SpikeSourcePoisson"
            )
        ids = np.repeat(neurons[: len(trains)], [len(train) for train in trains])
        times = np.concatenate([np.empty(0), *trains])
        order = np.lexsort((ids, times))
        self._ids, self._times_ms = ids[order], times[order]

    def emitted(self, since_ms: float, until_ms: float) -> tuple[IntArray, FloatArray]:
        """Return ids and times of the spikes with ``since_ms < t <= until_ms``; t = 0 counts as after 0."""
        first = int(self._times_ms.searchsorted(since_ms, "left" if since_ms == 0.0 else "right"))
        last = int(self._times_ms.searchsorted(until_ms, "right"))
        parts = [port.events(since_ms, until_ms) for port in self._ports]
        ids = np.concatenate([self._ids[first:last], *(part.neurons for part in parts)])
        times = np.concatenate([self._times_ms[first:last], *(part.times_ms for part in parts)])
        order = np.lexsort((ids, times))
        return ids[order], times[order]

    def reset(self, seeds: Seeds) -> None:
        """Start anew at time 0."""
        for port in self._ports:
            port.reset(seeds)

    def save(self) -> object:
        """Return everything that changes while running."""
        return [port.save() for port in self._ports]

    def restore(self, saved: Any) -> None:
        """Return to what :meth:`save` gave."""
        for port, state in zip(self._ports, saved, strict=True):
            port.restore(state)


def _poisson_ports(population: Population, neurons: IntArray, seeds: Seeds) -> list[PoissonPort]:
    """Return one port for each distinct start and duration among the cells."""
    parameters = population.parameters
    windows = np.stack([parameters["start"], parameters["duration"]], axis=1)
    ports: list[PoissonPort] = []
    for i, (start, duration) in enumerate(np.unique(windows, axis=0).tolist()):
        chosen = (windows == (start, duration)).all(axis=1)
        spec = PoissonSource(
            rate=parameters["rate"][chosen], weight=1.0, delay=0.0, start=start, duration=duration
        )
        ports.append(PoissonPort(spec, neurons[chosen], seeds, f"population/{population.label}/{i}"))
    return ports
