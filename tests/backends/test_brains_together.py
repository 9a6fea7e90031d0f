"""Brains that advance together have the spikes, devices and voltages that each has alone, bit for bit."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from nrp_core.brain.backends import brains
from nrp_core.brain.devices.sinks import LeakyIntegratorAlpha, PopulationRate, SpikeRecorder
from nrp_core.brain.devices.sources import DCSource, FixedFrequencySource, PoissonSource
from nrp_core.brain.interface import Brain
from nrp_core.brain.together import BrainBatch
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import LifecycleError
from nrp_core.experiment.running.observation import SpikeCounter
from nrp_core.network.data import Network, Population, Projection

STEP_NS, COPIES = 7 * NS_PER_MS, 3
ACTS = ("rate", "rates", "silence", "reset", "state", "current", "weights", "nothing")


@pytest.fixture(params=[("event", {}), ("event", {"resolution": "0.1 ms"}), ("spinnaker", {})], ids=str)
def opened(
    request: pytest.FixtureRequest, cells: Callable[..., Population], connect: Callable[..., Projection]
) -> Callable[[int], Brain]:
    name, options = request.param
    populations = {"a": cells("a", "IF_curr_exp", 4, i_offset=0.2), "b": cells("b", "IF_curr_exp", 2)}
    network = Network(populations, (connect("a", "b", 3.0, 1.0, pairs=[(0, 0), (1, 1), (3, 1)]),))

    def open_it(seed: int) -> Brain:
        backend = brains().load(name)
        return backend.open(network, seed=seed, options=backend.options.model_validate(options))

    return open_it


class Rig:
    """A brain with devices."""

    def __init__(self, brain: Brain) -> None:
        self.brain: Any = brain
        self.poisson: Any = brain.add_source(PoissonSource(rate=200.0, weight=2.0, n=2), [0, 1, 2], name="p")
        given = FixedFrequencySource(rate=90.0, weight=-3.0, receptor_type="inhibitory", delay=1.5)
        self.fixed: Any = brain.add_source(given, [3, 4], name="f")
        self.rate: Any = brain.add_sink(PopulationRate(), [0, 1, 1], name="r")
        self.leaky: Any = brain.add_sink(LeakyIntegratorAlpha(), [4, 5], name="l")
        self.counter: Any = brain.add_sink(SpikeCounter(), np.arange(6), name="c")
        self.all: Any = brain.add_sink(SpikeRecorder(), np.arange(6), name="s")

    def act(self, what: str, value: float) -> None:
        if what == "rate":
            self.poisson.rate = self.fixed.rate = value
        elif what == "rates":
            self.poisson.rate = [value, 0.0, 3 * value]
        elif what == "silence":
            self.poisson.active = self.rate.active = self.counter.active = not self.poisson.active
        elif what == "weights" and self.brain.identity.startswith("event"):
            self.brain.set_weights("a-b-excitatory", np.full(3, value))
        elif what == "reset":
            self.brain.reset(seed=int(value))
        elif what == "state":
            self.brain.reset("state")
        elif what == "current":
            self.brain.add_source(DCSource(amplitude=value / 100), [5], name=f"dc{value}")

    def seen(self) -> tuple[Any, ...]:
        spikes = self.all.spikes()
        return (
            spikes.neurons.tolist(),
            spikes.times_ms.tolist(),
            self.rate.rate,
            self.leaky.voltage,
            self.counter.activity(self.brain.network),
            self.brain.read_state("v", range(6)).tolist(),
        )


def test_equal_brains_have_equal_snapshots(opened: Callable[[int], Brain]) -> None:
    rigs = [Rig(opened(0)) for _ in range(2)]
    for rig in rigs:
        junk = np.full(1 << 16, -1)  # what memory that nobody sets would hold
        del junk
        rig.brain.run_until(40 * STEP_NS)
    one, other = (pickle.dumps(rig.brain.snapshot()) for rig in rigs)
    assert one == other


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.lists(
        st.tuples(st.integers(0, COPIES - 1), st.sampled_from(ACTS), st.sampled_from([0.0, 31.5, 400.0])),
        min_size=1, max_size=25,
    )
)  # fmt: skip
def test_each_does_what_it_does_alone(
    opened: Callable[[int], Brain], acts: list[tuple[int, str, float]]
) -> None:
    together, alone = ([Rig(opened(seed)) for seed in range(COPIES)] for _ in range(2))
    batch = BrainBatch()
    for number, what, value in acts:
        for rigs in (together, alone):
            rigs[number].act(what, value)
        ends_ns = [rig.brain.now_ns + STEP_NS for rig in together]
        assert not batch.run_until([rig.brain for rig in together], ends_ns)
        for one, other in zip(together, alone, strict=True):
            other.brain.run_until(other.brain.now_ns + STEP_NS)
            assert one.brain.now_ns == other.brain.now_ns
            assert one.seen() == other.seen()


def test_one_that_cannot_run_does_not_stop_the_others(opened: Callable[[int], Brain]) -> None:
    rigs = [Rig(opened(seed)) for seed in range(COPIES)]
    rigs[1].brain.close()
    failed = BrainBatch().run_until([rig.brain for rig in rigs], [STEP_NS] * COPIES)
    assert {number: type(error) for number, error in failed.items()} == {1: LifecycleError}
    assert [rig.brain.now_ns for rig in rigs] == [STEP_NS, 0, STEP_NS]
