"""Connectors draw the synapses that PyNN draws, from the same generator."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pyNN.mock
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st
from pyNN.connectors import MapConnector
from pyNN.core import IndexBasedExpression
from pyNN.parameters import LazyArray

from nrp_core.errors import NetworkError
from nrp_core.network.data import Network
from nrp_core.network.pynn import builder
from nrp_core.network.pynn.rng import random_pairs

Make = Callable[[ModuleType, Any], Any]


class Near(IndexBasedExpression):  # type: ignore[misc]
    """A probability that depends on the indices of both cells."""

    def __call__(self, i: Any, j: Any) -> Any:
        return np.exp(-abs(i - j) / 2.0)


CONNECTORS: dict[str, Make] = {
    "all": lambda sim, rng: sim.AllToAllConnector(),
    "all others": lambda sim, rng: sim.AllToAllConnector(allow_self_connections=False),
    "one to one": lambda sim, rng: sim.OneToOneConnector(),
    "probability": lambda sim, rng: sim.FixedProbabilityConnector(0.4, rng=rng),
    "probability, others": lambda sim, rng: sim.FixedProbabilityConnector(0.7, False, rng=rng),
    "probability, one way": lambda sim, rng: sim.FixedProbabilityConnector(0.7, "NoMutual", rng=rng),
    "distance": lambda sim, rng: sim.DistanceDependentProbabilityConnector("exp(-d/3.0)", rng=rng),
    "index": lambda sim, rng: sim.IndexBasedProbabilityConnector(Near(), rng=rng),
    "displacement": lambda sim, rng: sim.DisplacementDependentProbabilityConnector(
        lambda d: 0.5 * (d[0] < 3), rng=rng
    ),
    "into each": lambda sim, rng: sim.FixedNumberPreConnector(3, rng=rng),
    "into each, repeated": lambda sim, rng: sim.FixedNumberPreConnector(5, with_replacement=True, rng=rng),
    "out of each": lambda sim, rng: sim.FixedNumberPostConnector(3, rng=rng),
    "out of each, all and more": lambda sim, rng: sim.FixedNumberPostConnector(20, rng=rng),
    "out of each, others": lambda sim, rng: sim.FixedNumberPostConnector(2, False, rng=rng),
    "out of each, repeated": lambda sim, rng: sim.FixedNumberPostConnector(4, True, True, rng=rng),
    "out of each, some": lambda sim, rng: sim.FixedNumberPostConnector(
        sim.RandomDistribution("uniform_int", (1, 5), rng=sim.NumpyRNG(5)), rng=rng
    ),
    "in all": lambda sim, rng: sim.FixedTotalNumberConnector(30, rng=rng),
    "list": lambda sim, rng: sim.FromListConnector([(0, 1, 0.5, 1.0), (2, 0, 0.25, 2.0), (0, 1, 0.5, 1.5)]),
    "list of pairs": lambda sim, rng: sim.FromListConnector([(2, 1), (0, 1), (1, 0)]),
    "array": lambda sim, rng: sim.ArrayConnector(np.eye(8, dtype=bool)[:, ::-1]),
}  # fmt: skip
ONLY_SQUARE = {"array", "probability, one way"}


def synapses(sim: ModuleType, n_pre: int, n_post: int, make: Make, weight: str, seed: int) -> Any:
    sim.setup(timestep=0.1)
    rng = sim.NumpyRNG(seed)
    pre = sim.Population(n_pre, sim.IF_cond_exp())
    post = pre if n_pre == n_post else sim.Population(n_post, sim.IF_cond_exp())
    weights = {
        "number": 0.5,
        "distribution": sim.RandomDistribution("gamma", (2.0, 0.1), rng=sim.NumpyRNG(seed + 1)),
        "redrawn": sim.RandomDistribution("normal_clipped", (0.0, 1.0, 0.0, 0.5), rng=sim.NumpyRNG(seed + 2)),
        "one stream": sim.RandomDistribution("uniform", (0.0, 1.0), rng=rng),
        "distance": "0.1 + 0.01*d",
    }
    synapse = sim.StaticSynapse(weight=weights[weight], delay=1.5)
    return sim.Projection(pre, post, make(sim, rng), synapse, receptor_type="excitatory")


@pytest.mark.one_of(8)
@pytest.mark.parametrize("name", CONNECTORS)
@settings(max_examples=25, deadline=None)
@given(
    n_pre=st.integers(4, 9), n_post=st.integers(4, 9), seed=st.integers(0, 2**31 - 9),
    weight=st.sampled_from(["number", "distribution", "redrawn", "one stream", "distance"]),
)  # fmt: skip
def test_the_synapses_are_those_of_pynn(name: str, n_pre: int, n_post: int, seed: int, weight: str) -> None:
    if name in ONLY_SQUARE:
        n_pre = n_post = 8
    if name == "list of pairs" and weight == "distance":
        return  # PyNN takes the place in the list for a distance
    drawn = [
        synapses(sim, n_pre, n_post, CONNECTORS[name], weight, seed).get(["weight", "delay"], "list")
        for sim in (pyNN.mock, builder())
    ]
    assert sorted(drawn[0]) == sorted(drawn[1])


def test_a_weight_that_depends_on_distance_does_so_in_a_list_of_pairs() -> None:
    projection = synapses(builder(), 4, 5, CONNECTORS["list of pairs"], "distance", 0)
    assert sorted(projection.get("weight", "list")) == [(0, 1, 0.11), (1, 0, 0.11), (2, 1, 0.11)]
    far = synapses(builder(), 4, 5, lambda sim, _: sim.FromListConnector([(0, 4), (3, 1)]), "distance", 0)
    assert sorted(far.get("weight", "list")) == [(0, 4, pytest.approx(0.14)), (3, 1, pytest.approx(0.12))]


@settings(max_examples=25, deadline=None)
@given(
    sizes=st.tuples(st.integers(1, 40), st.integers(1, 5000)),
    seed=st.integers(0, 2**31),
    n=st.integers(0, 50),
)  # fmt: skip
def test_pairs_are_those_of_the_loop_and_leave_the_generator_where_it_does(
    sizes: tuple[int, int], seed: int, n: int
) -> None:
    fast, slow = pyNN.mock.NumpyRNG(seed), pyNN.mock.NumpyRNG(seed)
    looped = [
        (slow.next(1, "uniform_int", {"low": 0, "high": sizes[0]})[0], slow.choice(np.arange(sizes[1])))
        for _ in range(n)
    ]
    assert list(zip(*random_pairs(fast, *sizes, n), strict=True)) == looped
    assert fast.randint(2**31) == slow.randint(2**31)


@pytest.mark.parametrize("name", sorted({*CONNECTORS} - {"list", "list of pairs"} - ONLY_SQUARE))
def test_a_single_presynaptic_cell_connects_too(name: str) -> None:
    projection = synapses(builder(), 1, 3, CONNECTORS[name], "number", 1)
    assert set(projection.pre_index) <= {0}
    assert set(projection.post_index) <= {0, 1, 2}
    if name in ("all", "all others", "out of each"):
        assert projection.post_index.tolist() == [0, 1, 2]
    if name == "one to one":
        assert projection.post_index.tolist() == [0]


def network_of(connector: Make, n: int = 20, seed: int = 0) -> Network:
    sim = builder(seed)
    cells = sim.Population(n, sim.IF_cond_exp(), label="cells")
    sim.Projection(cells, cells, connector(sim, None), sim.StaticSynapse(weight=0.1), label="wiring")
    network: Network = sim.network()
    return network


@pytest.mark.parametrize(
    "connector",
    [
        lambda sim, rng: sim.FixedTotalNumberConnector(200, allow_self_connections=False),
        lambda sim, rng: sim.SmallWorldConnector(4, 0.5, allow_self_connections=False),
        lambda sim, rng: sim.FixedProbabilityConnector(0.9, allow_self_connections=False),
        lambda sim, rng: sim.FixedNumberPostConnector(50, False, with_replacement=True),
        lambda sim, rng: sim.FixedNumberPreConnector(50, False, with_replacement=True),
    ],
)
def test_no_cell_connects_to_itself_if_it_may_not(connector: Make) -> None:
    (wiring,) = network_of(connector).projections
    assert wiring.size > 0
    assert not (wiring.pre_index == wiring.post_index).any()


FIXED_NUMBERS = ["FixedNumberPreConnector", "FixedNumberPostConnector"]


@pytest.mark.parametrize("name", [*FIXED_NUMBERS, "FixedTotalNumberConnector", "AllToAllConnector"])
def test_no_cell_connects_to_itself_in_another_view(name: str) -> None:
    sim = builder()
    cells = sim.Population(6, sim.IF_cond_exp())
    number = [] if name == "AllToAllConnector" else [3]
    connector = getattr(sim, name)(*number, allow_self_connections=False)
    projection = sim.Projection(cells[1:5], cells[2:6], connector, sim.StaticSynapse(weight=0.1))
    assert len(projection) > 2
    assert not (projection.pre_index == projection.post_index + 1).any()


@pytest.mark.parametrize("name", [*FIXED_NUMBERS, "FixedTotalNumberConnector"])
def test_a_single_cell_cannot_avoid_itself(name: str, golden: Golden) -> None:
    with golden.raises(NetworkError):
        network_of(lambda sim, rng: getattr(sim, name)(1, allow_self_connections=False), n=1)


@pytest.mark.parametrize("name", FIXED_NUMBERS)
def test_a_cell_may_have_no_partner(name: str) -> None:
    (wiring,) = network_of(lambda sim, rng: getattr(sim, name)(0)).projections
    assert wiring.size == 0
    (wiring,) = network_of(
        lambda sim, rng: getattr(sim, name)(sim.RandomDistribution("uniform_int", (0, 3)))
    ).projections
    ends = wiring.post_index if "Pre" in name else wiring.pre_index
    assert sorted(set(np.bincount(ends, minlength=20))) == [0, 1, 2]


def test_an_assembly_knows_its_cells_in_another_assembly() -> None:
    sim = builder()
    a, b = sim.Population(6, sim.IF_cond_exp(), label="a"), sim.Population(5, sim.IF_cond_exp(), label="b")
    connector = sim.AllToAllConnector(allow_self_connections=False)
    projection = sim.Projection(a + b, b + a[2:4], connector, sim.StaticSynapse(weight=0.1))
    assert len(projection) == 11 * 7 - 7


class Ring(MapConnector):  # type: ignore[misc]
    """A connector of a user, who names no parameters and does not call the constructor of the base."""

    def __init__(self, step: int) -> None:
        self.step = step

    def connect(self, projection: Any) -> None:
        n, m = projection.pre.size, projection.post.size
        self._connect_with_map(projection, LazyArray(lambda i, j: (j - i) % m == self.step, shape=(n, m)))


@pytest.mark.parametrize("named", [False, True])
def test_a_connector_of_a_user_connects_and_is_described_with_the_parameters_that_it_names(
    named: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if named:
        monkeypatch.setattr(Ring, "parameter_names", ("step",), raising=False)
    (ring,) = network_of(lambda sim, rng: Ring(2)).projections
    order = np.argsort(ring.pre_index)
    assert ring.pre_index[order].tolist() == list(range(20))
    assert ring.post_index[order].tolist() == [(cell + 2) % 20 for cell in range(20)]
    assert ring.origin is not None
    assert (ring.origin.connector, ring.origin.parameters) == ("Ring", {"step": 2} if named else {})


def test_progress_is_reported_for_an_assembly_too() -> None:
    sim = builder()
    a, b = sim.Population(2, sim.IF_cond_exp()), sim.Population(3, sim.IF_cond_exp())
    shares: list[float] = []
    everywhere = sim.AllToAllConnector(callback=shares.append)
    assert sim.Projection(a, a + b, everywhere, sim.StaticSynapse()).size() == 10
    assert shares == [k / 5 for k in range(5)]


def test_a_small_world_without_rewiring_is_a_lattice() -> None:
    (wiring,) = network_of(lambda sim, rng: sim.SmallWorldConnector(2, 0.0)).projections
    assert (abs(wiring.pre_index - wiring.post_index) < 2).all()
    assert wiring.size == 20 + 2 * 19


def test_rewiring_a_small_world_keeps_its_number_of_synapses_and_makes_some_long() -> None:
    (wiring,) = network_of(lambda sim, rng: sim.SmallWorldConnector(2, 0.5)).projections
    far = abs(wiring.pre_index - wiring.post_index) >= 2
    assert wiring.size == 20 + 2 * 19
    assert 5 <= far.sum() <= 50


def test_a_small_world_can_limit_how_many_synapses_leave_each_cell() -> None:
    (wiring,) = network_of(lambda sim, rng: sim.SmallWorldConnector(5, 0.3, n_connections=4)).projections
    assert (np.bincount(wiring.pre_index) == 4).all()


def test_a_clone_connects_the_same_pairs_with_weights_of_its_own(golden: Golden) -> None:
    sim = builder()
    a, b = sim.Population(6, sim.IF_cond_exp()), sim.Population(5, sim.IF_cond_exp())
    original = sim.Projection(a, b, sim.FixedProbabilityConnector(0.5), sim.StaticSynapse(weight=0.1))
    clone = sim.Projection(a, b, sim.CloneConnector(original), sim.StaticSynapse(weight=0.2))
    assert clone.get("delay", "list") == original.get("delay", "list")
    assert set(clone.get("weight", "list", with_address=False)) == {0.2}
    with golden.raises(NetworkError):
        sim.Projection(b, a, sim.CloneConnector(original), sim.StaticSynapse(weight=0.2))


def test_synapses_come_from_a_file_with_named_columns(tmp_path: Path) -> None:
    path = tmp_path / "synapses.txt"
    path.write_text('# columns = ["i", "j", "weight", "U"]\n0 1 0.5 0.2\n2 0 0.25 0.3\n')
    sim = builder()
    cells = sim.Population(3, sim.IF_cond_exp())
    synapse = sim.TsodyksMarkramSynapse(weight=9.0, delay=0.7)
    projection = sim.Projection(cells, cells, sim.FromFileConnector(str(path)), synapse)
    assert projection.get(["weight", "U", "delay"], "list") == [(2, 0, 0.25, 0.3, 0.7), (0, 1, 0.5, 0.2, 0.7)]


@pytest.mark.parametrize(
    ("rows", "names", "says"),
    [
        ([(99, 0)], None, "presynaptic index 99 in its list of synapses; "),
        ([(-1, 0)], None, "presynaptic index -1 in"),
        ([(0.5, 0)], None, "presynaptic index 0.5 in"),
        ([(0, 1, 0.1)], ("weigth",), "its synapses have no 'weigth'; did you mean 'weight'"),
        ([(0, 1, 0.1, -2.0)], None, r"delay of synapse 0 \(0 -> 1\) is -2"),
        ([(0, 1, -0.1, 2.0)], None, r"weight of synapse 0 \(0 -> 1\) is -0.1"),
    ],
)
def test_a_wrong_row_of_a_list_is_named(rows: Any, names: Any, says: str) -> None:
    with pytest.raises(NetworkError, match=f"projection 'wiring': {says}"):
        network_of(lambda sim, rng: sim.FromListConnector(rows, names))


def test_rows_with_a_target_outside_the_population_are_left_out_with_a_warning() -> None:
    """PyNN 0.13 leaves them out without a word, targets below 0 too."""
    sim = builder()
    cells = sim.Population(3, sim.IF_cond_exp(), label="cells")
    rows = [(0, 3, 0.1, 1.0), (2, 1, 0.2, 1.0), (1, -1, 0.3, 1.0)]
    projection = sim.Projection(cells, cells, sim.FromListConnector(rows), label="wiring")
    assert projection.get(["weight", "delay"], "list") == [(2, 1, 0.2, 1.0)]
    text = (
        "projection 'wiring': 2 rows of its list of synapses are left out, as in PyNN: 'cells' has no cell 3"
    )
    assert [text in remark for remark in sim.state.remarks] == [True]


@settings(max_examples=30, deadline=None)
@given(n_pre=st.integers(1, 9), n_post=st.integers(1, 9), share=st.floats(0, 1), itself=st.booleans())
def test_a_total_without_replacement_has_different_pairs(
    n_pre: int, n_post: int, share: float, itself: bool
) -> None:
    sim = builder()
    cells = sim.Population(max(n_pre, n_post), sim.IF_cond_exp())
    ends = sim.PopulationView(cells, range(n_pre)), sim.PopulationView(cells, tuple(range(n_post)))
    possible = n_pre * n_post - (0 if itself else min(n_pre, n_post))
    n = round(share * possible)
    wiring = sim.Projection(*ends, sim.FixedTotalNumberConnector(n, itself, with_replacement=False))
    pairs = {(i, j) for i, j, _ in wiring.get("weight", "list")}
    assert len(pairs) == len(wiring) == n
    assert itself or all(i != j for i, j in pairs)
    with pytest.raises(NetworkError, match=f"there are {possible} pairs of cells"):
        sim.Projection(*ends, sim.FixedTotalNumberConnector(possible + 1, itself, with_replacement=False))


@pytest.mark.parametrize("kind", [bool, int, float, list])
@pytest.mark.parametrize("matrix", [[[0, 1], [1, 1]], [[0, 1]], [[1], [0]]])
def test_numbers_of_an_array_are_truth_values(kind: type, matrix: list[list[int]], golden: Golden) -> None:
    sim = builder()
    pre, post = (sim.Population(n, sim.IF_cond_exp()) for n in np.shape(matrix))
    array = matrix if kind is list else np.array(matrix, kind)
    wiring = sim.Projection(pre, post, sim.ArrayConnector(array), sim.StaticSynapse(weight=1.0))
    pairs = [[i, j] for i, j, _ in sorted(wiring.get("weight", "list"))]
    assert pairs == np.argwhere(np.array(matrix) == 1).tolist()  # as sPyNNaker tests each element
    with golden.raises(NetworkError):
        sim.Projection(pre, sim.Population(5, sim.IF_cond_exp()), sim.ArrayConnector(array))


def test_building_a_large_projection_stores_one_weight_and_small_indices() -> None:
    (wiring,) = network_of(lambda sim, rng: sim.FixedNumberPreConnector(300), n=1000).projections
    assert wiring.size == 300_000
    assert (wiring.pre_index.dtype, wiring.post_index.dtype) == (np.int32, np.int32)
    assert (wiring.weight.strides, wiring.delay_ms.strides) == ((0,), (0,))
