"""Spike trains drawn by the core: Poisson and equidistant, at rates that can change at any time.

In operational time (the integral of the rate) a train is fixed: its arrivals ``u_k`` come in order from
one stream. A change of the rate only moves the anchor between real and operational time, so a train
depends neither on how a run is split nor on writes that keep the value.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import inf, isnan
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core._support.checked_arguments import is_number
from nrp_core.brain.devices.ports import (
    NO_EVENTS,
    Setting,
    SourcePort,
    SourceSpec,
    Value,
    check_sign,
    check_synapse,
)
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.clock import from_milliseconds, milliseconds, nanoseconds
from nrp_core.network.data import Network
from nrp_core.network.parameters import MAX_RATE_HZ
from nrp_core.seeds import Seeds

if TYPE_CHECKING:
    from nrp_core.brain.devices.short_term import ShortTermSynapses

Time = TypeVar("Time", float, FloatArray)

_BLOCK: Final = 256
"""Arrivals drawn at a time."""


@dataclass(frozen=True, slots=True)
class SpikeSourceSpec(SourceSpec):
    """Base of spiking sources.

    Args:
        rate: firing rate, Hz: one number for all neurons, or one for each.
        weight: weight in PyNN's units for the target's cell type.
        delay: ms from emission to arrival.
        receptor_type: ``excitatory``, or ``inhibitory``, to which current-based cells take negative weights.
        start, duration: ms; the source is silent outside this interval.
        n: number of independent generators for each neuron.
        synapse_type: for short-term plasticity, see
            :class:`~nrp_core.brain.devices.short_term.ShortTermSynapses`.
    """

    rate: Value = 0.0
    weight: float = 0.00015
    delay: float = 0.1
    receptor_type: str = "excitatory"
    start: float = 0.0
    duration: float = inf
    n: int = 1
    synapse_type: Mapping[str, Any] | None = None

    def __post_init__(self) -> None:
        check_synapse(self.weight, self.delay, self.receptor_type)
        for name, time_ms in (("start", self.start), ("duration", self.duration)):
            if not is_number(time_ms) or isnan(time_ms):
                raise ValueError(f"{name} is a time in ms, not {time_ms!r:.60}")
        if self.n < 1:
            raise ValueError(f"n must be 1 or more, not {self.n}")
        if self.synapse_type is not None and self.n != 1:
            raise ValueError(
                f"a source with a synapse_type is one generator for each neuron, not n = {self.n}"
            )


@dataclass(frozen=True, slots=True)
class PoissonSource(SpikeSourceSpec):
    """An independent Poisson train into each neuron."""

    def open(self, neurons: IntArray, seeds: Seeds, name: str) -> PoissonPort:
        return PoissonPort(self, neurons, seeds, name)


@dataclass(frozen=True, slots=True)
class FixedFrequencySource(SpikeSourceSpec):
    """Equidistant spikes; the first comes one period after the rate becomes positive."""

    def open(self, neurons: IntArray, seeds: Seeds, name: str) -> FixedFrequencyPort:
        return FixedFrequencyPort(self, neurons, seeds, name)


class AskedRates:
    """The rates that were set since the start of a run.

    Attributes:
        least_hz, most_hz: the smallest and the largest of them.
        count, positive: how often rates were set, and how often one was more than 0.
    """

    __slots__ = ("count", "least_hz", "most_hz", "positive")

    def __init__(self) -> None:
        self.least_hz, self.most_hz, self.count, self.positive = inf, 0.0, 0, 0

    def add(self, least_hz: float, most_hz: float) -> None:
        """Count the smallest and the largest rate of one setting."""
        self.count += 1
        self.positive += most_hz > 0.0
        if least_hz < self.least_hz:
            self.least_hz = least_hz
        if most_hz > self.most_hz:
            self.most_hz = most_hz


class TrainPort(SourcePort):
    """Spike trains whose operational time advances at the rate.

    Attributes:
        asked: the rates that were set.
    """

    quantity, unit = "rate", "Hz"

    def __init__(self, spec: SpikeSourceSpec, neurons: IntArray, seeds: Seeds, name: str) -> None:
        super().__init__(neurons, name)
        self._spec = spec
        start_ns, duration_ns = nanoseconds([spec.start, spec.duration]).tolist()
        self._borders_ns = start_ns, start_ns + duration_ns
        self._is_endless = start_ns <= 0 and spec.duration == inf
        self._rates = Setting("rate", len(neurons), least=0.0, most=MAX_RATE_HZ / spec.n)
        self._weights = np.full(_BLOCK, spec.weight)
        self._synapses: ShortTermSynapses | None = None
        self.asked = AskedRates()
        self.reset(seeds)

    def start(self, now_ms: float, network: Network) -> None:
        check_sign(self._spec.weight, self._spec.receptor_type, self.neurons, network)
        if self._spec.synapse_type is None:
            return
        from nrp_core.brain.devices.short_term import (
            ShortTermSynapses,
        )  # imported here since it loads a compiler

        self._places = np.zeros(network.size, np.int64)
        self._places[self.neurons] = np.arange(len(self.neurons))
        taus = network.synaptic_times_ms(self.neurons, self._spec.receptor_type)
        self._synapses = ShortTermSynapses(self._spec.synapse_type, taus)

    def reset(self, seeds: Seeds) -> None:
        if self._synapses is not None:
            self._synapses.reset()
        self._anchor_ms = self._anchor_u = 0.0
        self._anchored_rate = 0.0
        self._reset_train(seeds)
        self.rate = self._spec.rate
        self.asked = AskedRates()

    @property
    def rate(self) -> float | FloatArray:
        """Firing rate, Hz; one number if all neurons have the same."""
        return self._rates.value

    @rate.setter
    def rate(self, value: Value) -> None:
        self._rates.set(value)
        self._rates_changed()
        common = self._rates.common
        if common is None:
            self.asked.add(float(self._rates.each.min()), float(self._rates.each.max()))
        else:
            self.asked.add(common, common)

    def events(self, since_ms: float, until_ms: float) -> SynapticEvents:
        times, neurons = self._between(since_ms, until_ms)
        n = len(times)
        if n == 0:
            return NO_EVENTS
        if n > len(self._weights):
            self._weights = np.full(2 * n, self._spec.weight)
        weights = self._weights[:n]
        if self._synapses is not None:
            weights = weights * self._synapses.released(self._places[neurons], times)
        return SynapticEvents(neurons, times + self._spec.delay, weights, self._spec.receptor_type)

    def _between(self, since_ms: float, until_ms: float) -> tuple[FloatArray, IntArray]:
        """Return times and neurons of the spikes in a window."""
        if self._is_endless:  # as usual
            return self._segment(since_ms, until_ms)
        since_ns, until_ns = from_milliseconds(since_ms), from_milliseconds(until_ms)
        cuts = [milliseconds(border_ns) for border_ns in self._borders_ns if since_ns < border_ns < until_ns]
        if not cuts:
            return self._segment(since_ms, until_ms)
        parts = [self._segment(a, b) for a, b in pairwise([since_ms, *cuts, until_ms])]
        times, neurons = zip(*parts, strict=True)
        return np.concatenate(times), np.concatenate(neurons)

    def _segment(self, since_ms: float, until_ms: float) -> tuple[FloatArray, IntArray]:
        """Return times and neurons of the spikes in an interval within which the rate is constant."""
        start_ns, stop_ns = self._borders_ns
        on = self.active and (self._is_endless or start_ns <= from_milliseconds(since_ms) < stop_ns)
        rate = self._operational_rate if on else 0.0
        if rate != self._anchored_rate:
            self._anchor_u += self._anchored_rate * (since_ms - self._anchor_ms) * 1e-3
            self._anchor_ms, self._anchored_rate = since_ms, rate
        if rate == 0.0:
            return NO_EVENTS.times_ms, NO_EVENTS.neurons
        return self._take(until_ms)

    def _operational(self, t_ms: float) -> float:
        """Operational time, to rounding, of a real time at the current rate."""
        return self._anchor_u + (t_ms - self._anchor_ms) * self._anchored_rate * 1e-3

    def _real_ms(self, u: Time) -> Time:
        """Real times of operational times at the current rate."""
        return self._anchor_ms + (u - self._anchor_u) * (1e3 / self._anchored_rate)

    def save(self) -> object:
        anchors = (self._anchor_ms, self._anchor_u, self._anchored_rate)
        synapses = None if self._synapses is None else self._synapses.save()
        return self._rates.value, self.active, anchors, self._save_train(), synapses

    def restore(self, saved: Any) -> None:
        self.rate, self.active, anchors, train, synapses = saved
        if self._synapses is not None:
            self._synapses.restore(synapses)
        self._anchor_ms, self._anchor_u, self._anchored_rate = anchors
        self._restore_train(train)

    _operational_rate: float
    """Rate of the whole train, Hz."""

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


class PoissonPort(TrainPort):
    """Poisson trains: one superposition of all; each arrival is assigned to a random neuron."""

    _chosen: IntArray | None
    """The neurons of the arrivals drawn so far, valid while the rates keep their ratios."""

    def __init__(self, spec: SpikeSourceSpec, neurons: IntArray, seeds: Seeds, name: str) -> None:
        self._equal_shares = self._shares = np.arange(1, len(neurons) + 1) / max(1, len(neurons))
        super().__init__(spec, neurons, seeds, name)

    def _rates_changed(self) -> None:
        if self._rates.common is not None:
            total = self._rates.common * len(self.neurons)
            self._share_out(self._equal_shares)
        else:
            total = float(self._rates.each.sum())
            self._share_out(np.cumsum(self._rates.each) / total)
        self._operational_rate = total * self._spec.n

    def _share_out(self, shares: FloatArray) -> None:
        """Assign each arrival to a neuron by the cumulative shares of the neurons."""
        if shares is not self._shares:
            self._shares, self._chosen = shares, None

    def _reset_train(self, seeds: Seeds) -> None:
        self._rng = seeds.stream(self.name)
        self._u, self._v = np.empty(0), np.empty(0)
        self._chosen = None
        self._next = 0
        self._last_u = 0.0

    def _take(self, until_ms: float) -> tuple[FloatArray, IntArray]:
        guess = self._operational(until_ms)
        if self._last_u <= guess + 1.0:
            self._draw_beyond(guess + 1.0)  # ensures that the last arrival is not due yet
        real_ms, u = self._real_ms, self._u
        first, last = self._next, int(u.searchsorted(guess, "right"))
        while real_ms(u.item(last)) <= until_ms:  # the estimate has rounding errors; the exact times decide
            last += 1
        while last > first and real_ms(u.item(last - 1)) > until_ms:
            last -= 1
        if first == last:
            return NO_EVENTS.times_ms, NO_EVENTS.neurons
        if self._chosen is None:
            self._chosen = self.neurons.take(self._assigned(self._v), mode="clip")
        self._next = last
        return real_ms(u[first:last]), self._chosen[first:last]

    def _assigned(self, v: FloatArray) -> IntArray:
        """Return the places of random shares among the cumulative shares of the neurons."""
        shares = self._shares
        if shares is not self._equal_shares:
            return shares.searchsorted(v, "right")
        found: IntArray = np.minimum((v * len(shares)).astype(np.int64), len(shares) - 1)
        found += shares[found] <= v  # the product has rounding errors; the shares decide
        found -= (found > 0) & (shares[found - 1] > v)
        return found

    def _draw_beyond(self, u: float) -> None:
        times, shares = [self._u[self._next :]], [self._v[self._next :]]
        while self._last_u <= u:
            times.append(self._last_u + self._rng.standard_exponential(_BLOCK).cumsum())
            shares.append(self._rng.random(_BLOCK))
            self._last_u = float(times[-1][-1])
        self._u, self._v = np.concatenate(times), np.concatenate(shares)
        self._chosen = None
        self._next = 0

    def _save_train(self) -> object:
        rest = slice(self._next, None)
        return self._rng.bit_generator.state, self._u[rest].copy(), self._v[rest].copy(), self._last_u

    def _restore_train(self, saved: Any) -> None:
        self._rng.bit_generator.state, self._u, self._v, self._last_u = saved
        self._chosen = None
        self._next = 0


class FixedFrequencyPort(TrainPort):
    """Equidistant spikes; all neurons fire together, at one common rate."""

    def _rates_changed(self) -> None:
        if self._rates.common is None:
            raise ValueError("a fixed-frequency source has one rate; use a device group for several")
        self._operational_rate = self._rates.common

    def _reset_train(self, seeds: Seeds) -> None:
        self._next = 1

    def _take(self, until_ms: float) -> tuple[FloatArray, IntArray]:
        u = np.arange(self._next, int(self._operational(until_ms)) + 2, dtype=float)
        times = self._real_ms(u)
        n = int(times.searchsorted(until_ms, "right"))
        self._next += n
        repeats = self._spec.n * len(self.neurons)
        return times[:n].repeat(repeats), np.tile(self.neurons.repeat(self._spec.n), n)

    def _save_train(self) -> object:
        return self._next

    def _restore_train(self, saved: Any) -> None:
        self._next = saved
