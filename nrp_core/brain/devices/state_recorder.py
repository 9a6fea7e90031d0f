"""Devices that record state variables of neurons, such as voltages and conductances."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, inf, isfinite
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.sinks import SinkPort, SinkSpec
from nrp_core.brain.spikes import Spikes

_ROUNDING = 1e-9
"""Tolerance for a time at a multiple of ``dt``, in samples."""


@dataclass(frozen=True, slots=True)
class StateRecorder(SinkSpec):
    """Samples of a state variable of each chosen neuron.

    Args:
        variable: its name, e.g. ``v`` (mV), ``gsyn_exc`` or ``gsyn_inh`` (uS).
        dt: ms between two samples, which lie at multiples of it, or at the brain's next grid point; the
            first sample is taken when the recorder is added.
        keep_ms: how long samples are kept, ms; by default forever.
    """

    variable: str = "v"
    dt: float = 1.0
    keep_ms: float = inf

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

    def next_sample_ms(self, now_ms: float) -> float:
        """Return the time of the next sample after ``now_ms``."""
        return (self._number(now_ms) + 1) * self._spec.dt

    def is_due(self, since_ms: float, now_ms: float) -> bool:
        """Return whether a sample is due at ``now_ms``, after those up to ``since_ms``."""
        return self._number(now_ms) > self._number(since_ms)

    def _number(self, t_ms: float) -> int:
        return floor(t_ms / self._spec.dt + _ROUNDING)

    def take(self, now_ms: float, values: FloatArray) -> None:
        """Store a sample, one value for each neuron, if the recorder is active."""
        if self.active:
            self._samples.append((now_ms, values))

    def samples(self, since_ms: float = -inf, until_ms: float = inf) -> tuple[FloatArray, FloatArray]:
        """Return times (ms) with ``since < t <= until``, shape ``(n,)``, and values, ``(n, n_neurons)``."""
        chosen = [sample for sample in self._samples if since_ms < sample[0] <= until_ms]
        times = np.array([time for time, _ in chosen])
        return times, np.array([values for _, values in chosen]).reshape(len(chosen), len(self.neurons))

    def _absorb(self, spikes: Spikes, until_ms: float) -> None:
        while self._samples and self._samples[0][0] <= until_ms - self._spec.keep_ms:
            self._samples.pop(0)

    def reset(self) -> None:
        self._samples: list[tuple[float, FloatArray]] = []

    def save(self) -> object:
        return self.active, list(self._samples)

    def restore(self, saved: Any) -> None:
        self.active, samples = saved
        self._samples = list(samples)
