"""Synapses in two bytes: every one acts once, on its target, after its delay, with its weight."""

from collections.abc import Callable

import numpy as np
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st
from nrp_brain_event import EventBackend, EventOptions
from nrp_brain_event.grid.loader import build_grid

from nrp_core.brain.interface import Brain
from nrp_core.clock import NS_PER_MS
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.grid import Grid as TimeGrid

Cells = Callable[..., Population]
Connect = Callable[..., Projection]
Open = Callable[..., Brain]

N_SOURCES, N_CELLS = 4, 5
NEVER_FIRES = {
    "v_rest": 0.0, "v_reset": 0.0, "v_thresh": 1e9, "tau_m": 1e12, "cm": 1.0, "tau_refrac": 1.0,
    "i_offset": 0.0,
}  # fmt: skip
SYNAPSE = st.tuples(
    st.integers(0, N_SOURCES - 1), st.integers(0, N_CELLS - 1), st.sampled_from([0.5, 1.0, 2.0]),
    st.sampled_from([0.1, 1.0, 2.5, 7.0]),
)  # fmt: skip


def counters(size: int = N_CELLS, label: str = "n") -> Population:
    """Return cells whose voltage is the sum of what has arrived."""
    each = {name: np.full(size, value) for name, value in NEVER_FIRES.items()}
    return Population(label, size, "IF_curr_delta", each, {"v": np.zeros(size)})


def projection(label: str, synapses: list[tuple[int, int, float, float]]) -> Projection:
    pre, post, weight, delay = (np.array(column) for column in zip(*synapses, strict=True))
    return Projection(
        label,
        "s",
        "n",
        "excitatory",
        pre.astype(np.int32),
        post.astype(np.int32),
        weight.astype(float),
        delay,
    )


@settings(max_examples=60, deadline=None)
@given(st.lists(st.lists(SYNAPSE, min_size=1, max_size=30), min_size=1, max_size=3))
def test_every_synapse_delivers_its_weight_after_its_delay(
    projections: list[list[tuple[int, int, float, float]]],
) -> None:
    times = [np.array([1.0 + k, 4.0 + k / 10]) for k in range(N_SOURCES)]
    sources = Population("s", N_SOURCES, "SpikeSourceArray", {}, {}, tuple(times))
    network = Network(
        {"s": sources, "n": counters()},
        tuple(projection(f"p{k}", synapses) for k, synapses in enumerate(projections)),
    )
    with EventBackend().open(network, seed=1, options=EventOptions(resolution="0.1 ms")) as brain:
        for t in (2.0, 3.3, 5.0, 8.0, 12.0):
            brain.run_until(round(t * NS_PER_MS))
            expected = np.zeros(N_CELLS)
            for pre, post, weight, delay in (synapse for part in projections for synapse in part):
                expected[post] += weight * (times[pre] + delay <= t + 1e-9).sum()
            found = brain.read_state("v", np.arange(N_SOURCES, N_SOURCES + N_CELLS))
            assert found == pytest.approx(expected, abs=1e-6)


def test_equal_synapses_take_two_bytes_and_own_weights_four_more() -> None:
    n, fan_out = 1000, 400
    rng = np.random.default_rng(1)
    pre = np.repeat(np.arange(n, dtype=np.int32), fan_out)
    post = rng.integers(0, n, n * fan_out, dtype=np.int32)

    def bytes_of(weight: np.ndarray) -> float:
        synapses = Projection(
            "p", "n", "n", "excitatory", pre, post, weight, np.broadcast_to(1.5, n * fan_out)
        )
        grid, _, _ = build_grid(
            Network({"n": counters(n)}, (synapses,)), 1e-9, TimeGrid(NS_PER_MS // 10), frozenset()
        )
        names = [name for name in grid._fields if name.startswith(("segment_", "row_", "targets", "weights"))]
        return sum(getattr(grid, name).nbytes for name in names) / (n * fan_out)

    assert bytes_of(np.broadcast_to(0.1, n * fan_out)) < 2.1
    assert bytes_of(rng.random(n * fan_out)) < 6.1


def test_synapses_of_a_cell_with_the_same_delay_are_adjacent(cells: Cells) -> None:
    """Excitatory and inhibitory synapses are of different tables; equal weights are kept elsewhere."""
    rng, pre = np.random.default_rng(2), np.repeat(np.arange(20, dtype=np.int32), 30)

    def drawn(receptor: str, sign: float) -> Projection:
        post = rng.integers(0, 20, pre.size, dtype=np.int32)
        weight, delay = sign * rng.uniform(0.1, 1.0, pre.size), rng.integers(1, 4, pre.size) / 10
        return Projection(receptor, "n", "n", receptor, pre, post, weight, delay)

    projections = drawn("excitatory", 1.0), drawn("inhibitory", -1.0)
    network = Network({"n": cells("n", "IF_curr_exp", 20)}, projections)
    grid, _, _ = build_grid(network, 1e-9, TimeGrid(NS_PER_MS // 10), frozenset())
    assert len(grid.tables) == 2
    ends = grid.segments["start"] + grid.segments["length"]
    for first, last in zip(grid.row_first, grid.row_first[1:], strict=False):
        own = grid.segments[first:last]
        assert {*own["table"].tolist()} == {0, 1}
        assert (own["start"][1:] == ends[first : last - 1]).all()


def test_targets_beyond_sixteen_bits_are_reached() -> None:
    n = 70_000
    post = np.array([0, 65_535, 65_536, 69_999, 3], np.int32)
    pre = np.zeros(5, np.int32)
    source = Population("s", 1, "SpikeSourceArray", {}, {}, (np.array([1.0]),))
    weight = np.broadcast_to(2.0, 5)
    synapses = Projection("p", "s", "n", "excitatory", pre, post, weight, np.broadcast_to(1.0, 5))
    network = Network({"s": source, "small": counters(10, "small"), "n": counters(n)}, (synapses,))
    with EventBackend().open(network, seed=1, options=EventOptions(resolution="1 ms")) as brain:
        brain.run_until(3 * NS_PER_MS)
        voltages = brain.read_state("v", np.arange(1, n + 11))
    assert np.flatnonzero(voltages).tolist() == sorted((post + 10).tolist())


def test_delays_off_the_grid_are_rounded_with_a_warning(
    cells: Cells, connect: Connect, open_brain: Open, golden: Golden
) -> None:
    network = (cells("n", "IF_curr_exp", 2), connect("n", "n", 0.1, 1.04, pairs=[(0, 1)]))
    (warning,) = open_brain(*network, resolution="0.1 ms").warnings
    golden(warning.message)
    assert open_brain(*network, resolution="0.01 ms").warnings == []
    inhibited = connect("n", "n", -0.1, 1.04, pairs=[(0, 1)], receptor="inhibitory")
    (warning,) = open_brain(*network, inhibited, resolution="0.1 ms").warnings
    assert warning.message.startswith("delays of projection 'n-n-excitatory' and of 1 more are rounded")
