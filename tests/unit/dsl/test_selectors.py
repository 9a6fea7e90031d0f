"""Selectors choose what NumPy indexing would choose, once there is a brain."""

from __future__ import annotations

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core._support.arrays import IntArray
from nrp_core.dsl.selection import (
    BrainRoot,
    Selection,
    brain,
    chain_neurons,
    evaluate,
    map_neurons,
    nrange,
    resolve,
    select,
    select_projection,
)
from nrp_core.errors import NetworkError, NeuronSelectionError
from nrp_core.network.data import Network, Population, Projection

SIZE = 8
FIRST = 3
ROOT = BrainRoot(
    Network(
        {"other": Population("other", FIRST, "Cell", {}), "sensors": Population("sensors", SIZE, "Cell", {})},
        views={"eyes": np.array([9, 4, 5]), "LAL(PS)-L": np.array([5, 6])},
    )
)

indices = st.integers(-SIZE, SIZE - 1)
lists = st.lists(indices, min_size=1, max_size=12)
slices = st.slices(SIZE)


def ids(selector: object) -> list[int]:
    selected = select(selector, ROOT)
    assert isinstance(selected, Selection)
    return [int(neuron) for neuron in selected.ids]


def group(selector: object) -> list[list[int]]:
    selected = select(selector, ROOT)
    assert isinstance(selected, list)
    return [selection.ids.tolist() for selection in selected]


def expected(index: object) -> IntArray:
    return np.atleast_1d(np.arange(FIRST, FIRST + SIZE)[index])  # type: ignore[call-overload]


@given(st.one_of(indices, lists, st.lists(st.booleans(), min_size=SIZE, max_size=SIZE), slices))
def test_an_index_has_its_meaning_of_numpy(index: object) -> None:
    wanted = expected(index)
    if len(wanted):
        assert ids(brain.sensors[index]) == wanted.tolist()
    else:
        with pytest.raises(NeuronSelectionError, match="selects no neuron"):
            ids(brain.sensors[index])


@given(st.lists(st.one_of(indices, slices, lists), min_size=1, max_size=4).map(tuple))
def test_a_tuple_joins_what_its_items_choose(index: tuple[object, ...]) -> None:
    parts = [expected(item) for item in index]
    if any(len(part) for part in parts):
        assert ids(brain.sensors[index]) == np.concatenate(parts).tolist()


@given(first=slices, second=slices)
def test_an_index_of_an_index_is_relative_to_what_was_chosen(first: slice, second: slice) -> None:
    wanted = np.arange(FIRST, FIRST + SIZE)[first][second]
    if len(wanted):
        assert ids(brain.sensors[first][second]) == wanted.tolist()


def test_a_population_or_view_alone_is_all_of_it_in_its_order() -> None:
    assert ids(brain.other) == [0, 1, 2]
    assert ids(brain.eyes) == [9, 4, 5]


def test_a_group_is_chosen_by_its_name_whatever_it_is(golden: Golden) -> None:
    assert ids(brain.group["eyes"]) == ids(brain.eyes)
    assert ids(brain.group["LAL(PS)-L"][1] + brain.group["other"]) == [6, 0, 1, 2]
    assert ids(resolve(lambda one: one.group["eyes"][0])) == [9]
    assert group(map_neurons(["eyes", "other"], lambda name: brain.group[name])) == [[9, 4, 5], [0, 1, 2]]
    with golden.raises(NeuronSelectionError, match="'eys'.*'eyes'"):
        ids(brain.group["eys"])
    with golden.raises(NeuronSelectionError):
        ids(brain.group[3])
    with golden.raises(NeuronSelectionError, match=r"nrp\.brain\.group\['eyes'\]"):
        ids(brain["eyes"][0])
    with golden.raises(NeuronSelectionError):
        ids(brain.group)


def test_a_population_that_is_called_group_stays_one() -> None:
    root = BrainRoot(Network({"group": Population("group", SIZE, "Cell", {})}))
    found = select(brain.group[2:4], root)
    assert isinstance(found, Selection)
    assert found.ids.tolist() == [2, 3]


def test_numpy_integers_and_arrays_choose_too() -> None:
    assert ids(brain.sensors[np.int64(2)]) == [5]
    assert ids(brain.sensors[np.array([0, 2])]) == [3, 5]
    assert ids(brain.sensors[range(0, 4, 2)]) == [3, 5]


def test_populations_add_up() -> None:
    assert ids(brain.other[0] + brain.sensors[1]) == [0, 4]
    assert ids(sum([brain.other[0], brain.sensors[1], brain.sensors[0]])) == [0, 4, 3]
    assert ids(resolve(lambda root: sum([root.other[0], root.sensors[1]]))) == [0, 4]


