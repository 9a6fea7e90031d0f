"""Devices that drive neurons: the core draws their spikes, so that all backends get the same ones.

Names, units and defaults are those of the Neurorobotics Platform and PyNN (ms, Hz, nA, uS).
A source acts on its neurons from outside; it is not part of the network and leaves no trace in it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf, isfinite
from typing import Any

import numpy as np

from nrp_core.brain.network import FloatArray, IntArray
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.errors import CapabilityError
from nrp_core.seeds import Seeds

Value = float | Sequence[float] | FloatArray

_BLOCK = 256
_NONE = SynapticEvents(np.empty(0, np.int64), np.empty(0), np.empty(0))


def checked_values(what: str, value: Value, size: int, *, least: float = -inf) -> FloatArray:
    """Return ``value`` as ``size`` floats.

    Raises:
        ValueError: a value is not finite or below ``least``, or the number of values is another.
    """
    array = np.asarray(value, dtype=float)
    if array.ndim and array.shape != (size,):
        raise ValueError(f"{what} takes one value or {size}, not {array.size}")
    if not (np.isfinite(array) & (array >= least)).all():
        limit = "" if least == -inf else f" and at least {least:g}"
        raise ValueError(f"{what} must be finite{limit}, not {value}")
    return np.broadcast_to(array, (size,)).astype(float)


@dataclass(frozen=True, slots=True)
class SourceSpec(ABC):
    """What a source is; :meth:`open` makes it work on neurons."""

    @abstractmethod
    def open(self, neurons: IntArray, seeds: Seeds, name: str) -> SourcePort:
        """Return the source at work on ``neurons`` (global ids)."""


class SourcePort(ABC):
    """A source at work. ``active = False`` silences it and keeps its settings."""

    def __init__(self, neurons: IntArray, name: str) -> None:
        self.neurons = neurons
        self.name = name
        self.active = True

    def events(self, since_ms: float, until_ms: float) -> SynapticEvents:
        """Return what was emitted with ``since_ms < t <= until_ms``, by time of arrival."""
        return _NONE

    def current_na(self, now_ms: float) -> FloatArray | None:
        """Return the current into each neuron from ``now_ms`` on, or None where there is none."""
        return None

    @abstractmethod
    def reset(self, seeds: Seeds) -> None:
        """Start anew at time 0 with new streams; settings go back to the specification."""

    @abstractmethod
    def save(self) -> object:
        """Return everything that changes while running."""

    @abstractmethod
    def restore(self, saved: Any) -> None:
        """Return to what :meth:`save` gave."""


@dataclass(frozen=True, slots=True)
class SpikeSourceSpec(SourceSpec):
    """What spiking sources share.

    Args:
        rate: spikes a second and neuron.
        weight: PyNN's meaning for the target's cell type.
        delay: ms from emission to arrival.
        receptor_type: ``excitatory`` or ``inhibitory``.
        start, duration: ms; silent outside.
        n: number of independent generators on each neuron.
    """

    rate: float = 0.0
    weight: float = 0.00015
    delay: float = 0.1
    receptor_type: str = "excitatory"
    start: float = 0.0
    duration: float = inf
    n: int = 1

    def __post_init__(self) -> None:
        if not isfinite(self.weight):
            raise ValueError(f"weight must be finite, not {self.weight}")
        if not self.delay >= 0 or not isfinite(self.delay):
            raise ValueError(f"delay must be 0 ms or more, not {self.delay}")
        if self.n < 1:
            raise ValueError(f"n must be 1 or more, not {self.n}")
        if self.receptor_type not in ("excitatory", "inhibitory"):
            raise ValueError(f"receptor_type is excitatory or inhibitory, not '{self.receptor_type}'")


@dataclass(frozen=True, slots=True)
class PoissonSource(SpikeSourceSpec):
    """An independent Poisson train into each neuron."""

    def open(self, neurons: IntArray, seeds: Seeds, name: str) -> PoissonPort:
        return PoissonPort(self, neurons, seeds, name)


@dataclass(frozen=True, slots=True)
class FixedFrequencySource(SpikeSourceSpec):
    """Equidistant spikes, the first one period after the rate became positive."""

    def open(self, neurons: IntArray, seeds: Seeds, name: str) -> FixedFrequencyPort:
        return FixedFrequencyPort(self, neurons, seeds, name)


@dataclass(frozen=True, slots=True)
class DCSource(SourceSpec):
    """A constant current into each neuron.

    Args:
        amplitude: nA.
    """

    amplitude: float = 0.0

    def open(self, neurons: IntArray, seeds: Seeds, name: str) -> DCPort:
        return DCPort(self, neurons, name)


class _RatePort(SourcePort):
    """Spike trains whose operational time runs at the rate.

    In operational time (the integral of the total rate) the train is fixed: arrivals ``u_k`` drawn in
    order from one stream. A rate change only moves the anchor between real and operational time, so
    a train depends neither on how a run is split nor on writes that change nothing.
    """

    def __init__(self, spec: SpikeSourceSpec, neurons: IntArray, seeds: Seeds, name: str) -> None:
        super().__init__(neurons, name)
        self._spec = spec
        self.reset(seeds)

    def reset(self, seeds: Seeds) -> None:
        self._rates = checked_values("rate", self._spec.rate, len(self.neurons), least=0.0)
        self._now_ms = 0.0
        self._anchor_ms = self._anchor_u = 0.0
        self._anchored_rate = 0.0
        self._reset_train(seeds)

    @property
    def rate(self) -> float | FloatArray:
        """Spikes a second, one number where all neurons have the same."""
        same = len(self._rates) > 0 and bool((self._rates == self._rates[0]).all())
        return float(self._rates[0]) if same else self._rates.copy()

    @rate.setter
    def rate(self, value: Value) -> None:
        self._rates = checked_values("rate", value, len(self.neurons), least=0.0)
        self._rates_changed()

    def events(self, since_ms: float, until_ms: float) -> SynapticEvents:
        start, stop = self._spec.start, self._spec.start + self._spec.duration
        cuts = [since_ms, *(cut for cut in (start, stop) if since_ms < cut < until_ms), until_ms]
        parts = [self._segment(a, b, start <= a < stop) for a, b in pairwise(cuts)]
        self._now_ms = until_ms
        times = np.concatenate([part[0] for part in parts])
        neurons = np.concatenate([part[1] for part in parts])
        weights = np.full(len(times), self._spec.weight)
        return SynapticEvents(neurons, times + self._spec.delay, weights, self._spec.receptor_type)

    def _segment(self, since_ms: float, until_ms: float, on: bool) -> tuple[FloatArray, IntArray]:
        rate = self._operational_rate() if on and self.active else 0.0
        if rate != self._anchored_rate:
            self._anchor_u += self._anchored_rate * (since_ms - self._anchor_ms) * 1e-3
            self._anchor_ms, self._anchored_rate = since_ms, rate
        if rate == 0.0:
            return np.empty(0), np.empty(0, np.int64)
        return self._take(until_ms)

    def _real_ms(self, u: FloatArray) -> FloatArray:
        """Real time of operational times under the rate in force."""
        return self._anchor_ms + (u - self._anchor_u) * (1e3 / self._anchored_rate)

    def save(self) -> object:
        anchors = (self._now_ms, self._anchor_ms, self._anchor_u, self._anchored_rate)
        return self._rates.copy(), self.active, anchors, self._save_train()

    def restore(self, saved: Any) -> None:
        rates, self.active, anchors, train = saved
        self._rates = rates.copy()
        self._now_ms, self._anchor_ms, self._anchor_u, self._anchored_rate = anchors
        self._restore_train(train)

    @abstractmethod
    def _operational_rate(self) -> float: ...

    @abstractmethod
    def _rates_changed(self) -> None: ...

    @abstractmethod
    def _reset_train(self, seeds: Seeds) -> None: ...

    @abstractmethod
    def _take(self, until_ms: float) -> tuple[FloatArray, IntArray]: ...

    @abstractmethod
    def _save_train(self) -> object: ...

    @abstractmethod
    def _restore_train(self, saved: Any) -> None: ...


class PoissonPort(_RatePort):
    """A :class:`PoissonSource` at work: the superposition of all trains, split by independent draws."""

    def _operational_rate(self) -> float:
        return float(self._rates.sum()) * self._spec.n

    def _rates_changed(self) -> None:
        total = self._rates.sum()
        self._shares = np.cumsum(self._rates) / total if total > 0 else np.ones(len(self._rates))

    def _reset_train(self, seeds: Seeds) -> None:
        self._rng = seeds.stream(self.name)
        self._u, self._v = np.empty(0), np.empty(0)
        self._last_u = 0.0
        self._rates_changed()

    def _take(self, until_ms: float) -> tuple[FloatArray, IntArray]:
        while not len(self._u) or self._real_ms(self._u[-1:])[0] <= until_ms:
            self._draw()
        times = self._real_ms(self._u)
        n = int(np.searchsorted(times, until_ms, side="right"))
        targets = np.searchsorted(self._shares, self._v[:n], side="right")
        self._u, self._v = self._u[n:], self._v[n:]
        return times[:n], self.neurons[np.minimum(targets, len(self.neurons) - 1)]

    def _draw(self) -> None:
        block = self._last_u + np.cumsum(self._rng.standard_exponential(_BLOCK))
        self._last_u = float(block[-1])
        self._u = np.concatenate([self._u, block])
        self._v = np.concatenate([self._v, self._rng.random(_BLOCK)])

    def _save_train(self) -> object:
        return self._rng.bit_generator.state, self._u.copy(), self._v.copy(), self._last_u

    def _restore_train(self, saved: Any) -> None:
        state, u, v, self._last_u = saved
        self._rng.bit_generator.state = state
        self._u, self._v = u.copy(), v.copy()
        self._rates_changed()


class FixedFrequencyPort(_RatePort):
    """A :class:`FixedFrequencySource` at work; all neurons fire together, at one common rate."""

    def _operational_rate(self) -> float:
        return float(self._rates[0]) if len(self._rates) else 0.0

    def _rates_changed(self) -> None:
        if len(self._rates) and (self._rates != self._rates[0]).any():
            raise ValueError("a fixed-frequency source has one rate; use a device group for several")

    def _reset_train(self, seeds: Seeds) -> None:
        self._next = 1

    def _take(self, until_ms: float) -> tuple[FloatArray, IntArray]:
        elapsed = (until_ms - self._anchor_ms) * self._anchored_rate * 1e-3
        u = np.arange(self._next, int(self._anchor_u + elapsed) + 2, dtype=float)
        times = self._real_ms(u)
        n = int(np.searchsorted(times, until_ms, side="right"))
        self._next += n
        repeats = self._spec.n * len(self.neurons)
        return np.repeat(times[:n], repeats), np.tile(np.repeat(self.neurons, self._spec.n), n)

    def _save_train(self) -> object:
        return self._next

    def _restore_train(self, saved: Any) -> None:
        self._next = saved


class DCPort(SourcePort):
    """A :class:`DCSource` at work."""

    def __init__(self, spec: DCSource, neurons: IntArray, name: str) -> None:
        super().__init__(neurons, name)
        self._spec = spec
        self.reset(Seeds(0))

    @property
    def amplitude(self) -> float | FloatArray:
        """Current into each neuron, nA."""
        same = len(self._amplitudes) > 0 and bool((self._amplitudes == self._amplitudes[0]).all())
        return float(self._amplitudes[0]) if same else self._amplitudes.copy()

    @amplitude.setter
    def amplitude(self, value: Value) -> None:
        self._amplitudes = checked_values("amplitude", value, len(self.neurons))

    def current_na(self, now_ms: float) -> FloatArray | None:
        return self._amplitudes if self.active else np.zeros_like(self._amplitudes)

    def reset(self, seeds: Seeds) -> None:
        self._amplitudes = checked_values("amplitude", self._spec.amplitude, len(self.neurons))

    def save(self) -> object:
        return self._amplitudes.copy(), self.active

    def restore(self, saved: Any) -> None:
        self._amplitudes, self.active = saved


class PopulationTrains:
    """The spikes that a source population of the network emits by its own parameters."""

    def __init__(
        self, cell_type: str, parameters: dict[str, FloatArray], trains: tuple[FloatArray, ...],
        neurons: IntArray, seeds: Seeds, name: str,
    ) -> None:  # fmt: skip
        self._neurons = neurons
        self._ports: list[PoissonPort] = []
        self._array_ids = np.empty(0, np.int64)
        self._array_ms = np.empty(0)
        if cell_type == "SpikeSourceArray":
            ids = np.repeat(neurons, [len(train) for train in trains])
            times = np.concatenate([np.empty(0), *trains])
            order = np.lexsort((ids, times))
            self._array_ids, self._array_ms = ids[order], times[order]
        elif cell_type == "SpikeSourcePoisson":
            self._ports = _poisson_ports(parameters, neurons, seeds, name)
        else:
            raise CapabilityError(f"source cells of type {cell_type} are not known; use SpikeSourcePoisson")

    def emitted(self, since_ms: float, until_ms: float) -> tuple[IntArray, FloatArray]:
        """Return ids and times of the spikes with ``since_ms < t <= until_ms``; t = 0 counts as after 0."""
        first = int(np.searchsorted(self._array_ms, since_ms, side="left" if since_ms == 0.0 else "right"))
        last = int(np.searchsorted(self._array_ms, until_ms, side="right"))
        parts = [port.events(since_ms, until_ms) for port in self._ports]
        ids = np.concatenate([self._array_ids[first:last], *(part.neurons for part in parts)])
        times = np.concatenate([self._array_ms[first:last], *(part.times_ms for part in parts)])
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


def _poisson_ports(
    parameters: dict[str, FloatArray], neurons: IntArray, seeds: Seeds, name: str
) -> list[PoissonPort]:
    """Return one port for each distinct start and duration among the cells."""
    windows = np.stack([parameters["start"], parameters["duration"]], axis=1)
    ports: list[PoissonPort] = []
    for i, (start, duration) in enumerate(np.unique(windows, axis=0)):
        chosen = (windows == (start, duration)).all(axis=1)
        spec = PoissonSource(weight=1.0, delay=0.0, start=float(start), duration=float(duration))
        port = _FixedRatesPort(spec, neurons[chosen], parameters["rate"][chosen], seeds, f"{name}/{i}")
        ports.append(port)
    return ports


class _FixedRatesPort(PoissonPort):
    """Poisson trains with the rates of a population, which a reset keeps."""

    def __init__(
        self, spec: PoissonSource, neurons: IntArray, rates: FloatArray, seeds: Seeds, name: str
    ) -> None:
        self._initial_rates = rates
        super().__init__(spec, neurons, seeds, name)

    def reset(self, seeds: Seeds) -> None:
        super().reset(seeds)
        self.rate = self._initial_rates
