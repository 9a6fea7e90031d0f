"""Helpers for the tests of brains: open, run and record a brain, and its declared resolution."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import Any

import numpy as np

from nrp_core.brain.backend import BrainBackend
from nrp_core.brain.backends import brains
from nrp_core.brain.devices.sinks import SpikeRecorder, SpikeRecorderPort
from nrp_core.brain.interface import Brain, BrainCapabilities
from nrp_core.brain.network.data import Population, Projection
from nrp_core.clock import NS_PER_MS, milliseconds
from nrp_core.conformance.base import SimulatorTests
from nrp_core.conformance.brain.parts import Part, cells, connect, network, poisson, spikes
from nrp_core.conformance.brain.samples import SAMPLES, Sample
from nrp_core.conformance.guard import undeclared

EXACT_MS = 1e-3
"""The allowed time error of a brain without a time grid: the accuracy of the reference."""

Train = list[tuple[int, float]]


class BrainKit(SimulatorTests[BrainBackend, BrainCapabilities]):
    """Opens the brain under test."""

    @classmethod
    def make_backend(cls) -> BrainBackend:
        return brains().load(cls.backend_name)

    @property
    def tolerance_ms(self) -> float:
        """The allowed time shift of an event: one step of the declared grid."""
        return milliseconds(self.capabilities.resolution_ns or 0) or EXACT_MS

    def grid_ns(self, t_ms: float) -> int:
        """Return the first time at or after ``t_ms`` at which the brain can be stopped."""
        step_ns = self.capabilities.resolution_ns or 1
        return -(-round(t_ms * NS_PER_MS) // step_ns) * step_ns

    @cached_property
    def sample(self) -> Sample:
        """A sample cell that the backend supports."""
        declared = [sample for name, sample in SAMPLES.items() if name in self.capabilities.cells]
        return declared[0] if declared else undeclared("any standard cell")

    def cells(self, label: str, size: int = 1, **parameters: Any) -> Population:
        """Return cells at rest, of a type that the backend supports."""
        return cells(self.sample, label, size, **parameters)

    def open(self, *parts: Part, seed: int = 1) -> Brain:
        """Open a network; it is closed after the test."""
        return self.opened.enter_context(self.backend.open(network(*parts), seed=seed, options=self.chosen))

    def run(self, brain: Brain, until_ms: float) -> None:
        """Advance to the first possible time at or after ``until_ms``."""
        brain.run_until(self.grid_ns(until_ms))

    def inhibition(self, pre: str, post: str, weight: float, delay: float = 1.0) -> Projection:
        """Connect the first cells by an inhibitory synapse; ``weight`` is its absolute value."""
        signed = weight * self.sample.inhibitory_sign
        return connect(pre, post, signed, delay, receptor="inhibitory")

    def busy(self) -> tuple[Part, ...]:
        """Return a network with currents, noise, spike trains, delays and both receptors."""
        sample = self.sample
        drive = np.linspace(0.7, 1.2, 5) * sample.current_na
        back = connect(
            "b", "a", sample.strong * sample.inhibitory_sign, 2.0,
            receptor="inhibitory", pairs=[(0, 0), (1, 3), (3, 4)],
        )  # fmt: skip
        return (
            self.cells("a", 5, i_offset=drive),
            self.cells("b", 4),
            spikes("train", [3.0, 10.0, 17.25, 40.0, 61.0], [5.5, 21.0, 39.0]),
            poisson("noise", 3, 300.0),
            connect("a", "b", sample.strong, [1, 2, 3, 4, 7], pairs=[(i, i % 4) for i in range(5)]),
            connect("train", "b", sample.strong, [1, 12], pairs=[(0, 1), (1, 3)]),
            connect("noise", "a", sample.weak, 1.0, pairs=[(i, j) for i in range(3) for j in range(5)]),
            back,
        )


def record(brain: Brain, neurons: Iterable[int] | None = None, name: str = "recorder") -> SpikeRecorderPort:
    """Record spikes, by default of all neurons."""
    chosen = range(brain.network.size) if neurons is None else neurons
    port = brain.add_sink(SpikeRecorder(), list(chosen), name=name)
    assert isinstance(port, SpikeRecorderPort)
    return port


def train(port: SpikeRecorderPort, since_ms: float = float("-inf")) -> Train:
    """Return the spikes recorded after a time, as pairs of neuron and time in a canonical order."""
    found = port.spikes(since_ms)
    return sorted(zip(found.neurons.tolist(), found.times_ms.tolist(), strict=True))


def times(port: SpikeRecorderPort, neuron: int) -> list[float]:
    """Return the times (ms) of one neuron's spikes."""
    return [time for ident, time in train(port) if ident == neuron]
