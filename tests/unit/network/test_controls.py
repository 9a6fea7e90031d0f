"""Controls keep the statistics that they promise; interventions meet the synapses of the named cells."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from operator import is_

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st
from nrp_conformance.brain import kit
from nrp_conformance.brain.kit import SAMPLES

from nrp_core.errors import NetworkError, NeuronSelectionError
from nrp_core.network.controls import CONTROLS, with_matched_cells_silenced
from nrp_core.network.data import Network, Projection
from nrp_core.network.interventions import Intervention
from nrp_core.network.rewiring import Neuromodulation
from nrp_core.seeds import Seeds

REWIRE, SIGNS, WEIGHTS = CONTROLS
N = 40


def sparse(seed: int, cell: str = "IF_curr_exp") -> Network:
    """Return 40 cells, half of which inhibit, with at most one synapse between two and none to themselves."""
    rng = np.random.default_rng(seed)
    pre, post = np.nonzero((rng.random((N, N)) < 0.15) & ~np.eye(N, dtype=bool))
    inhibits, magnitude = rng.permutation(N) < N // 2, rng.uniform(0.1, 1.0, len(pre))
    made = [kit.cells(SAMPLES[cell], "n", N)]
    projections = []
    for receptor, sign, mine in (
        ("excitatory", 1.0, ~inhibits[pre]),
        ("inhibitory", 1.0 if "cond" in cell else -1.0, inhibits[pre]),
    ):
        delay = rng.uniform(0.5, 2.0, int(mine.sum()))
        ends = pre[mine].astype(np.int32), post[mine].astype(np.int32)
        projections.append(Projection(receptor, "n", "n", receptor, *ends, sign * magnitude[mine], delay))
    network = kit.network(*made, *projections)
    return replace(network, views={"few": np.arange(4), "others": np.arange(10, 30)})


def all_of(network: Network, value: Callable[[Projection], np.ndarray]) -> list[float]:
    return np.concatenate([value(one) for one in network.projections]).tolist()


def require_rewired(network: Network, found: Network) -> None:
    """Assert that all degrees are kept, and that there are neither new loops nor double synapses."""
    for mine, given_ in zip(found.projections, network.projections, strict=True):
        assert mine.pre_index.tolist() == given_.pre_index.tolist()
        assert sorted(mine.post_index.tolist()) == sorted(given_.post_index.tolist())
        assert mine.post_index.tolist() != given_.post_index.tolist()
        assert mine.weight.tolist() == given_.weight.tolist()
        pairs = list(zip(mine.pre_index.tolist(), mine.post_index.tolist(), strict=True))
        assert len(set(pairs)) == len(pairs)
        assert all(pre != post for pre, post in pairs)


def require_other_signs(network: Network, found: Network) -> None:
    """Assert that whole cells change their sign, and that pairs and magnitudes are kept."""

    def synapses(of: Network) -> Counter[tuple[float, ...]]:
        columns = ("pre_index", "post_index", "delay_ms")
        rows = [all_of(of, lambda one, name=name: getattr(one, name)) for name in columns]  # type: ignore[misc]
        return Counter(zip(*rows, np.abs(all_of(of, lambda one: one.weight)).tolist(), strict=True))

    def cells(of: Network, receptor: str) -> set[int]:
        return {i for one in of.projections if one.receptor == receptor for i in one.pre_index.tolist()}

    assert synapses(found) == synapses(network)
    assert not cells(found, "inhibitory") & cells(found, "excitatory")
    assert len(cells(found, "inhibitory")) == len(cells(network, "inhibitory"))
    assert cells(found, "inhibitory") != cells(network, "inhibitory")


def require_other_weights(network: Network, found: Network) -> None:
    """Assert that each projection has the same weights at other synapses."""
    for mine, given_ in zip(found.projections, network.projections, strict=True):
        assert sorted(mine.weight) == sorted(given_.weight)
        assert mine.weight.tolist() != given_.weight.tolist()
        assert mine.post_index.tolist() == given_.post_index.tolist()


@given(st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1))
def test_rewiring_keeps_all_degrees_and_adds_neither_loops_nor_double_synapses(seed: int, other: int) -> None:
    network = sparse(seed)
    found = CONTROLS[REWIRE](network, Seeds(other))
    require_rewired(network, found)
    assert CONTROLS[REWIRE](network, Seeds(other)).digest == found.digest


@given(st.integers(0, 2**32 - 1), st.sampled_from(["IF_curr_exp", "IF_cond_exp"]))
def test_shuffled_signs_move_whole_cells_and_keep_pairs_and_magnitudes(seed: int, cell: str) -> None:
    network = sparse(seed, cell)
    require_other_signs(network, CONTROLS[SIGNS](network, Seeds(seed)))


def test_shuffled_signs_leave_rewards_as_they_are() -> None:
    network = sparse(3)
    wires = network.projections[0]
    reward = replace(wires, label="reward", receptor="reward", neuromodulation=Neuromodulation())
    with_reward = replace(network, projections=(reward, *network.projections))
    found = CONTROLS[SIGNS](with_reward, Seeds(1))
    assert found.projections[0] is reward
    others = replace(network, projections=found.projections[1:])
    assert others.digest == CONTROLS[SIGNS](network, Seeds(1)).digest


def test_shuffled_weights_are_the_same_weights_elsewhere() -> None:
    network = sparse(3)
    require_other_weights(network, CONTROLS[WEIGHTS](network, Seeds(1)))


@given(st.integers(0, 2**32 - 1))
def test_a_shuffle_of_few_values_is_never_the_original(seed: int) -> None:
    """Two synapses have one other order; a draw that kept theirs would be no control."""
    pair = sparse(seed)
    pair = replace(pair, projections=tuple(one.only(np.arange(one.size) < 2) for one in pair.projections))
    require_other_weights(pair, CONTROLS[WEIGHTS](pair, Seeds(seed)))
    require_other_signs(pair, CONTROLS[SIGNS](pair, Seeds(seed)))


def test_projections_with_nothing_to_shuffle_stay_the_same_objects() -> None:
    network = sparse(3)
    equal = each(lambda one: replace(one, weight=np.full(one.size, one.weight[0])))(network)
    assert all(map(is_, equal.projections, CONTROLS[WEIGHTS](equal, Seeds(1)).projections))
    excites = replace(network, projections=network.projections[:1])
    assert all(map(is_, excites.projections, CONTROLS[SIGNS](excites, Seeds(1)).projections))


def each(change: Callable[[Projection], Projection]) -> Callable[[Network], Network]:
    return lambda network: replace(network, projections=tuple(map(change, network.projections)))


def by_synapse(network: Network) -> Network:
    """Exchange the receptors of the first half of all synapses, whichever cells they belong to."""
    found: list[Projection] = []
    for one, receptor in zip(network.projections, ("inhibitory", "excitatory"), strict=True):
        first = np.arange(one.size) < one.size // 2
        moved = replace(one.only(first), label=f"{receptor}'", receptor=receptor)
        found += [one.only(~first), replace(moved, weight=-moved.weight)]
    return replace(network, projections=tuple(found))


def permuted(one: Projection, **columns: str) -> Projection:
    """Return a projection with some columns permuted, as a control without any further care would."""
    order = np.random.default_rng(1).permutation(one.size)
    return replace(one, **{name: getattr(one, name)[order] for name in columns})  # type: ignore[arg-type]


RNG = np.random.default_rng(1)
WRONG_CONTROLS = [
    (require_rewired, lambda network: network),
    (require_rewired, each(lambda one: permuted(one, post_index=""))),
    (require_rewired, each(lambda one: permuted(one, post_index="", weight=""))),
    (require_rewired, each(lambda one: replace(one, post_index=RNG.integers(0, N, one.size, np.int32)))),
    (require_other_signs, lambda network: network),
    (require_other_signs, by_synapse),
    (require_other_weights, lambda network: network),
    (require_other_weights, each(lambda one: replace(one, weight=RNG.choice(one.weight, one.size)))),
    (require_other_weights, each(lambda one: permuted(one, weight="", post_index=""))),
]


@pytest.mark.parametrize(("require", "wrong"), WRONG_CONTROLS)
def test_a_wrong_control_is_noticed(
    require: Callable[[Network, Network], None], wrong: Callable[[Network], Network]
) -> None:
    network = sparse(4)
    with pytest.raises(AssertionError):
        require(network, wrong(network))


def test_a_wiring_without_alternative_is_unchanged_with_a_remark() -> None:
    pairs = [(i, j) for i in range(5) for j in range(5)]
    made = kit.cells(SAMPLES["IF_curr_exp"], "a", 5), kit.cells(SAMPLES["IF_curr_exp"], "b", 5)
    dense = kit.connect("a", "b", 0.4, 1.5, pairs=pairs)
    cycle = kit.connect("b", "a", 0.4, 1.5, pairs=[(k, (k + 1) % 5) for k in range(5)])
    found = CONTROLS[REWIRE](kit.network(*made, dense, cycle), Seeds(1))
    assert found.projections[0] is dense
    assert found.remarks == (
        f"projection '{dense.label}' is not rewired: no other wiring with the same degrees was found",
    )


def expected(network: Network, intervention: Intervention) -> list[list[float]]:
    """Return source, target, weight and delay of each synapse after an intervention, one by one."""
    few, others = set(range(4)), set(range(10, 30))
    names = {None: set(range(N)), "few": few, "others": others}
    sources, targets = names[intervention.sources], names[intervention.targets]
    kept = []
    for one in network.projections:
        for i in range(one.size):
            pre, post = int(one.pre_index[i]), int(one.post_index[i])
            ends = (pre in sources, post in targets)
            factor = intervention.factor if (any if intervention.either else all)(ends) else 1.0
            if factor:
                kept.append([pre, post, float(one.weight[i]) * factor, float(one.delay_ms[i])])
    return kept


def synapses_of(network: Network) -> list[list[float]]:
    columns = ("pre_index", "post_index", "weight", "delay_ms")
    return [
        list(row)
        for one in network.projections
        for row in zip(*(getattr(one, column).tolist() for column in columns), strict=True)
    ]


NAMES = st.sampled_from([None, "few", "others"])
INTERVENTIONS = st.one_of(
    st.builds(Intervention.silence, st.sampled_from(["few", "others"])),
    st.builds(Intervention.lesion, st.sampled_from(["few", "others"])),
    st.builds(Intervention, NAMES, NAMES, st.sampled_from([0.0, 0.5, 1.0, 2.5]), st.booleans()),
)


@given(st.integers(0, 2**32 - 1), INTERVENTIONS)
def test_an_intervention_changes_the_synapses_of_the_named_cells_alone(
    seed: int, intervention: Intervention
) -> None:
    network = sparse(seed)
    found = intervention.of(network)
    assert synapses_of(found) == expected(network, intervention)
    if intervention.factor == 0.0:
        assert intervention.synapses(found) == {}


WRONG_INTERVENTIONS = [
    (Intervention.silence("few"), Intervention(None, "few")),
    (Intervention.silence("few"), Intervention.lesion("few")),
    (Intervention.lesion("few"), Intervention("few", "few")),
    (Intervention("few", "others", 2.5), Intervention("few", "others", 2.5, either=True)),
    (Intervention("few", "others", 2.5), Intervention("others", "few", 2.5)),
    (Intervention("few", None, 0.5), Intervention("few", None, 0.0)),
]


@pytest.mark.parametrize(("intervention", "wrong"), WRONG_INTERVENTIONS)
def test_a_wrong_intervention_is_noticed(intervention: Intervention, wrong: Intervention) -> None:
    network = sparse(5)
    assert synapses_of(intervention.of(network)) == expected(network, intervention)
    assert synapses_of(wrong.of(network)) != expected(network, intervention)


def test_projections_without_selected_synapses_stay_the_same_objects() -> None:
    network = sparse(5)
    only = replace(network, views={"few": network.projections[0].pre_index[:1]})
    changed = Intervention("few", None, 2.0).of(only).projections
    assert [one is other for one, other in zip(changed, only.projections, strict=True)] == [False, True]


def test_an_unknown_name_is_an_error_with_the_nearest_one(golden: Golden) -> None:
    with golden.raises(NeuronSelectionError, match="'fow'.*'few'"):
        Intervention.lesion("fow").of(sparse(5))


@given(seed=st.integers(0, 50))
def test_cells_that_are_silenced_instead_are_as_many_others_of_the_same_quarter_of_degrees(seed: int) -> None:
    network = sparse(seed)
    degrees = np.bincount(np.concatenate([one.pre_index for one in network.projections]), minlength=N)
    quarter = np.searchsorted(np.quantile(degrees, (0.25, 0.5, 0.75)), degrees)
    found = with_matched_cells_silenced(network, "few", Seeds(seed))
    left = np.bincount(np.concatenate([one.pre_index for one in found.projections]), minlength=N)
    silenced = np.flatnonzero((left == 0) & (degrees > 0))
    assert not set(silenced) & set(network.views["few"])
    assert sorted(quarter[silenced]) == sorted(quarter[network.views["few"]])
    assert (left[left > 0] == degrees[left > 0]).all()
    assert found.views == network.views


def test_as_many_cells_are_silenced_if_a_quarter_has_too_few_others() -> None:
    network = sparse(3)
    degrees = np.bincount(np.concatenate([one.pre_index for one in network.projections]), minlength=N)
    most = np.argsort(degrees)[-N // 3 :]
    network = replace(network, views={"most": np.sort(most)})
    found = with_matched_cells_silenced(network, "most", Seeds(0))
    left = np.bincount(np.concatenate([one.pre_index for one in found.projections]), minlength=N)
    assert ((left == 0) & (degrees > 0)).sum() == len(most)


def test_nothing_is_silenced_instead_of_everything(golden: Golden) -> None:
    with golden.raises(NetworkError, match="'n'"):
        with_matched_cells_silenced(sparse(0), "n", Seeds(0))
