"""How PyNN's current sources change with time."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, sin
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.sources import DCSource
from nrp_core.brain.interface import Brain
from nrp_core.clock import from_milliseconds, milliseconds

_SIZES: Final = {"amplitude", "amplitudes", "mean", "offset"}
_ROUNDING: Final = 1e-6
_LARGEST_NA: Final = 50.0
"""As high as the constant current of cells."""


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
        """Return the times at which the current changes, ``since < t <= until``."""
        if self._kind == "StepCurrentSource":
            times = self._source.times
        elif self._kind == "DCSource":
            times = np.array([self._source.start, self._source.stop])
        else:
            times = self._grid_ms(milliseconds(since_ns), milliseconds(until_ns))
        times = times[times < milliseconds(until_ns) + 1.0]  # sources may end at infinity
        changes = np.array([from_milliseconds(time) for time in times.tolist()], dtype=np.int64)
        return np.unique(changes[(changes > since_ns) & (changes <= until_ns)])

    def amplitude_na(self, t_ns: int) -> float:
        """Return the current from ``t_ns`` on, nA."""
        t_ms = milliseconds(t_ns)
        if self._kind == "StepCurrentSource":
            step = int(np.searchsorted(self._source.times, t_ms, side="right")) - 1
            return float(self._source.amplitudes[step]) if step >= 0 else 0.0
        if not self._source.start <= t_ms < self._source.stop:
            return 0.0
        if self._kind == "NoisyCurrentSource":
            return self._noisy(round((t_ms - self._source.start) / self._interval_ms))
        return self._sinusoidal(t_ms) if self._kind == "ACSource" else float(self._source.amplitude)

    @property
    def _interval_ms(self) -> float:
        noisy = self._kind == "NoisyCurrentSource"
        return max(float(self._source.dt), self._dt_ms) if noisy else self._dt_ms

    def _grid_ms(self, since_ms: float, until_ms: float) -> FloatArray:
        interval, start, stop = self._interval_ms, self._source.start, self._source.stop
        first = max(0, int((since_ms - start) / interval))
        last = int((min(until_ms, stop) - start) / interval) + 2  # the quotient may be slightly too small
        return np.append(np.minimum(start + interval * np.arange(first, max(first, last)), stop), stop)

    def _sinusoidal(self, t_ms: float) -> float:
        source = self._source
        cycles = source.frequency * (t_ms - source.start) * 1e-3 + source.phase / 360.0
        return float(source.offset + source.amplitude * sin(2 * pi * cycles))

    def _noisy(self, k: int) -> float:
        while k >= len(self._drawn):
            self._drawn = np.append(self._drawn, self._noise.standard_normal(256))
        return float(self._source.mean + self._source.stdev * self._drawn[k])


class Current:
    """A current source at work on cells.

    Args:
        source: one of PyNN's current sources.
        waveform: its waveform.
        cells: global ids.
        name: name of its device.
        since_ms: the time at which it was injected.
    """

    def __init__(
        self, source: Any, waveform: Waveform, cells: IntArray, name: str, since_ms: float = 0.0
    ) -> None:
        self.source, self.waveform, self.since_ms = source, waveform, since_ms
        self._cells, self._name = cells, name
        self._has_acted = False

    @property
    def is_idle(self) -> bool:
        """Whether it never drove its cells although it has an amplitude."""
        return not self._has_acted and _largest_na(self.source) > 0.0

    def described(self) -> str:
        """Return its kind and times."""
        source = self.source
        if "times" in source.default_parameters:
            return f"a {type(source).__name__} from {source.times[0]:g} ms"
        return f"a {type(source).__name__} from {source.start:g} to {source.stop:g} ms"

    def start(self, brain: Brain) -> None:
        """Connect to the cells of a brain that was just opened."""
        self._port: Any = brain.add_source(DCSource(), self._cells, name=self._name)
        self.restart()

    def restart(self) -> None:
        """Start again at time 0."""
        self._changes: list[tuple[int, float]] = []

    def update(self, now_ns: int) -> None:
        """Set the current for the time from now on."""
        amplitude = self.waveform.amplitude_na(now_ns)
        since_ns, acting = self._changes[-1] if self._changes else (now_ns, 0.0)
        self._has_acted |= bool(acting) and now_ns > since_ns
        if not self._changes or amplitude != self._changes[-1][1]:
            self._port.amplitude = amplitude
            self._changes.append((now_ns, amplitude))

    def sampled_na(self, times_ms: FloatArray) -> FloatArray:
        """Return the current at ascending times."""
        changed_ms = [milliseconds(t_ns) for t_ns, _ in self._changes]
        amplitudes = np.array([0.0, *(amplitude for _, amplitude in self._changes)])
        return amplitudes[np.searchsorted(changed_ms, times_ms, side="right")]


def _sizes_na(source: Any) -> Iterator[tuple[str, float]]:
    """Yield the largest magnitude of each current among a source's parameters."""
    for name in sorted(_SIZES & source.default_parameters.keys()):
        values = getattr(source, name)
        yield name, float(np.abs(getattr(values, "value", values)).max(initial=0.0))


def _largest_na(source: Any) -> float:
    noise = float(source.stdev) if "stdev" in source.default_parameters else 0.0
    return max(noise, *(largest for _, largest in _sizes_na(source)))
