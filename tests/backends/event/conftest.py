"""Brains of the event backend."""

from collections.abc import Callable

import numpy as np
import pytest
from nrp_brain_event import EventBackend, EventOptions

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.interface import Brain
from nrp_core.brain.spikes import Spikes
from nrp_core.clock import from_milliseconds
from nrp_core.network.data import Network, Population, Projection


@pytest.fixture
def open_brain() -> Callable[..., Brain]:
    """Open a network of populations and projections."""

    def make(*parts: Population | Projection, seed: int = 1, **options: object) -> Brain:
        populations = {part.label: part for part in parts if isinstance(part, Population)}
        projections = tuple(part for part in parts if isinstance(part, Projection))
        chosen = EventOptions.model_validate(options)
        return EventBackend().open(Network(populations, projections), seed=seed, options=chosen)

    return make


@pytest.fixture
def spikes_of() -> Callable[..., Spikes]:
    """Run a brain to a time (ms) and return all spikes from now on."""

    def run(brain: Brain, until_ms: float) -> Spikes:
        recorder = brain.add_sink(SpikeRecorder(), np.arange(brain.network.size), name="all")
        brain.run_until(from_milliseconds(until_ms))
        return recorder.spikes()

    return run
