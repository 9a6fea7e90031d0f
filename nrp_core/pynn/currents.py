"""How PyNN's current sources change with time."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import pi
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.sources import DCSource
from nrp_core.brain.interface import Brain
from nrp_core.clock import NS_PER_MS, nanoseconds
from nrp_core.network.grid import nearest_ns


class Waveform:
    """The current of a source, held constant between the times at which it changes.

    Args:
        source: one of PyNN's current sources.
        noise: random numbers for a noisy one.
        dt_ms: interval at which a sinusoidal current is updated, and the shortest for noise.

    Attributes:
        grid_ns: the steps of the simulator; each change is at the step nearest to its time.
    """

    def __init__(self, source: Any, noise: np.random.RandomState, dt_ms: float) -> None:
        self._source, self._noise, self._dt_ms = source, noise, dt_ms
        self._kind = type(source).__name__
        self._drawn = np.empty(0)
        self.grid_ns = 1

    def changes_ns(self, since_ns: int, until_ns: int) -> IntArray:
        """Return the times at which the current changes, ``since < t <= until``; not to be written to."""
        if self._kind == "StepCurrentSource":
            changes = np.unique(self._on_grid(self._source.times))
        elif self._kind == "DCSource":
            changes = np.unique(self._window_ns)
        else:
            changes = _multiples_ns(self._interval_ns, *self._window_ns, since_ns, until_ns)
        return changes[(changes > since_ns) & (changes <= until_ns)]

    def amplitudes_na(self, times_ns: IntArray) -> FloatArray:
        """Return the current from each of ascending times on, nA."""
        source = self._source
        if self._kind == "StepCurrentSource":
            steps = np.searchsorted(self._on_grid(source.times), times_ns, side="right")
            found: FloatArray = np.append(0.0, source.amplitudes)[steps]
            return found
        start_ns, stop_ns = self._window_ns
        acts = (start_ns <= times_ns) & (times_ns < stop_ns)
        since_ns = times_ns - start_ns
        if self._kind == "NoisyCurrentSource":
            values = self._noisy(np.where(acts, since_ns, 0) // self._interval_ns)
        elif self._kind == "ACSource":
            cycles = source.frequency * (since_ns / NS_PER_MS) * 1e-3 + source.phase / 360.0
            values = source.offset + source.amplitude * np.sin(2 * pi * cycles)
        else:
            values = np.full(len(times_ns), float(source.amplitude))
        return np.where(acts, values, 0.0)

    def _on_grid(self, times_ms: npt.ArrayLike) -> IntArray:
        return nearest_ns(nanoseconds(times_ms), self.grid_ns)

    @property
    def _window_ns(self) -> tuple[int, int]:
        start_ns, stop_ns = self._on_grid([self._source.start, self._source.stop]).tolist()
        return start_ns, stop_ns

    @property
    def _interval_ns(self) -> int:
        noisy = self._kind == "NoisyCurrentSource"
        interval_ms = max(float(self._source.dt), self._dt_ms) if noisy else self._dt_ms
        return max(1, self.grid_ns, int(self._on_grid(interval_ms)))

    def _noisy(self, intervals: IntArray) -> FloatArray:
        missing = int(intervals.max(initial=0)) + 1 - len(self._drawn)
        if missing > 0:
            self._drawn = np.append(self._drawn, self._noise.standard_normal(-(-missing // 256) * 256))
        found: FloatArray = self._source.mean + self._source.stdev * self._drawn[intervals]
        return found


@lru_cache(maxsize=16)
def _multiples_ns(interval_ns: int, start_ns: int, stop_ns: int, since_ns: int, until_ns: int) -> IntArray:
    """Return multiples of an interval from ``start`` to ``until``, and ``stop``; many sources share them."""
    end_ns = min(until_ns, stop_ns - 1)
    first, last = max(0, (since_ns - start_ns) // interval_ns), (end_ns - start_ns) // interval_ns
    times = start_ns + interval_ns * np.arange(first, last + 1)
    return np.append(times, stop_ns) if start_ns < stop_ns else np.empty(0, np.int64)


class Current:
    """A current source at work on cells.

    Args:
        source: one of PyNN's current sources.
        waveform: its waveform.
        cells: global ids.
    """

    def __init__(self, source: Any, waveform: Waveform, cells: IntArray) -> None:
        self.source, self.waveform, self.cells = source, waveform, cells
        self.restart()

    def restart(self) -> None:
        """Start again at time 0."""
        self._times: list[IntArray] = [np.zeros(0, np.int64)]
        self._amplitudes: list[FloatArray] = [np.zeros(1)]

    def run(self, times_ns: IntArray) -> FloatArray:
        """Return the current from ascending times on; it is kept as data."""
        amplitudes = self.waveform.amplitudes_na(times_ns)
        self._times.append(times_ns)
        self._amplitudes.append(amplitudes)
        return amplitudes

    def sampled_na(self, times_ns: IntArray) -> FloatArray:
        """Return the current at ascending times."""
        return np.concatenate(self._amplitudes)[
            np.searchsorted(np.concatenate(self._times), times_ns, side="right")
        ]


class Currents:
    """Currents at work on cells, which are one device of a brain.

    Args:
        currents: the currents.
        name: the name of the device.
    """

    def __init__(self, currents: Sequence[Current], name: str) -> None:
        self._currents, self._name = currents, name
        sizes = [len(current.cells) for current in currents]
        every = np.concatenate([current.cells for current in currents])
        self._cells, self._places = np.unique(every, return_inverse=True)
        self._owners = np.repeat(np.arange(len(sizes)), sizes)
        self._values = np.zeros(len(sizes))

    def start(self, brain: Brain) -> None:
        """Connect to the cells of a brain that was just opened."""
        for current in self._currents:
            current.waveform.grid_ns = brain.capabilities.resolution_ns or 1
        self._port: Any = brain.add_source(DCSource(), self._cells, name=self._name)

    def begin(self, now_ns: int) -> None:
        """Set the currents at the beginning of a run."""
        now = np.array([now_ns])
        self._values = np.concatenate([current.run(now) for current in self._currents])
        self._set()

    def prepare(self, since_ns: int, end_ns: int) -> IntArray:
        """Return the times, ``since < t <= end``, at which :meth:`update` is to be called in this run."""
        times = [current.waveform.changes_ns(since_ns, end_ns) for current in self._currents]
        amplitudes = [one.run(own) for one, own in zip(self._currents, times, strict=True)]
        every = np.concatenate(times)
        order = np.argsort(every, kind="stable")
        self._times, self._amplitudes = every[order], np.concatenate(amplitudes)[order]
        self._changed = np.repeat(np.arange(len(times)), [len(own) for own in times])[order]
        self._done = 0
        return np.unique(self._times)

    def update(self, now_ns: int) -> None:
        """Set the currents for the time from now on."""
        begin, self._done = self._done, int(np.searchsorted(self._times, now_ns, side="right"))
        if self._done > begin:
            self._values[self._changed[begin : self._done]] = self._amplitudes[begin : self._done]
            self._set()

    def _set(self) -> None:
        self._port.amplitude = np.bincount(self._places, self._values[self._owners], len(self._cells))
