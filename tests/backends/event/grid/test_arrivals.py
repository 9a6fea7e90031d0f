"""What arrives apart from the calendar stands in one order, however it came."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_brain_event.grid.arrivals import Arrivals

INPUT = st.tuples(
    st.integers(1, 3), st.integers(0, 2), st.integers(-1, 1), st.sampled_from([-0.5, 0.1, 0.25])
)


def joined(*parts: list[tuple[int, int, int, float]]) -> Arrivals:
    arrivals = Arrivals.none()
    for part in parts:
        steps = np.array([one[:3] for one in part], np.int64).reshape(len(part), 3).T.copy()
        arrivals = arrivals.joined(steps, np.array([one[3] for one in part], float))
    return arrivals


@given(st.lists(st.lists(INPUT, max_size=9), max_size=5))
def test_arrivals_ascend_by_step_place_synapse_and_weight(
    parts: list[list[tuple[int, int, int, float]]],
) -> None:
    found = joined(*parts)
    rows = zip(*found.inputs.tolist(), found.weights.tolist(), strict=True)
    assert list(rows) == sorted(one for part in parts for one in part)


@pytest.mark.parametrize("n", [0, 2, 3])
def test_those_that_have_been_used_are_dropped(n: int) -> None:
    rest = joined([(1, 0, -1, 0.1), (2, 0, -1, 0.2), (3, 0, -1, 0.3)]).after(n)
    assert rest.inputs[0].tolist() == [1, 2, 3][n:]
    assert rest.weights.tolist() == [0.1, 0.2, 0.3][n:]
