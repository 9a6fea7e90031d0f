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
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray, address
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
from nrp_core.brain.devices.records import ANCHORS, TRAIN
from nrp_core.brain.spikes import SynapticEvents
from nrp_core.clock import from_milliseconds, milliseconds, nanoseconds
from nrp_core.network.data import Network
from nrp_core.network.parameters import MAX_RATE_HZ
from nrp_core.seeds import Seeds

if TYPE_CHECKING:
    from nrp_core.brain.devices.short_term import ShortTermSynapses

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
        self.train = np.zeros(1, TRAIN)
        self.place = address(self.train)
        super().__init__(neurons, name)
        self._spec = spec
        start_ns, duration_ns = nanoseconds([spec.start, spec.duration]).tolist()
        self._borders_ns = start_ns, start_ns + duration_ns
        self.is_endless = start_ns <= 0 and spec.duration == inf
        self._rates = Setting("rate", len(neurons), least=0.0, most=MAX_RATE_HZ / spec.n)
        self.synapses: ShortTermSynapses | None = None
        self.asked = AskedRates()
        self.train["weight"], self.train["delay_ms"] = spec.weight, spec.delay
        self.train["inhibitory"] = spec.receptor_type == "inhibitory"
        self._neurons = np.ascontiguousarray(neurons)  # the train has its address
        self.train["neurons"], self.train["n_neurons"] = address(self._neurons), len(neurons)
        self.reset(seeds)

    @property
    def active(self) -> bool:
        """Whether it emits spikes."""
        return bool(self.train["active"][0])

    @active.setter
    def active(self, active: bool) -> None:
        self.train["active"] = active

    def start(self, now_ms: float, network: Network) -> None:
        check_sign(self._spec.weight, self._spec.receptor_type, self.neurons, network)
        if self._spec.synapse_type is None:
            return
        # imported here since it loads a compiler
        from nrp_core.brain.devices.short_term import ShortTermSynapses

        self._places = np.zeros(network.size, np.int64)
        self._places[self.neurons] = np.arange(len(self.neurons))
        taus = network.synaptic_times_ms(self.neurons, self._spec.receptor_type)
        self.synapses = ShortTermSynapses(self._spec.synapse_type, taus)

    def reset(self, seeds: Seeds) -> None:
        if self.synapses is not None:
            self.synapses.reset()
        for name in ANCHORS:
            self.train[name] = 0.0
        self._reset_train(seeds)
        self.rate = self._spec.rate
        self.asked = AskedRates()

    @property
    def rate(self) -> float | FloatArray:
        """Firing rate, Hz; one number if all neurons have the same."""
        return self._rates.value

    @rate.setter
    def rate(self, value: Value) -> None:
        if type(value) is float and value == self._rates.common:  # as functions set it in most steps
            self.asked.add(value, value)
            return
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
        weights = np.full(n, self._spec.weight)
        if self.synapses is not None:
            weights *= self.synapses.released(self._places[neurons], times)
        return SynapticEvents(neurons, times + self._spec.delay, weights, self._spec.receptor_type)

    def _between(self, since_ms: float, until_ms: float) -> tuple[FloatArray, IntArray]:
        """Return times and neurons of the spikes in a window."""
        if self.is_endless:  # as usual
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
        on = self.is_endless or start_ns <= from_milliseconds(since_ms) < stop_ns
        n = self.due(since_ms, until_ms, on)
        if not n:
            return NO_EVENTS.times_ms, NO_EVENTS.neurons
        times_ms, neurons = np.empty(n), np.empty(n, np.int64)
        self._kernel().take(self.place, times_ms, neurons)
        return times_ms, neurons

    def due(self, since_ms: float, until_ms: float, on: bool = True) -> int:
        """Return the number of spikes in an interval within which the rate is constant."""
        n: int
        while (n := self._kernel().due(self.place, since_ms, until_ms, on)) < 0:
            self.draw()
        return n

    def _kernel(self) -> Any:
        from nrp_core.brain.devices import train_kernel  # imported here since it loads a compiler

        return train_kernel

    def draw(self) -> None:
        """Draw the arrivals that the compiled code lacks."""

    def save(self) -> object:
        anchors = tuple(self.train[name].item() for name in ANCHORS)
        synapses = None if self.synapses is None else self.synapses.save()
        return self._rates.value, self.active, anchors, self._save_train(), synapses

    def restore(self, saved: Any) -> None:
        self.rate, self.active, anchors, train, synapses = saved
        if self.synapses is not None:
            self.synapses.restore(synapses)
        for name, value in zip(ANCHORS, anchors, strict=True):
            self.train[name] = value
        self._restore_train(train)

    @abstractmethod
    def _rates_changed(self) -> None: ...

    @abstractmethod
    def _reset_train(self, seeds: Seeds) -> None: ...

    @abstractmethod
    def _save_train(self) -> object: ...

    @abstractmethod
    def _restore_train(self, saved: Any) -> None: ...


class PoissonPort(TrainPort):
    """Poisson trains: one superposition of all; each arrival is assigned to a random neuron."""

    def _rates_changed(self) -> None:
        if self._rates.common is not None:
            total = self._rates.common * len(self.neurons)
            self.train["shares"] = 0
        else:
            total = float(self._rates.each.sum())
            self._shares = np.cumsum(self._rates.each) / total  # cumulative; the train has its address
            self.train["shares"] = address(self._shares)
        self.train["rate"] = total * self._spec.n

    def _reset_train(self, seeds: Seeds) -> None:
        self._rng = seeds.stream(self.name)
        self._set_arrivals(np.empty(0), np.empty(0), 0.0)

    def _set_arrivals(self, u: FloatArray, v: FloatArray, last_u: float) -> None:
        """Continue with operational times of arrivals, and the random numbers that choose their neurons."""
        self._u, self._v = np.ascontiguousarray(u), np.ascontiguousarray(v)
        self.train["u"], self.train["v"], self.train["n_drawn"] = address(self._u), address(self._v), len(u)
        self.train["last_u"], self.train["next"] = last_u, 0

    def draw(self) -> None:
        train = self.train[0]
        times, shares, last_u = [self._u[train["next"] :]], [self._v[train["next"] :]], train["last_u"].item()
        while last_u <= train["needed_u"]:
            times.append(last_u + self._rng.standard_exponential(_BLOCK).cumsum())
            shares.append(self._rng.random(_BLOCK))
            last_u = float(times[-1][-1])
        self._set_arrivals(np.concatenate(times), np.concatenate(shares), last_u)

    def _save_train(self) -> object:
        rest = slice(self.train["next"].item(), None)
        last_u = self.train["last_u"].item()
        return self._rng.bit_generator.state, self._u[rest].copy(), self._v[rest].copy(), last_u

    def _restore_train(self, saved: Any) -> None:
        self._rng.bit_generator.state, *arrivals = saved
        self._set_arrivals(*arrivals)


class FixedFrequencyPort(TrainPort):
    """Equidistant spikes; all neurons fire together, at one common rate."""

    def _rates_changed(self) -> None:
        if self._rates.common is None:
            raise ValueError("a fixed-frequency source has one rate; use a device group for several")
        self.train["rate"] = self._rates.common

    def _reset_train(self, seeds: Seeds) -> None:
        self.train["copies"], self.train["next"] = self._spec.n, 1

    def _save_train(self) -> object:
        return self.train["next"].item()

    def _restore_train(self, saved: Any) -> None:
        self.train["next"] = saved
