"""Devices that record state variables of neurons, such as voltages and conductances."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import floor, inf, isfinite, prod
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.sinks import SinkPort, SinkSpec
from nrp_core.brain.spikes import Spikes
from nrp_core.clock import NS_PER_MS, milliseconds

_ROUNDING = 1e-9
"""Tolerance for a time at a multiple of ``dt``, in samples."""


@dataclass(frozen=True, slots=True)
class StateRecorder(SinkSpec):
    """Samples of a state variable of each chosen neuron.

    Args:
        variable: its name, e.g. ``v`` (mV), ``gsyn_exc`` or ``gsyn_inh`` (uS).
        dt: ms between two samples, which lie at multiples of it after ``begin``, or at the brain's next grid
            point; the first sample is taken when the recorder is added.
        keep_ms: how long samples are kept, ms; by default forever.
        begin: ms; the time from which multiples are counted.
    """

    variable: str = "v"
    dt: float = 1.0
    keep_ms: float = inf
    begin: float = 0.0

    def __post_init__(self) -> None:
        if not (isfinite(self.dt) and self.dt > 0):
            raise ValueError(f"dt must be more than 0 ms, not {self.dt}")

    def open(self, neurons: IntArray, n_neurons: int, name: str) -> StateRecorderPort:
        return StateRecorderPort(self, neurons, n_neurons, name)


@dataclass(frozen=True, slots=True)
class VoltageRecorder(StateRecorder):
    """Membrane voltages, mV."""


@dataclass(frozen=True, slots=True)
class ConductanceRecorder(StateRecorder):
    """Conductances of the excitatory synapses, or with ``variable="gsyn_inh"`` of the inhibitory ones, uS."""

    variable: str = "gsyn_exc"


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """The samples that a recorder needs of a run.

    Args:
        variable: the state variable.
        neurons: global ids, shape ``(m,)``.
        times_ns: ascending times within the run, shape ``(n,)``.
    """

    variable: str
    neurons: IntArray
    times_ns: IntArray

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of the samples: one row a time."""
        return len(self.times_ns), len(self.neurons)

    def earlier(self, by_ns: int) -> Trace:
        """Return the same samples with times counted from ``by_ns``."""
        return replace(self, times_ns=self.times_ns - by_ns)


def divided(samples: FloatArray, traces: Sequence[Trace]) -> list[FloatArray]:
    """Return the samples of each trace, which lie one after another, as views of shape ``(n, m)``."""
    ends = np.cumsum([prod(trace.shape) for trace in traces])
    return [part.reshape(trace.shape) for part, trace in zip(np.split(samples, ends), traces, strict=False)]


def run_halting(
    t_ns: int,
    traces: Sequence[Trace],
    samples: FloatArray,
    run: Callable[[int], None],
    read: Callable[[str, IntArray], FloatArray],
) -> None:
    """Run to a time with a halt at each sample, which is read and stored."""
    values, row = divided(samples, traces), [0] * len(traces)
    for stop_ns in np.unique(np.concatenate([[t_ns], *(trace.times_ns for trace in traces)])).tolist():
        run(stop_ns)
        for k, trace in enumerate(traces):
            if row[k] < len(trace.times_ns) and trace.times_ns[row[k]] == stop_ns:
                values[k][row[k]] = read(trace.variable, trace.neurons)
                row[k] += 1


class StateRecorderPort(SinkPort):
    """A connected state recorder."""

    def __init__(self, spec: StateRecorder, neurons: IntArray, n_neurons: int, name: str) -> None:
        super().__init__(neurons, n_neurons, name)
        self._spec = spec
        self.reset()

    @property
    def variable(self) -> str:
        """The recorded variable."""
        return self._spec.variable

    def due(self, since_ns: int, until_ns: int, grid_ns: int) -> Trace:
        """Return the samples to be taken, ``since < t <= until``, each at a point of the brain's grid."""
        numbers = np.arange(self._number(since_ns) + 1, self._number(until_ns) + 1)
        exact_ns = np.rint((self._spec.begin + numbers * self._spec.dt) * NS_PER_MS).astype(np.int64)
        times_ns = np.minimum(-(-exact_ns // grid_ns) * grid_ns, until_ns)
        if len(times_ns) > 1:  # they ascend
            times_ns = times_ns[np.append(True, np.diff(times_ns) > 0)]
        return Trace(self.variable, self.neurons, times_ns)

    def _number(self, t_ns: int) -> int:
        return floor((milliseconds(t_ns) - self._spec.begin) / self._spec.dt + _ROUNDING)

    def take(self, times_ns: IntArray, values: FloatArray) -> None:
        """Store samples of each neuron, shape ``(n, n_neurons)``, if the recorder is active."""
        if self.active and len(times_ns):
            self._samples.append((times_ns / NS_PER_MS, values))

    def samples(self, since_ms: float = -inf, until_ms: float = inf) -> tuple[FloatArray, FloatArray]:
        """Return times (ms) with ``since < t <= until``, shape ``(n,)``, and values, ``(n, n_neurons)``."""
        times = np.concatenate([np.empty(0), *(times for times, _ in self._samples)])
        first, last = np.searchsorted(times, [since_ms, until_ms], side="right")
        kept = [values for _, values in self._samples] or [np.empty((0, len(self.neurons)))]
        values = kept[0] if len(kept) == 1 else np.concatenate(kept)
        return times[first:last], values[first:last]

    def parts(self) -> Iterator[tuple[FloatArray, FloatArray]]:
        """Yield all times (ms) and values in the pieces in which they were stored, without a copy."""
        yield from self._samples

    def _absorb(self, spikes: Spikes, until_ms: float) -> None:
        oldest_ms = until_ms - self._spec.keep_ms
        while self._samples and self._samples[0][0][0] <= oldest_ms:
            times, values = self._samples.pop(0)
            first = int(np.searchsorted(times, oldest_ms, side="right"))
            if first < len(times):
                self._samples.insert(0, (times[first:], values[first:].copy()))

    def reset(self) -> None:
        self._samples: list[tuple[FloatArray, FloatArray]] = []

    def save(self) -> object:
        return self.active, list(self._samples)

    def restore(self, saved: Any) -> None:
        self.active, samples = saved
        self._samples = list(samples)
