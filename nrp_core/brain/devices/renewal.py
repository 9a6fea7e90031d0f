"""Spike trains of independent intervals, drawn by the core: gamma processes, and Poisson with a dead time.

The k-th intervals of all cells are drawn together, in the order of k. So a train depends neither on how a run
is split nor on the other cells' rates.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from math import inf
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.ports import NO_EVENTS
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.clock import MS_PER_S
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
        self._stop_ms = parameters["start"] + parameters["duration"]
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
