"""How PyNN's current sources change with time."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import pi
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.sources import DCSource
from nrp_core.brain.interface import Brain
from nrp_core.clock import NS_PER_MS, from_milliseconds, milliseconds

_ROUNDING: Final = 1e-6


class Waveform:
    """The current of a source, held constant between the times at which it changes.

    Args:
        source: one of PyNN's current sources.
        noise: random numbers for a noisy one.
        dt_ms: interval at which a sinusoidal current is updated, and the shortest for noise.
    """

    def __init__(self, source: Any, noise: np.random.RandomState, dt_ms: float) -> None:
        self._source, self._noise, self._dt_ms = source, noise, dt_ms
        self._kind = type(source).__name__
        self._drawn = np.empty(0)

    def changes_ns(self, since_ns: int, until_ns: int) -> IntArray:
        """Return the times at which the current changes, ``since < t <= until``; not to be written to."""
        source = self._source
        if self._kind == "StepCurrentSource":
            changes = _nearest_ns(source.times, since_ns, until_ns)
        elif self._kind == "DCSource":
            changes = _nearest_ns(np.array([source.start, source.stop]), since_ns, until_ns)
        else:
            changes = _grid_ns(self._interval_ms, source.start, source.stop, since_ns, until_ns)
        return changes

    def amplitudes_na(self, times_ns: IntArray) -> FloatArray:
        """Return the current from each of ascending times on, nA."""
        source, times_ms = self._source, times_ns / NS_PER_MS
        if self._kind == "StepCurrentSource":
            steps = np.searchsorted(source.times, times_ms, side="right")
            found: FloatArray = np.append(0.0, source.amplitudes)[steps]
            return found
        acts = (source.start <= times_ms) & (times_ms < source.stop)
        if self._kind == "NoisyCurrentSource":
            values = self._noisy(np.where(acts, times_ms, source.start))
        elif self._kind == "ACSource":
            cycles = source.frequency * (times_ms - source.start) * 1e-3 + source.phase / 360.0
            values = source.offset + source.amplitude * np.sin(2 * pi * cycles)
        else:
            values = np.full(len(times_ms), float(source.amplitude))
        return np.where(acts, values, 0.0)

    @property
    def _interval_ms(self) -> float:
        noisy = self._kind == "NoisyCurrentSource"
        return max(float(self._source.dt), self._dt_ms) if noisy else self._dt_ms

    def _noisy(self, times_ms: FloatArray) -> FloatArray:
        intervals = np.floor((times_ms - self._source.start) / self._interval_ms + _ROUNDING).astype(np.int64)
        missing = int(intervals.max(initial=0)) + 1 - len(self._drawn)
        if missing > 0:
            self._drawn = np.append(self._drawn, self._noise.standard_normal(-(-missing // 256) * 256))
        found: FloatArray = self._source.mean + self._source.stdev * self._drawn[intervals]
        return found


def _nearest_ns(times_ms: FloatArray, since_ns: int, until_ns: int) -> IntArray:
    """Return times, ms, in ns, of which those count that are after ``since`` and not after ``until``."""
    near = times_ms[(times_ms > milliseconds(since_ns) - 1.0) & (times_ms < milliseconds(until_ns) + 1.0)]
    changes = np.array([from_milliseconds(time) for time in near.tolist()], dtype=np.int64)
    return np.unique(changes[(changes > since_ns) & (changes <= until_ns)])


@lru_cache(maxsize=16)
def _grid_ns(interval_ms: float, start_ms: float, stop_ms: float, since_ns: int, until_ns: int) -> IntArray:
    """Return the multiples of an interval from ``start`` on, and ``stop``; many sources share them."""
    first = max(0, int((milliseconds(since_ns) - start_ms) / interval_ms))
    end_ms = min(milliseconds(until_ns), stop_ms)
    last = int((end_ms - start_ms) / interval_ms) + 2  # the quotient may be slightly too small
    times = np.minimum(start_ms + interval_ms * np.arange(first, max(first, last)), stop_ms)
    return _nearest_ns(np.append(times, stop_ms), since_ns, until_ns)


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

    def sampled_na(self, times_ms: FloatArray) -> FloatArray:
        """Return the current at ascending times."""
        changed_ms = np.concatenate(self._times) / NS_PER_MS
        return np.concatenate(self._amplitudes)[np.searchsorted(changed_ms, times_ms, side="right")]


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
