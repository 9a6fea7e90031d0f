"""Threads that share the rows of a grid compute what one thread does, to the last bit."""

from typing import Any

import numpy as np
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st
from nrp_brain_event import EventBackend, EventOptions
from nrp_conformance.brain import kit
from nrp_conformance.brain.kit import SAMPLES
from pydantic import ValidationError

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.devices.sources import PoissonSource
from nrp_core.brain.interface import Brain
from nrp_core.clock import from_milliseconds
from nrp_core.errors import DivergedError
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.synapses import STATIC, STDP, TSODYKS_MARKRAM

KINDS = ("IF_curr_exp", "IF_curr_alpha", "IF_cond_exp", "IF_curr_delta", "Izhikevich")
"""Cells that advance before the arrivals, and after them."""


def opened(network: Network, threads: int, resolution: str = "0.1 ms") -> Brain:
    options = EventOptions(resolution=resolution, poisson="grid", threads=threads)
    return EventBackend().open(network, seed=7, options=options)


def random_network(seed: int, kinds: list[str], shortest_ms: float) -> Network:
    """Return cells that fire, all connected at random, with sources and noise."""
    rng = np.random.default_rng(seed)
    sizes = rng.integers(5, 40, len(kinds))
    made: list[Population | Projection] = [
        kit.spikes("in", *(np.unique(rng.uniform(0.0, 25.0, 6)) for _ in range(4)))
    ]
    labels = [f"{k} {kind}" for k, kind in enumerate(kinds)]
    for label, kind, size in zip(labels, kinds, sizes.tolist(), strict=True):
        sample = SAMPLES[kind]
        drives = sample.current_na * rng.uniform(1.0, 4.0, size)
        made.append(kit.cells(sample, label, size, i_offset=drives))
        each = np.arange(size, dtype=np.int32)
        made.append(kit.poisson(f"noise {label}", size, 600.0))
        made.append(
            Projection(
                f"noise of {label}",
                f"noise {label}",
                label,
                "excitatory",
                rng.permutation(each),
                each,
                np.full(size, sample.weak),
                np.full(size, shortest_ms),
            )
        )
    every = [("in", 4), *zip(labels, sizes.tolist(), strict=True)]
    for pre, n_pre in every:
        for post, n_post in every[1:]:
            n, weak = 8 * n_post, SAMPLES[post.split(" ")[1]].weak
            kind = STATIC if rng.random() < 0.7 else TSODYKS_MARKRAM
            states = {"U": 0.4, "tau_rec": 50.0, "tau_facil": 5.0} if kind == TSODYKS_MARKRAM else {}
            made.append(
                Projection(
                    f"{pre} to {post}",
                    pre,
                    post,
                    "excitatory",
                    rng.integers(0, n_pre, n, np.int32),
                    rng.integers(0, n_post, n, np.int32),
                    rng.uniform(0.0, weak, n) if rng.random() < 0.8 else np.full(n, weak),
                    shortest_ms + (rng.uniform(0.0, 4.0, n) if rng.random() < 0.5 else np.zeros(n)),
                    kind,
                    {name: np.full(n, value) for name, value in states.items()},
                )
            )
    return kit.network(*made)


def course(network: Network, threads: list[int], resolution: str, *, changes: bool) -> list[Any]:
    """Return spikes and voltages of three legs, each by as many threads from a snapshot of the one before."""
    seen: list[Any] = []
    snapshot = None
    cells = [label for label in network.populations if label[0].isdigit()]
    first = network.ids_of(cells[0])
    everyone = np.concatenate([network.ids_of(label) for label in cells])
    kind = network.populations[cells[0]].cell_type
    drive = PoissonSource(rate=400.0, weight=SAMPLES[kind].weak, delay=0.5)
    for leg, (n, t_ms) in enumerate(zip(threads, (6.5, 14.0, 20.0), strict=True)):
        with opened(network, n, resolution) as brain:
            recorder = brain.add_sink(SpikeRecorder(), np.arange(network.size), name="all")
            brain.add_source(drive, first, name="drive")
            if snapshot is not None:
                brain.restore(snapshot)
            if leg == 1 and changes:
                label = f"{cells[0]} to {cells[0]}"
                brain.set_weights(label, 1.3 * brain.read_weights(label))
                brain.set_parameters(first[::2], {"i_offset": SAMPLES[kind].current_na})
            brain.run_until(from_milliseconds(t_ms))
            spikes = recorder.spikes()
            seen.append((spikes.neurons.tolist(), spikes.times_ms.tolist()))
            seen.append(brain.read_state("v", everyone).tolist())
            snapshot = brain.snapshot()
    return seen