def test_an_index_may_depend_on_the_brain() -> None:
    assert ids(brain.sensors[brain.sensors.size - 1]) == [10]
    assert ids(brain.sensors[: brain.other.size]) == [3, 4, 5]
    assert ids(brain.sensors[[brain.other.size, 0]]) == [6, 3]
    assert ids(brain.sensors[brain.sensors.size // 2]) == [7]
    assert ids(brain.sensors[2 * brain.other.size - 1]) == [8]
    assert ids(brain.sensors[10 - brain.sensors.size]) == [5]


@pytest.mark.parametrize(
    "source", [range(3), 3, [0, 1, 2], nrange(0, 3), nrange(0, brain.other.size, None), brain.other.size]
)
def test_map_neurons_gives_one_selection_for_each_item(source: object) -> None:
    assert group(map_neurons(source, lambda i: brain.sensors[i])) == [[3], [4], [5]]


def test_map_neurons_and_chain_neurons_flatten_one_level() -> None:
    pairs = map_neurons(2, lambda i: map_neurons(2, lambda j: brain.sensors[2 * i + j]))
    assert group(pairs) == [[3], [4], [5], [6]]
    chained = chain_neurons(brain.other, map_neurons(2, lambda i: brain.sensors[i : i + 2]))
    assert group(chained) == [[0, 1, 2], [3, 4], [4, 5]]


def test_resolve_gives_what_a_function_of_the_brain_returns(golden: Golden) -> None:
    assert ids(resolve(lambda root: root.sensors[0])) == [3]
    assert ids(resolve(lambda root: brain.other)) == [0, 1, 2]
    assert group(resolve(lambda root: [root.sensors[i] for i in (1, 2)])) == [[4], [5]]
    with golden.raises(TypeError):
        resolve(3)  # type: ignore[arg-type]


def test_selectors_inside_values_are_replaced() -> None:
    assert evaluate([brain.sensors.size, (1, slice(brain.other.size))], ROOT) == [SIZE, (1, slice(FIRST))]


@pytest.mark.parametrize(
    ("selector", "message"),
    [
        (brain.sensor, "'sensors'"),
        (brain.sensors[8], "0..7; 8"),
        (brain.sensors[0, 9], ""),
        (brain.sensors["a"], "'a'"),
        (brain.sensors[True], "not True"),
        (brain.sensors[1.5], "not 1.5"),
        (brain.sensors[[]], ""),
        (brain.sensors.size, ""),
        (map_neurons(2, lambda i: 1 // 0), "ZeroDivisionError"),
        (map_neurons(0, lambda i: brain.sensors[i]), ""),
        ([0, 1], "not neurons"),
        (brain, "not neurons"),
    ],
)
def test_an_empty_selection_is_refused(selector: object, message: str, golden: Golden) -> None:
    with golden.raises(NeuronSelectionError, match=message):
        select(selector, ROOT)


def test_selectors_are_shown_as_they_are_written() -> None:
    assert repr(brain.actors[0]) == "brain.actors[0]"
    assert repr(brain.sensors[0, 2:4]) == "brain.sensors[0, 2:4]"
    assert repr(brain.sensors[slice(0, 3, 2)]) == "brain.sensors[0:3:2]"
    assert repr(brain.a + brain.b[1]) == "(brain.a + brain.b[1])"
    assert repr(nrange(0, brain.a.size)) == "nrange(0, brain.a.size, 1)"
    assert repr(map_neurons(2, lambda i: brain.a[i])) == "map_neurons(2, <lambda>)"
    assert repr(chain_neurons(brain.a, brain.b)) == "chain_neurons(brain.a, brain.b)"


def test_a_selector_does_not_pretend_to_be_a_sequence(golden: Golden) -> None:
    with golden.raises(TypeError):
        list(brain.sensors)  # type: ignore[call-overload]
    with pytest.raises(TypeError):
        1 in brain.sensors  # type: ignore[misc]  # noqa: B015
    with pytest.raises(TypeError):
        len(brain.sensors)  # type: ignore[arg-type]


def test_a_projection_is_selected_by_its_label(golden: Golden) -> None:
    ends = np.arange(3)
    plain = Projection("a -> b", "a", "b", "excitatory", ends, ends, np.ones(3), np.ones(3))
    cells = {name: Population(name, 3, "IF_curr_exp", {}) for name in ("a", "b")}
    root = BrainRoot(Network(cells, (plain,)))
    assert select_projection(brain.projection("a -> b"), root) is plain
    assert repr(brain.projection("a -> b")) == "brain.projection('a -> b')"
    with pytest.raises(NetworkError, match=r"'a -> c'.*'a -> b'"):
        select_projection(brain.projection("a -> c"), root)
    with golden.raises(NeuronSelectionError):
        select_projection(brain.a, root)


def test_a_population_may_be_called_projection() -> None:
    root = BrainRoot(Network({"projection": Population("projection", 3, "Cell", {})}))
    selected = select(brain.projection[1:], root)
    assert isinstance(selected, Selection)
    assert selected.ids.tolist() == [1, 2]
