"""Networks are checked when they are made, and known by their digest."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_brain_event import EventBackend
from nrp_formats import save_nir

from nrp_core.dsl.testing import MockBrain
from nrp_core.errors import ArgumentError, NetworkError, NeuronSelectionError
from nrp_core.network.cells import CELLS
from nrp_core.network.data import Network, Population, Projection
from nrp_core.network.files.network_file import read_network, save_network


def population(label: str, size: int, cell_type: str = "IF_curr_exp", **values: float) -> Population:
    parameters = values if cell_type.startswith("SpikeSource") else {"tau_m": 20.0, **values}
    return Population(label, size, cell_type, {name: np.full(size, v) for name, v in parameters.items()})


def projection(**changes: Any) -> Projection:
    base = Projection(
        "a to b", "a", "b", "excitatory",
        np.array([0, 1], np.int32), np.array([2, 0], np.int32), np.array([0.5, 0.25]), np.array([1.0, 2.0]),
    )  # fmt: skip
    return replace(base, **changes)


def network(*projections: Projection, **kwargs: Any) -> Network:
    return Network({"a": population("a", 2), "b": population("b", 3)}, projections, **kwargs)


def test_global_ids_lay_the_populations_one_after_another() -> None:
    net = network(views={"ends": np.array([0, 4])})
    assert net.size == 5
    assert net.neurons("b").tolist() == [2, 3, 4]
    assert net.neurons("ends").tolist() == [0, 4]
    assert [net.label_of(i) for i in range(5)] == [("a", 0), ("a", 1), ("b", 0), ("b", 1), ("b", 2)]


def test_a_view_may_carry_the_name_of_a_population_and_hides_it() -> None:
    net = network(views={"b": np.array([2])})
    assert net.neurons("b").tolist() == [2]
    assert net.ids_of("b").tolist() == [2, 3, 4]


def test_an_unknown_name_gets_the_nearest(golden: Golden) -> None:
    with golden.raises(NeuronSelectionError, match="'sensor'.*'sensors'"):
        network(views={"sensors": np.array([0])}).neurons("sensor")


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"pre": "c"}, "'c'"),
        ({"pre_index": np.array([0, 2], np.int32)}, "'a'"),
        ({"post_index": np.array([-1, 0], np.int32)}, "'b'"),
        ({"receptor": "excitatry"}, "'excitatory'"),
        ({"weight": np.array([0.5])}, r"\(1,\).*\(2,\)"),
        ({"weight": np.array([0.5, np.nan])}, r"1 \(1 -> 0\)"),
        ({"delay_ms": np.array([1.0, -2.0])}, r"1 \(1 -> 0\).*-2"),
        ({"post": "s", "post_index": np.array([0, 0], np.int32)}, ""),
        ({"post": "g", "weight": np.array([0.5, -0.1])}, "-0.1"),
    ],
)
def test_inconsistent_networks_are_refused_by_name(
    changes: dict[str, Any], says: str, golden: Golden
) -> None:
    populations = {
        "a": population("a", 2),
        "b": population("b", 3),
        "s": population("s", 1, "SpikeSourcePoisson"),
        "g": population("g", 3, "IF_cond_exp"),
    }
    with golden.raises(NetworkError, match=says):
        Network(populations, (projection(**changes),))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_position_that_is_not_finite_names_its_cell(value: float) -> None:
    positions = np.array([[1.0, 2.0, 3.0], [4.0, value, 0.0]])
    says = rf"population 'x': the position of cell 1 is \(4, {value:g}, 0\); it must be finite"
    with pytest.raises(NetworkError, match=says):
        replace(population("x", 2), positions_um=positions)


def test_a_parameter_that_is_not_a_number_names_population_parameter_and_cell(golden: Golden) -> None:
    with golden.raises(NetworkError, match="'x'"):
        Population("x", 2, "IF_curr_exp", {"cm": np.array([1.0, np.nan])})


def test_equal_networks_have_equal_digests_and_any_change_shows() -> None:
    base = network(projection())
    assert base.digest == network(projection()).digest
    others = [
        network(),
        network(projection(weight=np.array([0.5, 0.26]))),
        network(projection(delay_ms=np.array([1.0, 2.5]))),
        network(projection(post_index=np.array([2, 1], np.int32))),
        network(projection(receptor="inhibitory")),
        network(projection(), views={"v": np.array([1])}),
        Network({"a": population("a", 2, cm=2.0), "b": population("b", 3)}, (projection(),)),
    ]
    assert len({base.digest, *(other.digest for other in others)}) == len(others) + 1


def test_a_constant_weight_takes_no_memory_and_is_hashed_without_being_spread_out() -> None:
    n = 10**8
    constant = np.broadcast_to(np.float64(0.5), (n,))
    index = np.broadcast_to(np.int32(0), (n,))
    net = network(projection(pre_index=index, post_index=index, weight=constant, delay_ms=constant))
    assert len(net.digest) == 32


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: replace(population("a", 2), label=None), ""),
        (lambda: replace(population("a", 2), size=-1), "'a'.*-1"),
        (lambda: replace(population("a", 2), size=2.0), "'a'.*2.0"),
        (
            lambda: replace(population("a", 2), parameters={"cm": 1.0}),
            "'cm'.*1.0",
        ),
        (
            lambda: replace(population("a", 1), parameters={"cm": np.array(["x"])}),
            "",
        ),
        (lambda: replace(population("a", 1), positions_um=[[0.0, 0.0]]), r"shape \(1, 2\), not \(1, 3\)"),
        (lambda: projection(pre_index=np.array([0.7, 1.0])), r"\[0.7 1. \]"),
        (lambda: projection(pre_index=np.array([0])), "pre_index.*1.*post_index 2"),
        (lambda: network(timestep_ms=float("nan")), ""),
        (lambda: network(timestep_ms="1"), "'1'"),
        (lambda: Network({"a": 3}), ""),  # type: ignore[dict-item]
        (lambda: network("a to b"), "'a to b'"),  # type: ignore[arg-type]
        (lambda: Network({}, 7), ""),  # type: ignore[arg-type]
        (lambda: network(projection(), projection()), "'a to b'"),
        (lambda: network(projection(label=3)), ""),
        (lambda: projection(weight=0.5), ""),
        (lambda: projection(delay_ms="1 ms"), "delay_ms"),
        (lambda: projection(pre_index="ab"), r"\['ab'\]"),
        (lambda: projection(pre_index=np.array([True, False])), r"\[ True False\]"),
        (
            lambda: network(views={"v": "a"}),
            "'v'.*'a'",
        ),  # type: ignore[dict-item]
        (lambda: network(views={"v": np.array([0.5])}), "'v'"),
        (
            lambda: network(projection(synapse_parameters={"U": np.ones(2)})),
            "'a to b'.*'U'",
        ),
        (
            lambda: Network({"c": population("c", 1, tau_n=3.0)}),
            r"'c' \(IF_curr_exp\).*'tau_n'.*'tau_m'",
        ),
        (
            lambda: Network({"c": replace(population("c", 1), initial_values={"V": np.zeros(1)})}),
            r"'c' \(IF_curr_exp\).*'V'.*'v'",
        ),
    ],
)
def test_impossible_values_are_refused_where_they_are_given(make: Any, words: str, golden: Golden) -> None:
    with golden.raises((NetworkError, ArgumentError), match=words):
        make()


def test_views_may_be_lists_and_cells_of_other_simulators_have_names_of_their_own() -> None:
    other = Population("x", 2, "MyCell", {"gain": np.ones(2)}, {"memory": np.zeros(2)})
    made = Network({"x": other}, views={"all": [0, 1], "none": []})  # type: ignore[dict-item]
    assert made.neurons("all").tolist() == [0, 1]
    assert made.neurons("none").dtype == np.int64
    synapses = Population("s", 1, "IF_cond_exp", {}, {"v": np.zeros(1), "gsyn_exc": np.zeros(1)})
    assert Network({"s": synapses}).size == 1  # a description needs no parameters


@pytest.mark.parametrize("missing", ["tau_m", "i_offset"])
def test_a_simulator_names_the_parameter_that_a_network_lacks(missing: str, golden: Golden) -> None:
    cell = CELLS["IF_curr_exp"].parameters
    values = {name: np.full(2, one.default) for name, one in cell.items() if name != missing}
    made = Network({"a": Population("a", 2, "IF_curr_exp", values)})
    with golden.raises(NetworkError, match=rf"'a' \(IF_curr_exp\).*'{missing}'"):
        EventBackend().open(made, seed=0, options=EventBackend.options())
    whole = {**values, missing: np.full(2, cell[missing].default)}
    complete = Network({"a": Population("a", 2, "IF_curr_exp", whole)})
    with EventBackend().open(complete, seed=0, options=EventBackend.options()) as brain:
        assert brain.network.size == 2
    with MockBrain(made) as mock:
        assert mock.network is made


def test_only_a_network_is_saved(tmp_path: Path, golden: Golden) -> None:
    for save in (save_network, save_nir):
        with golden.raises(ArgumentError):
            save(None, tmp_path / "none.net")  # type: ignore[arg-type]
    for suffix in (".py", ".nir", ".json"):
        with golden.raises(NetworkError):
            save_network(network(), tmp_path / f"net{suffix}")
    assert not list(tmp_path.iterdir())


def test_populations_to_be_picked_are_given_by_name(tmp_path: Path, golden: Golden) -> None:
    save_network(network(), tmp_path / "net.nrpnet")
    assert read_network(tmp_path / "net.nrpnet", populations={"first": "0:2"}).views["first"].tolist() == [
        0,
        1,
    ]
    with golden.raises(ArgumentError, match=r"\['first'\]"):
        read_network(tmp_path / "net.nrpnet", populations=["first"])  # type: ignore[arg-type]
