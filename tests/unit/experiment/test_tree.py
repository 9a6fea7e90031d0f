"""Trees: merging, overriding, and never losing the place."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.section import Place, Tree, tree_of
from nrp_core.paths import TextFrom

BASE, OVER = Place(Path("/base/a.yaml"), 1, 1), Place(Path("/over/b.yaml"), 2, 2)


def grown(data: Any, place: Place) -> Tree:
    """Build a tree, all of whose parts stand at one place."""
    if isinstance(data, dict):
        return Tree({key: grown(value, place) for key, value in data.items()}, place)
    if isinstance(data, list):
        return Tree([grown(value, place) for value in data], place)
    return Tree(data, place)


def merged(base: Any, over: Any) -> Any:
    return grown(base, BASE).merged(grown(over, OVER)).plain()


leaves = st.integers(0, 3) | st.sampled_from(["", "x"]) | st.lists(st.integers(0, 3), max_size=2)
data = st.recursive(
    st.dictionaries(st.sampled_from("abc"), leaves, max_size=3),
    lambda inner: st.dictionaries(st.sampled_from("abc"), inner | leaves, max_size=3),
    max_leaves=8,
)


@given(data)
def test_merging_with_nothing_changes_nothing(tree: Any) -> None:
    assert merged(tree, {}) == tree == merged({}, tree)


@given(data)
def test_merging_with_itself_changes_nothing(tree: Any) -> None:
    assert merged(tree, tree) == tree


@given(data, data)
def test_merging_the_same_values_again_changes_nothing(a: Any, b: Any) -> None:
    together = merged(a, b)
    assert merged(together, b) == together


def test_null_removes_and_lists_are_replaced_whole() -> None:
    assert merged({"a": 1, "b": [1, 2]}, {"a": None, "b": [3]}) == {"b": [3]}


def test_after_merging_each_value_still_knows_its_file() -> None:
    tree = grown({"a": {"b": "x", "c": "y"}}, BASE).merged(grown({"a": {"c": "z"}}, OVER))
    assert tree.nearest(("a", "b"))[0].place == BASE
    assert tree.nearest(("a", "c"))[0].place == OVER
    texts = tree.plain()["a"]
    assert (texts["b"].folder, texts["c"].folder) == (Path("/base"), Path("/over"))


def test_nearest_skips_keys_that_the_data_lack() -> None:
    tree = grown({"a": [{"b": 1}]}, BASE)
    reached, keys = tree.nearest(("a", "union tag", 0, "b", "int"))
    assert reached.value == 1
    assert keys == ("a", 0, "b")


def test_an_override_creates_missing_mappings() -> None:
    tree = grown({"a": None}, BASE).overridden(["a", "b", "c"], grown(1, OVER))
    assert tree.plain() == {"a": {"b": {"c": 1}}}


def test_an_override_reaches_into_lists() -> None:
    tree = grown({"a": [1, 2]}, BASE).overridden(["a", "1"], grown(3, OVER))
    assert tree.plain() == {"a": [1, 3]}


def test_an_override_of_null_removes() -> None:
    assert grown({"a": {"b": 1}}, BASE).overridden(["a", "b"], grown(None, OVER)).plain() == {"a": {}}


@pytest.mark.parametrize(
    ("keys", "what"),
    [
        (["a", "2"], "'2'.*0, 1"),
        (["a", "x"], "no item 'x'"),
        (["b", "c"], ""),
        (["c", "2"], "'2'"),
    ],
)
def test_an_override_that_leads_nowhere_says_so(keys: list[str], what: str, golden: Golden) -> None:
    with golden.raises(ExperimentError, match=what):
        grown({"a": [1, 2], "b": 1}, BASE).overridden(keys, grown(3, OVER))


def test_a_text_remembers_the_folder_of_its_file() -> None:
    text = grown("scene.sdf", BASE).plain()
    assert isinstance(text, TextFrom)
    assert text == "scene.sdf"
    assert text.folder == Path("/base")


def test_plain_data_may_be_arrays_and_ranges() -> None:
    given_data = {"a": np.linspace(0.0, 1.0, 3), "b": range(1, 3), "c": np.float64(2.0), "d": "text"}
    assert tree_of(given_data).plain() == {"a": [0.0, 0.5, 1.0], "b": [1, 2], "c": 2.0, "d": "text"}
