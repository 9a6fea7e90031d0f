"""Currents into neurons from outside: constant, sinusoidal, noisy.

A varying current is constant within each step ``dt`` of a grid from time 0, however a run is split.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from math import floor, inf, isfinite
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.ports import Setting, SourcePort, SourceSpec, Value
from nrp_core.seeds import Seeds


@dataclass(frozen=True, slots=True)
class CurrentSpec(SourceSpec):
    """Base of all currents.

    Args:
        start, stop: ms; the current is zero before ``start`` and from ``stop`` on.
    """

    start: float = 0.0
    stop: float = inf


@dataclass(frozen=True, slots=True)
class DCSource(CurrentSpec):
    """A constant current into each neuron.

    Args:
        amplitude: nA: one number, or one for each neuron.
    """

    amplitude: Value = 0.0

    def open(self, neurons: IntArray, seeds: Seeds, name: str) -> DCPort:
        return DCPort(self, neurons, name)


@dataclass(frozen=True, slots=True)
class VaryingSpec(CurrentSpec):
    """Base of varying currents.

    Args:
        dt: ms between two values.
    """

    dt: float = 1.0

    def __post_init__(self) -> None:
        if not (isfinite(self.dt) and self.dt > 0):
            raise ValueError(f"dt must be more than 0 ms, not {self.dt}")


@dataclass(frozen=True, slots=True)
class ACSource(VaryingSpec):
    """A sine, ``offset + amplitude * sin(2 pi frequency (t - start) + phase)``, as PyNN's.

    Args:
        amplitude, offset: nA.
        frequency: Hz.
        phase: degrees.
    """

    amplitude: Value = 0.0
    offset: Value = 0.0
    frequency: Value = 10.0
    phase: Value = 0.0

    def open(self, neurons: IntArray, seeds: Seeds, name: str) -> ACPort:
        return ACPort(self, neurons, name)


@dataclass(frozen=True, slots=True)
class NoisyCurrentSource(VaryingSpec):
    """Gaussian white noise: every ``dt`` each neuron gets a new value, independent of all other values.

    Args:
        mean, stdev: nA.
    """

    mean: Value = 0.0
    stdev: Value = 1.0

    def open(self, neurons: IntArray, seeds: Seeds, name: str) -> NoisyCurrentPort:
        return NoisyCurrentPort(self, neurons, seeds, name)


_NEVER_NEGATIVE = ("stdev", "frequency")


class CurrentPort(SourcePort):
    """An active current: its settings and its time window."""

    def __init__(self, spec: CurrentSpec, neurons: IntArray, name: str) -> None:
        super().__init__(neurons, name)
        self._spec = spec
        self._set: dict[str, Setting] = {}
        for setting in self._settings():
            least = 0.0 if setting in _NEVER_NEGATIVE else -inf
            self._set[setting] = Setting(setting, len(neurons), least=least)
            self._set[setting].set(getattr(spec, setting))

    @classmethod
    def _settings(cls) -> list[str]:
        return [name for name in dir(cls) if isinstance(getattr(cls, name), _Tunable)]

    def current_na(self, now_ms: float) -> FloatArray:
        """Return the current into each neuron from ``now_ms`` on."""
        value = self._value(now_ms)
        on = self.active and self._spec.start <= now_ms < self._spec.stop
        return value if on else np.zeros(len(self.neurons))

    def next_change_ms(self, now_ms: float) -> float:
        """Return the next time after ``now_ms`` at which the current changes by itself."""
        return min((border for border in (self._spec.start, self._spec.stop) if border > now_ms), default=inf)

    def reset(self, seeds: Seeds) -> None:
        for name, setting in self._set.items():
            setting.set(getattr(self._spec, name))

    def save(self) -> object:
        return {name: setting.value for name, setting in self._set.items()}, self.active

    def restore(self, saved: Any) -> None:
        values, self.active = saved
        for name, value in values.items():
            self._set[name].set(value)

    @abstractmethod
    def _value(self, now_ms: float) -> FloatArray:
        """Return the current into each neuron within the time window; called in the order of time."""


class _Tunable:
    """A setting of a current that can be changed while it is active."""

    def __init__(self, doc: str) -> None:
        self.__doc__ = doc

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, port: CurrentPort | None, owner: type) -> Any:
        return self if port is None else port._set[self._name].value

    def __set__(self, port: CurrentPort, value: Value) -> None:
        port._set[self._name].set(value)


class DCPort(CurrentPort):
    """An active :class:`DCSource`."""

    quantity, unit = "amplitude", "nA"
    amplitude = _Tunable("Current into each neuron, nA: one number where all have the same.")

    def _value(self, now_ms: float) -> FloatArray:
        return self._set["amplitude"].each


class VaryingPort(CurrentPort):
    """A current with a value for each interval of its grid."""

    _spec: VaryingSpec

    def next_change_ms(self, now_ms: float) -> float:
        next_value_ms = (self._cell(now_ms) + 1) * self._spec.dt
        return min(next_value_ms, super().next_change_ms(now_ms))

    def _cell(self, now_ms: float) -> int:
        """Return the grid interval of a time; a boundary, to rounding, belongs to the next interval."""
        return floor(now_ms / self._spec.dt + 1e-9)


class ACPort(VaryingPort):
    """An active :class:`ACSource`; each interval of the grid has the value at its middle."""

    quantity, unit = "amplitude", "nA"
    amplitude = _Tunable("Amplitude, nA.")
    offset = _Tunable("Mean current, nA.")
    frequency = _Tunable("Frequency, Hz.")
    phase = _Tunable("Phase at the start, degrees.")

    def _value(self, now_ms: float) -> FloatArray:
        amplitude, offset, frequency, phase = (
            self._set[name].each for name in ("amplitude", "offset", "frequency", "phase")
        )
        since_s = ((self._cell(now_ms) + 0.5) * self._spec.dt - self._spec.start) * 1e-3
        return offset + amplitude * np.sin(2 * np.pi * frequency * since_s + np.radians(phase))


class NoisyCurrentPort(VaryingPort):
    """An active :class:`NoisyCurrentSource`."""

    quantity, unit = "mean", "nA"
    mean = _Tunable("Mean current, nA.")
    stdev = _Tunable("Standard deviation, nA.")

    def __init__(self, spec: NoisyCurrentSource, neurons: IntArray, seeds: Seeds, name: str) -> None:
        super().__init__(spec, neurons, name)
        self._begin(seeds)

    def _begin(self, seeds: Seeds) -> None:
        self._rng = seeds.stream(self.name)
        self._drawn = -1
        self._noise = np.zeros(len(self.neurons))

    def _value(self, now_ms: float) -> FloatArray:
        while self._drawn < self._cell(now_ms):
            self._noise = self._rng.standard_normal(len(self.neurons))
            self._drawn += 1
        return self._set["mean"].each + self._set["stdev"].each * self._noise

    def reset(self, seeds: Seeds) -> None:
        super().reset(seeds)
        self._begin(seeds)

    def save(self) -> object:
        return super().save(), self._rng.bit_generator.state, self._drawn, self._noise

    def restore(self, saved: Any) -> None:
        settings, self._rng.bit_generator.state, self._drawn, self._noise = saved
        super().restore(settings)
