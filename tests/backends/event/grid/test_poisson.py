"""Poisson cells that the grid draws itself."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import exp, lgamma, log

import numpy as np
import pytest
from golden import Golden
from nrp_brain_event import EventBackend, EventOptions
from nrp_brain_event.grid.poisson import N_GUIDE, _add_counts, _scatter_counts, drawable, guide

from nrp_core.brain.devices.sinks import SpikeRecorder
from nrp_core.brain.interface import Brain
from nrp_core.clock import NS_PER_MS
from nrp_core.network.data import Network, Population, Projection

N, RATE_HZ, STEP_MS = 503, 4000.0, 0.1


def noise(size: int = N, rate: object = RATE_HZ, start: float = 0.0, duration: float = 1e9) -> Population:
    values = {"rate": rate, "start": start, "duration": duration}
    each = {name: np.full(size, value, dtype=float) for name, value in values.items()}
    return Population("noise", size, "SpikeSourcePoisson", each)


def one_to_one(pairs: int = N) -> Projection:
    each = np.arange(pairs, dtype=np.int32)
    return Projection(
        "p", "noise", "n", "excitatory", each[::-1].copy(), each, np.broadcast_to(1.0, pairs),
        np.broadcast_to(0.5, pairs),
    )  # fmt: skip


def counters() -> Population:
    values = {
        "v_rest": 0.0, "v_reset": 0.0, "v_thresh": 1e9, "tau_m": 1e12, "cm": 1.0, "tau_refrac": 1.0,
        "i_offset": 0.0,
    }  # fmt: skip
    each = {name: np.full(N, value) for name, value in values.items()}
    return Population("n", N, "IF_curr_delta", each, {"v": np.zeros(N)})


@pytest.fixture
def opened() -> Callable[..., Brain]:
    def make(source: Population, seed: int = 1) -> Brain:
        network = Network({"noise": source, "n": counters()}, (one_to_one(),))
        options = EventOptions(resolution="0.1 ms", poisson="grid")
        return EventBackend().open(network, seed=seed, options=options)

    return make


def arrived(brain: Brain) -> np.ndarray:
    return brain.read_state("v", np.arange(N, 2 * N))


@pytest.mark.parametrize("mean", [0.0, 0.003, 0.4, 2.0, 60.0])
def test_a_guide_holds_the_whole_distribution(mean: float) -> None:
    counts, bounds = guide(mean)
    edges = np.append(np.uint64(0), bounds)
    shares = [float(b - a) / 2.0**64 for a, b in pairwise(edges)]
    expected = [
        exp(k * log(mean) - mean - lgamma(k + 1)) if mean else float(k == 0) for k in range(len(shares))
    ]
    assert shares == pytest.approx(expected, abs=1e-13)
    for cell in range(0, N_GUIDE, 37):
        lowest, highest = cell << 52, ((cell + 1) << 52) - 1
        alike = np.searchsorted(bounds, np.array([lowest, highest], np.uint64), "right")
        assert counts[cell] == (alike[0] if alike[0] == alike[1] else -1)


@pytest.mark.parametrize("n_cells", [1, 4, 23])
def test_cells_in_a_row_get_the_counts_of_listed_ones(n_cells: int) -> None:
    counts, bounds = guide(1.7)
    targets = np.arange(9, 9 + n_cells, dtype=np.uint32)
    for place in range(5):
        listed, in_a_row = np.zeros(40), np.zeros(40)
        given = targets, counts, bounds, np.uint64(77), place, 0.5
        _scatter_counts(listed, *given)
        _add_counts(in_a_row[9 : 9 + n_cells], *given)
        assert (listed == in_a_row).all()
        assert not listed[:9].any()


def test_counts_have_the_mean_and_variance_of_the_process(opened: Callable[..., Brain]) -> None:
    brain, counts = opened(noise()), []
    for t_ms in range(1, 401):
        brain.run_until(t_ms * NS_PER_MS)
        counts.append(arrived(brain).round())
    windows = np.diff(np.array(counts), axis=0)  # of 1 ms, 4 expected
    n = windows.size
    assert windows.mean() == pytest.approx(4.0, abs=4 * np.sqrt(4.0 / n))
    assert windows.var() == pytest.approx(4.0, abs=4 * np.sqrt((4.0 + 2 * 16.0) / n))
    together = np.corrcoef(windows[:, :40].T)
    assert np.abs(together - np.eye(40)).max() < 5.5 / np.sqrt(len(windows))
    later = np.corrcoef(windows[:-1].ravel(), windows[1:].ravel())[0, 1]
    assert abs(later) < 4 / np.sqrt(n)


def test_sources_that_are_divided_among_targets_are_drawn_by_the_grid() -> None:
    """As a one-to-one projection onto an assembly: the same noise, in two projections."""
    whole, options = one_to_one(), EventOptions(resolution="0.1 ms", poisson="grid")
    few = whole.pre_index < 200
    parts = (replace(whole.only(few), label="a"), replace(whole.only(~few), label="b"))
    networks = [Network({"noise": noise(), "n": counters()}, some) for some in ((whole,), parts)]
    assert [drawable(network) for network in networks] == [{"noise"}] * 2
    recorded = []
    for network in networks:
        brain = EventBackend().open(network, seed=1, options=options)
        recorder = brain.add_sink(SpikeRecorder(), np.arange(N), name="all")
        brain.run_until(300 * NS_PER_MS)
        spikes = recorder.spikes()
        in_time = spikes.neurons[spikes.times_ms <= 299.5 + 1e-9]
        assert np.bincount(in_time, minlength=N)[::-1] == pytest.approx(arrived(brain), abs=1e-6)
        recorded.append(np.array([np.bincount(spikes.neurons, minlength=N)]))
    together = np.corrcoef(recorded[1][0][:200], recorded[1][0][200:400])[0, 1]
    assert abs(together) < 5 / np.sqrt(200)
    assert recorded[1].mean() == pytest.approx(RATE_HZ * 0.3, abs=5 * np.sqrt(RATE_HZ * 0.3 / N))


def test_spikes_reach_each_subscriber_after_the_delay(
    opened: Callable[..., Brain],
) -> None:
    deaf, listened = opened(noise()), opened(noise())
    recorder = listened.add_sink(SpikeRecorder(), np.arange(N), name="all")
    for brain in (deaf, listened):
        brain.run_until(20 * NS_PER_MS)
    assert (arrived(deaf) == arrived(listened)).all()
    spikes = recorder.spikes()
    in_time = spikes.neurons[spikes.times_ms <= 19.5 + 1e-9]
    assert np.bincount(in_time, minlength=N)[::-1] == pytest.approx(arrived(listened), abs=1e-6)


def test_trains_depend_on_the_seed_and_reset_brings_them_back(opened: Callable[..., Brain]) -> None:
    brain, other = opened(noise()), opened(noise(), seed=2)
    for each in (brain, other):
        each.run_until(5 * NS_PER_MS)
    first = arrived(brain)
    assert (arrived(other) != first).any()
    brain.reset()
    brain.run_until(5 * NS_PER_MS)
    assert (arrived(brain) == first).all()
    brain.reset(seed=2)
    brain.run_until(5 * NS_PER_MS)
    assert (arrived(brain) == arrived(other)).all()


def test_start_and_duration_are_kept(opened: Callable[..., Brain]) -> None:
    brain = opened(noise(start=2.0, duration=3.0))
    sums = []
    for t_ms in (2.5, 4.0, 5.5, 20.0):
        brain.run_until(round(t_ms * NS_PER_MS))
        sums.append(arrived(brain).sum())
    assert sums[0] == 0.0
    assert sums[1] == pytest.approx(1.5 * N * 4.0, rel=0.1)
    assert sums[2] == pytest.approx(3.0 * N * 4.0, rel=0.1)
    assert sums[3] == pytest.approx(sums[2], rel=1e-6)


def test_populations_that_need_single_spikes_are_left_to_the_core() -> None:
    unequal = noise(rate=np.linspace(1.0, 2.0, N))
    cells = counters()
    assert drawable(Network({"noise": noise(), "n": cells}, (one_to_one(),))) == {"noise"}
    assert not drawable(Network({"noise": unequal, "n": cells}, (one_to_one(),)))
    assert not drawable(Network({"noise": noise(), "n": cells}, (one_to_one(N - 1),)))
    assert not drawable(Network({"noise": noise(), "n": cells}))


def test_the_grid_draws_only_where_there_is_one(golden: Golden) -> None:
    with golden.raises(ValueError):
        EventOptions(poisson="grid")
    with golden.raises(ValueError):
        EventOptions(resolution="2 ms")
