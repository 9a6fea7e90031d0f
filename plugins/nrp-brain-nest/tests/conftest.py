"""Networks written in PyNN, and the activity of their neurons on a backend."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from nrp_core import brains
from nrp_core.brain import Brain, FloatArray, Network, SpikeRecorder, builder, network_of
from nrp_core.clock import NS_PER_MS

pytest_plugins = ["cases", "golden"]  # in tests/shared


@pytest.fixture
def network() -> Callable[[Callable[[Any], object]], Network]:
    """Make the network that a function builds with a PyNN simulator."""

    def make(build: Callable[[Any], object]) -> Network:
        sim = builder(1)
        sim.setup(timestep=0.1)
        build(sim)
        return network_of(sim.state, {})

    return make


@pytest.fixture
def opened() -> Iterator[Callable[..., Brain]]:
    """Open a network on a backend, by default NEST; closed at the end of the test."""
    brains_open: list[Brain] = []

    def open_(network: Network, backend: str = "nest", **options: Any) -> Brain:
        found = brains().load(backend)
        brain = found.open(network, seed=1, options=found.options(**options))
        brains_open.append(brain)
        return brain

    yield open_
    for brain in brains_open:
        brain.close()


@pytest.fixture
def spike_times(opened: Callable[..., Brain]) -> Callable[..., FloatArray]:
    """Return the spike times (ms) of one neuron in a run of a network."""

    def run(network: Network, backend: str = "nest", ms: int = 200, neuron: int = 0, **options: Any) -> Any:
        brain = opened(network, backend, **options)
        recorder = brain.add_sink(SpikeRecorder(), [neuron], name="recorder")
        brain.run_until(ms * NS_PER_MS)
        brain.close()
        return recorder.spikes().times_ms

    return run


@pytest.fixture
def voltages(opened: Callable[..., Brain]) -> Callable[..., FloatArray]:
    """Return the voltage (mV) of one neuron at the end of each ms of a run."""

    def run(network: Network, backend: str = "nest", ms: int = 40, neuron: int = 0, **options: Any) -> Any:
        brain = opened(network, backend, **options)
        samples = []
        for t_ms in range(1, ms + 1):
            brain.run_until(t_ms * NS_PER_MS)
            samples.append(brain.read_state("v", [neuron])[0])
        brain.close()
        return np.array(samples)

    return run
