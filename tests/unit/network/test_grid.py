"""Points in time that lie a step apart."""

import numpy as np
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.errors import TimestepError
from nrp_core.network.grid import Grid

STEPS_NS = st.sampled_from([1_000, 100_000, 300_000, 1_000_000])


@given(st.floats(0, 1e7), STEPS_NS)
def test_a_time_goes_to_the_first_grid_point_that_is_not_before_it(t_ms, step_ns):
    grid = Grid(step_ns)
    point = grid.time_ms(grid.first_at(np.array([t_ms])))[0]
    assert -1e-5 * grid.step_ms < point - t_ms < (1 + 1e-5) * grid.step_ms


@given(st.integers(0, 10**9), STEPS_NS)
def test_a_point_is_its_own_first_point(number, step_ns):
    grid = Grid(step_ns)
    assert grid.first_at(grid.time_ms(np.array([number])))[0] == number
    assert grid.number_of(number * step_ns) == number


def test_delays_are_the_nearest_number_of_steps_and_at_least_one():
    assert Grid(100_000).delays(np.array([0.0, 0.04, 0.16, 1.0, 1.26])).tolist() == [1, 1, 2, 10, 13]


def test_a_time_between_two_points_is_refused_by_its_owner(golden: Golden):
    with golden.raises(TimestepError, match="NEST.*0.1.*0.25"):
        Grid(100_000, "NEST").number_of(250_000)
