"""Devices that drive neurons. The core draws their spikes, so that every backend gets the same spikes.

Names, units and defaults are those of the Neurorobotics Platform and PyNN (ms, Hz, nA, uS).
A source acts on its neurons from outside; it is not part of the network and does not change it.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.brain.devices.ports import (
    NO_EVENTS,
    Setting,
    SourcePort,
    SourceSpec,
    Value,
    check_sign,
    check_synapse,
)
from nrp_core.brain.devices.trains import (
    FixedFrequencyPort,
    FixedFrequencySource,
    PoissonPort,
    PoissonSource,
    SpikeSourceSpec,
    TrainPort,
)
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.clock import FOREVER_NS, from_milliseconds, nanoseconds, without_rounding_errors
from nrp_core.errors import NeuronSelectionError
from nrp_core.network.data import Network
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
        if not (isfinite(self.dt) and nanoseconds(self.dt) > 0):
            raise ValueError(f"dt must be at least 1 ns (1e-6 ms), not {self.dt} ms")


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
        self._start_ns, self._stop_ns = nanoseconds([spec.start, spec.stop]).tolist()
        self._set: dict[str, Setting] = {}
        for setting in self._settings():
            least = 0.0 if setting in _NEVER_NEGATIVE else -inf
            self._set[setting] = Setting(setting, len(neurons), least=least)
            self._set[setting].set(getattr(spec, setting))

    @classmethod
    def _settings(cls) -> list[str]:
        return [name for name in dir(cls) if isinstance(getattr(cls, name), _Tunable)]

    def current_na(self, now_ns: int) -> FloatArray:
        """Return the current into each neuron from ``now_ns`` on."""
        value = self._value(now_ns)
        on = self.active and self._start_ns <= now_ns < self._stop_ns
        return value if on else np.zeros(len(self.neurons))

    def next_change_ns(self, now_ns: int) -> int:
        """Return the next scheduled change of the current after ``now_ns``."""
        return min((end for end in (self._start_ns, self._stop_ns) if end > now_ns), default=FOREVER_NS)

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
    def _value(self, now_ns: int) -> FloatArray:
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

    def _value(self, now_ns: int) -> FloatArray:
        return self._set["amplitude"].each


class VaryingPort(CurrentPort):
    """A current with a value for each interval of its grid."""

    _spec: VaryingSpec

    def __init__(self, spec: VaryingSpec, neurons: IntArray, name: str) -> None:
        super().__init__(spec, neurons, name)
        self._interval_ns = from_milliseconds(spec.dt)

    def next_change_ns(self, now_ns: int) -> int:
        next_value_ns = (self._cell(now_ns) + 1) * self._interval_ns
        return min(next_value_ns, super().next_change_ns(now_ns))

    def _cell(self, now_ns: int) -> int:
        """Return the grid interval of a time; a boundary belongs to the next interval."""
        return now_ns // self._interval_ns


class ACPort(VaryingPort):
    """An active :class:`ACSource`; each interval of the grid has the value at its middle."""

    quantity, unit = "amplitude", "nA"
    amplitude = _Tunable("Amplitude, nA.")
    offset = _Tunable("Mean current, nA.")
    frequency = _Tunable("Frequency, Hz.")
    phase = _Tunable("Phase at the start, degrees.")

    def _value(self, now_ns: int) -> FloatArray:
        amplitude, offset, frequency, phase = (
            self._set[name].each for name in ("amplitude", "offset", "frequency", "phase")
        )
        since_s = ((self._cell(now_ns) + 0.5) * self._spec.dt - self._spec.start) * 1e-3
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

    def _value(self, now_ns: int) -> FloatArray:
        while self._drawn < self._cell(now_ns):
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


@dataclass(frozen=True, slots=True)
class SpikeInjector(SourceSpec):
    """Spikes into neurons, one by one.

    Args:
        weight: weight in PyNN's units for the target's cell type.
        delay: ms from injection to arrival.
        receptor_type: ``excitatory``, or ``inhibitory``, to which current-based cells take negative weights.
    """

    weight: float = 2.0
    delay: float = 1.0
    receptor_type: str = "excitatory"

    def __post_init__(self) -> None:
        check_synapse(self.weight, self.delay, self.receptor_type)

    def open(self, neurons: IntArray, seeds: Seeds, name: str) -> SpikeInjectorPort:
        return SpikeInjectorPort(self, neurons, name)


class SpikeInjectorPort(SourcePort):
    """An active :class:`SpikeInjector`; its spikes are discarded while ``active`` is False."""

    def __init__(self, spec: SpikeInjector, neurons: IntArray, name: str) -> None:
        super().__init__(neurons, name)
        self._spec = spec
        self._now_ms = 0.0
        self._places: IntArray = np.empty(0, np.int64)
        self._times_ms: FloatArray = np.empty(0)

    def start(self, now_ms: float, network: Network) -> None:
        check_sign(self._spec.weight, self._spec.receptor_type, self.neurons, network)
        self._now_ms = now_ms

    def inject_spikes(
        self, neuron_ids: npt.ArrayLike | None = None, times_ms: npt.ArrayLike | None = None
    ) -> None:
        """Send a spike to neurons, by default to all.

        Args:
            neuron_ids: indices into the neurons of this device, from 0.
            times_ms: spike times, ms: one for all or one for each neuron; by default the current time.

        Raises:
            NeuronSelectionError: a neuron does not exist.
            ValueError: a time lies in the past.
        """
        n = len(self.neurons)
        places = np.arange(n) if neuron_ids is None else np.atleast_1d(np.asarray(neuron_ids, dtype=np.int64))
        if places.size and not (places.min() >= 0 and places.max() < n):
            raise NeuronSelectionError(f"'{self.name}' drives neurons 0..{n - 1}, not {places.tolist()}")
        given = self._now_ms if times_ms is None else without_rounding_errors(times_ms)
        times = np.broadcast_to(given, places.shape)
        if not (np.isfinite(times).all() and (times >= self._now_ms).all()):
            raise ValueError(
                f"'{self.name}' cannot send a spike at {times.min():g} ms: it is {self._now_ms:g} ms"
            )
        if self.active:
            self._places = np.concatenate([self._places, places])
            self._times_ms = np.concatenate([self._times_ms, times])

    def events(self, since_ms: float, until_ms: float) -> SynapticEvents:
        self._now_ms = until_ms
        if not len(self._places):
            return NO_EVENTS
        due = self._times_ms <= until_ms
        times, places = self._times_ms[due] + self._spec.delay, self._places[due]
        self._times_ms, self._places = self._times_ms[~due], self._places[~due]
        order = np.argsort(times, kind="stable")
        weights = np.full(len(order), self._spec.weight)
        return SynapticEvents(self.neurons[places[order]], times[order], weights, self._spec.receptor_type)

    def reset(self, seeds: Seeds) -> None:
        self._now_ms = 0.0
        self._places, self._times_ms = np.empty(0, np.int64), np.empty(0)

    def save(self) -> object:
        return self.active, self._now_ms, self._places, self._times_ms

    def restore(self, saved: Any) -> None:
        self.active, self._now_ms, self._places, self._times_ms = saved


__all__ = [
    "ACPort",
    "ACSource",
    "DCPort",
    "DCSource",
    "FixedFrequencyPort",
    "FixedFrequencySource",
    "NoisyCurrentPort",
    "NoisyCurrentSource",
    "PoissonPort",
    "PoissonSource",
    "SourcePort",
    "SourceSpec",
    "SpikeInjector",
    "SpikeInjectorPort",
    "SpikeSourceSpec",
    "TrainPort",
]
