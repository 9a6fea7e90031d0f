"""Random streams are known by name."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.seeds import Seeds

names = st.text(min_size=1, max_size=20)


@given(st.integers(), names)
def test_equal_names_give_equal_numbers(root: int, name: str) -> None:
    first, second = Seeds(root).stream(name), Seeds(root).stream(name)
    assert (first.random(8) == second.random(8)).all()


@given(st.integers(), st.lists(names, min_size=2, max_size=2, unique=True))
def test_other_names_and_other_roots_give_other_numbers(root: int, two: list[str]) -> None:
    a, b = (Seeds(root).stream(name).random(4) for name in two)
    assert (a != b).any()
    assert (Seeds(root + 1).stream(two[0]).random(4) != a).any()


def test_a_child_is_a_prefix_of_names() -> None:
    assert Seeds(1).child("brain").child("device").path == "brain/device"
    a = Seeds(1).child("brain").stream("device/eye").random(3)
    b = Seeds(1).child("brain").child("device").stream("eye").random(3)
    assert (a == b).all()


def test_the_streams_are_the_same_in_every_release() -> None:
    assert Seeds(7).integer("engine") == 1105250236
    expected = [0.6789455798477613, 0.50873309013453]
    np.testing.assert_array_equal(Seeds(7).stream("brain/device/eye").random(2), expected)


def test_the_global_generator_is_not_touched() -> None:
    before = np.random.get_state()[1].copy()  # type: ignore[index,union-attr] # noqa: NPY002
    Seeds(3).stream("x").random(100)
    assert (np.random.get_state()[1] == before).all()  # type: ignore[index] # noqa: NPY002