@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.sampled_from(KINDS), min_size=1, max_size=3),
    st.sampled_from(["0.1 ms", "0.5 ms"]),
    st.sampled_from([0.1, 0.4, 1.5]),
    st.lists(st.integers(1, 4), min_size=3, max_size=3).filter(lambda threads: max(threads) > 1),
    st.booleans(),
)
@settings(max_examples=12, deadline=None)
def test_any_number_of_threads_gives_the_same_bits(
    seed: int, kinds: list[str], resolution: str, shortest_ms: float, threads: list[int], changes: bool
) -> None:
    """Also where snapshots under one number go on under another, in the middle of a window."""
    network = random_network(seed, kinds, shortest_ms)
    alone = course(network, [1, 1, 1], resolution, changes=changes)
    neurons = np.array(alone[-2][0])
    assert (neurons >= network.ids_of(f"0 {kinds[0]}")[0]).any()
    assert course(network, threads, resolution, changes=changes) == alone


def test_spikes_of_several_steps_arrive_in_one_order() -> None:
    """What arrives at once at such cells is summed from zero: the last bit depends on the order."""
    rng = np.random.default_rng(5)
    made: list[Population | Projection] = [kit.cells(SAMPLES["IF_curr_delta"], "post", 10, v_thresh=1e9)]
    pre, post = (index.reshape(-1).astype(np.int32) for index in np.indices((60, 10)))
    for label, weight in (("a", 0.1 / 3.0), ("b", 0.07 / 7.0), ("c", 0.013 / 11.0)):
        drives = rng.uniform(20.0, 60.0, 60) * SAMPLES["IF_curr_exp"].current_na
        made.append(kit.cells(SAMPLES["IF_curr_exp"], label, 60, i_offset=drives, tau_refrac=0.5))
        weights, delays = np.full(len(pre), weight), rng.uniform(2.0, 3.0, len(pre))
        made.append(Projection(f"of {label}", label, "post", "excitatory", pre, post, weights, delays))
    network = kit.network(*made)
    seen = []
    for threads in (1, 2, 3, 4):
        with opened(network, threads) as brain:
            brain.run_until(from_milliseconds(30.0))
            seen.append(brain.read_state("v", network.ids_of("post")).tolist())
    assert len(set(seen[0])) == 10
    assert seen == [seen[0]] * 4


def test_the_calendar_and_lists_of_spikes_grow_in_every_part() -> None:
    """Two thousand cells without a refractory time fire in every step, onto each other."""
    n = 2000
    cells = kit.cells(SAMPLES["IF_curr_delta"], "n", n, i_offset=1e6, tau_refrac=0.0)
    each = np.arange(n, dtype=np.int32)
    onto = Projection("p", "n", "n", "excitatory", each, each[::-1].copy(), np.full(n, 0.1), np.full(n, 2.0))
    seen = []
    for threads in (1, 3):
        with opened(kit.network(cells, onto), threads) as brain:
            recorder = brain.add_sink(SpikeRecorder(), np.arange(n), name="all")
            brain.run_until(from_milliseconds(6.0))
            seen.append((len(recorder.spikes()), brain.read_state("v", np.arange(n)).tolist()))
    assert seen[0][0] == 60 * n
    assert seen[0] == seen[1]


def test_threads_name_the_cell_that_one_thread_names() -> None:
    wild = kit.cells(SAMPLES["Izhikevich"], "wild", 9, i_offset=np.where(np.arange(9) % 4 == 1, 1e300, 0.0))
    named = []
    for threads in (1, 2, 4):
        with opened(kit.network(wild), threads) as brain, pytest.raises(DivergedError) as failure:
            brain.run_until(from_milliseconds(2.0))
        named.append(str(failure.value))
    assert named == [named[0]] * 3


def test_plasticity_by_spike_timing_takes_one_thread_and_says_so() -> None:
    cells = kit.cells(SAMPLES["IF_curr_exp"], "n", 4)
    rule = {"timing": "SpikePairRule", "weight": "AdditiveWeightDependence"}
    plastic = kit.connect(
        "n", "n", 0.1, kind=STDP, rule=rule, pairs=[(0, 1), (2, 3)], dendritic_delay_fraction=1.0,
        A_plus=0.02, A_minus=0.015, tau_plus=20.0, tau_minus=15.0, w_min=0.0, w_max=2.0,
    )  # fmt: skip
    with opened(kit.network(cells, plastic), 2) as brain:
        brain.run_until(from_milliseconds(5.0))
        assert any("uses one thread" in str(warning) for warning in brain.warnings)


def test_threads_without_a_grid_are_refused(golden: Golden) -> None:
    with golden.raises(ValidationError, match=r"e\.g\. 0\.1"):
        EventOptions.model_validate({"threads": 2})


def test_a_tolerance_on_a_grid_is_refused(golden: Golden) -> None:
    with golden.raises(ValidationError, match="1e-06"):
        EventOptions.model_validate({"tolerance": 1e-6, "resolution": "0.1 ms"})
