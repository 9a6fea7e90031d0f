"""What arrives apart from the calendar stands in one order, however it came."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_brain_event.grid.inputs import arrange, no_inputs, sort
from nrp_brain_event.grid.records import GridClock, Input
from nrp_brain_event.records import Array

INPUT = st.tuples(
    st.integers(1, 3), st.integers(0, 2), st.integers(-1, 1), st.sampled_from([-0.5, 0.1, 0.25])
)


def inputs(rows: list[tuple[int, int, int, float]]) -> Array:
    return np.array(rows, Input.dtype())


@given(st.lists(INPUT, max_size=40))
def test_inputs_ascend_by_step_place_synapse_and_weight(rows: list[tuple[int, int, int, float]]) -> None:
    found = inputs(rows)
    sort(found, len(found))
    assert found.tolist() == sorted(rows)


@given(st.lists(INPUT, max_size=9), st.integers(0, 9), st.lists(INPUT, max_size=5))
def test_new_inputs_take_their_place_among_those_that_have_not_been_used(
    before: list[tuple[int, int, int, float]], used: int, new: list[tuple[int, int, int, float]]
) -> None:
    used, before = min(used, len(before)), sorted(before)
    arrivals, clock = no_inputs(), np.zeros(1, GridClock.dtype())
    n = len(before) + len(new)
    arrivals[:n] = inputs([*before, *new])
    clock["n_arrivals"], clock["arrival"], clock["is_mixed"] = n, used, 1
    arrange(clock[0], no_inputs(), arrivals)
    assert clock["arrival"][0] == 0
    assert arrivals[: clock["n_arrivals"][0]].tolist() == sorted([*before[used:], *new])


@pytest.mark.parametrize("used", [0, 2])
def test_inputs_in_order_stay_where_they_are(used: int) -> None:
    arrivals, clock = no_inputs(), np.zeros(1, GridClock.dtype())
    arrivals[:3] = inputs([(1, 0, -1, 0.1), (2, 0, -1, 0.2), (3, 0, -1, 0.3)])
    clock["n_arrivals"], clock["arrival"] = 3, used
    arrange(clock[0], no_inputs(), arrivals)
    assert (clock["arrival"][0], clock["n_arrivals"][0]) == (used, 3)
