"""Controls keep the statistics that they promise; interventions meet the synapses of the named cells."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.brain.network.controls import CONTROLS
from nrp_core.brain.network.data import Network, Projection
from nrp_core.brain.network.interventions import Intervention
from nrp_core.conformance.brain import parts
from nrp_core.conformance.brain.samples import SAMPLES
from nrp_core.errors import NetworkError, NeuronSelectionError
from nrp_core.seeds import Seeds

REWIRE, SIGNS, WEIGHTS = CONTROLS
N = 40


def sparse(seed: int, cell: str = "IF_curr_exp") -> Network:
    """Return 40 cells, half of which inhibit, with at most one synapse between two and none to themselves."""
    rng = np.random.default_rng(seed)
    pre, post = np.nonzero((rng.random((N, N)) < 0.15) & ~np.eye(N, dtype=bool))
    inhibits, magnitude = rng.permutation(N) < N // 2, rng.uniform(0.1, 1.0, len(pre))
    made = [parts.cells(SAMPLES[cell], "n", N)]
    projections = []
    for receptor, sign, mine in (
        ("excitatory", 1.0, ~inhibits[pre]),
        ("inhibitory", 1.0 if "cond" in cell else -1.0, inhibits[pre]),
    ):
        delay = rng.uniform(0.5, 2.0, int(mine.sum()))
        ends = pre[mine].astype(np.int32), post[mine].astype(np.int32)
        projections.append(Projection(receptor, "n", "n", receptor, *ends, sign * magnitude[mine], delay))
    network = parts.network(*made, *projections)
    return replace(network, views={"few": np.arange(4), "others": np.arange(10, 30)})


def all_of(network: Network, value: Callable[[Projection], np.ndarray]) -> list[float]:
    return np.concatenate([value(one) for one in network.projections]).tolist()


@given(st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1))
def test_rewiring_keeps_all_degrees_and_adds_neither_loops_nor_double_synapses(seed: int, other: int) -> None:
    network = sparse(seed)
    found = CONTROLS[REWIRE](network, Seeds(other))
    for mine, given_ in zip(found.projections, network.projections, strict=True):
        assert mine.pre_index.tolist() == given_.pre_index.tolist()
        assert sorted(mine.post_index.tolist()) == sorted(given_.post_index.tolist())
        assert mine.post_index.tolist() != given_.post_index.tolist()
        assert mine.weight.tolist() == given_.weight.tolist()
        pairs = list(zip(mine.pre_index.tolist(), mine.post_index.tolist(), strict=True))
        assert len(set(pairs)) == len(pairs)
        assert all(pre != post for pre, post in pairs)
    assert CONTROLS[REWIRE](network, Seeds(other)).digest == found.digest


@given(st.integers(0, 2**32 - 1), st.sampled_from(["IF_curr_exp", "IF_cond_exp"]))
def test_shuffled_signs_move_whole_cells_and_keep_pairs_and_magnitudes(seed: int, cell: str) -> None:
    network = sparse(seed, cell)
    found = CONTROLS[SIGNS](network, Seeds(seed))

    def synapses(of: Network) -> Counter[tuple[float, ...]]:
        columns = ("pre_index", "post_index", "delay_ms")
        rows = [all_of(of, lambda one, name=name: getattr(one, name)) for name in columns]  # type: ignore[misc]
        return Counter(zip(*rows, np.abs(all_of(of, lambda one: one.weight)).tolist(), strict=True))

    def inhibiting(of: Network) -> set[int]:
        return {i for one in of.projections if one.receptor == "inhibitory" for i in one.pre_index.tolist()}

    def exciting(of: Network) -> set[int]:
        return {i for one in of.projections if one.receptor == "excitatory" for i in one.pre_index.tolist()}

    assert synapses(found) == synapses(network)
    assert not inhibiting(found) & exciting(found)
    assert len(inhibiting(found)) == len(inhibiting(network))
    assert inhibiting(found) != inhibiting(network)


def test_shuffled_weights_are_the_same_weights_elsewhere() -> None:
    network = sparse(3)
    found = CONTROLS[WEIGHTS](network, Seeds(1))
    for mine, given_ in zip(found.projections, network.projections, strict=True):
        assert sorted(mine.weight) == sorted(given_.weight)
        assert mine.weight.tolist() != given_.weight.tolist()
        assert mine.post_index.tolist() == given_.post_index.tolist()


def test_a_wiring_without_alternative_is_an_error_alone_and_a_remark_beside_others() -> None:
    pairs = [(i, j) for i in range(5) for j in range(5)]
    made = parts.cells(SAMPLES["IF_curr_exp"], "a", 5), parts.cells(SAMPLES["IF_curr_exp"], "b", 5)
    dense = parts.connect("a", "b", 0.4, 1.5, pairs=pairs)
    with pytest.raises(NetworkError, match="no projection can be rewired with the same degrees"):
        CONTROLS[REWIRE](parts.network(*made, dense), Seeds(1))
    cycle = parts.connect("b", "a", 0.4, 1.5, pairs=[(k, (k + 1) % 5) for k in range(5)])
    found = CONTROLS[REWIRE](parts.network(*made, dense, cycle), Seeds(1))
    assert found.projections[0] is dense
    assert found.remarks == (
        f"projection '{dense.label}' is not rewired: no other wiring with the same degrees was found",
    )


@pytest.mark.parametrize(
    ("intervention", "is_meant"),
    [
        (Intervention.silence("few"), lambda pre, post: pre < 4),
        (Intervention.lesion("few"), lambda pre, post: (pre < 4) | (post < 4)),
        (Intervention("few", "others", 0.0), lambda pre, post: (pre < 4) & (post >= 10) & (post < 30)),
        (Intervention(None, "few", 0.0), lambda pre, post: post < 4),
    ],
)
def test_cut_synapses_are_those_of_the_named_cells(
    intervention: Intervention, is_meant: Callable[..., np.ndarray]
) -> None:
    network = sparse(5)
    found = intervention.of(network)
    for mine, given_ in zip(found.projections, network.projections, strict=True):
        kept = ~is_meant(given_.pre_index, given_.post_index)
        assert 0 < kept.sum() < len(kept)
        assert mine.post_index.tolist() == given_.post_index[kept].tolist()
        assert mine.weight.tolist() == given_.weight[kept].tolist()
    assert intervention.affected(found) == []


def test_scaling_multiplies_the_weights_of_the_named_cells_alone() -> None:
    network = sparse(5)
    found = Intervention("few", None, 2.5).of(network)
    for mine, given_ in zip(found.projections, network.projections, strict=True):
        share = np.where(given_.pre_index < 4, 2.5, 1.0)
        assert mine.weight.tolist() == (share * given_.weight).tolist()


def test_an_unknown_name_is_an_error_with_the_nearest_one() -> None:
    with pytest.raises(NeuronSelectionError, match="no population 'fow'; did you mean 'few'"):
        Intervention.lesion("fow").of(sparse(5))
