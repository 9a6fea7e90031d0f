"""Runs with other steps of the loop are compared with the finest; what is left of the way is estimated."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from nrp_lab.comparison.grid import RunGrid
from nrp_lab.comparison.judgement import Contrast, Estimate, Factor, JudgedPart
from nrp_lab.comparison.shipped_metrics import Distance
from nrp_lab.comparison.timesteps import Convergence, columns, convergence, differing

from nrp_core.errors import ExperimentError

STEPS = ("2 ms", "5 ms", "10 ms", "20 ms")
STEPS_MS = (2.0, 5.0, 10.0, 20.0)


def found(*values: float) -> Convergence:
    """Return the convergence of a measure with values at steps, the finest first."""
    contrasts = tuple(
        Contrast(Factor.TIMESTEP, STEPS[0], step, Estimate(value - values[0], 0.1, 4), 0.0, 1.0)
        for step, value in zip(STEPS[1:], values[1:], strict=True)
    )
    part = JudgedPart("husky", 0.1, True, 0.0, 0.1, True, 5, contrasts)
    judged = SimpleNamespace(metric=Distance(), parts=(part,))
    diff: Any = SimpleNamespace(grid=SimpleNamespace(timesteps=STEPS), judgements=[judged])
    (one,) = convergence(diff)
    assert differing(diff) == ([] if one.shrinks is None else [one])
    return one


@given(st.floats(-5.0, 5.0), st.floats(0.01, 10.0))
def test_an_error_that_is_proportional_to_the_step_is_extrapolated_exactly(true: float, slope: float) -> None:
    one = found(*(true + slope * step for step in STEPS_MS))
    assert one.shrinks is True
    assert one.left == pytest.approx(slope * 2.0)
    assert one.differences == pytest.approx([slope * 18.0, slope * 8.0, slope * 3.0])


def test_differences_that_do_not_shrink_give_no_estimate() -> None:
    one = found(1.0, 1.5, 1.2, 1.4)
    assert (one.shrinks, one.left) == (False, None)
    assert one.row[-2:] == ("no", "-")
    assert len(one.row) == len(columns(STEPS))


def test_equal_values_leave_an_error_of_0() -> None:
    one = found(1.0, 1.0, 1.0, 1.0)
    assert (one.shrinks, one.left) == (None, 0.0)


def test_all_runs_have_a_step_of_the_world_that_divides_those_of_the_loop() -> None:
    grid = RunGrid.of("braitenberg_husky", [], [], 2, timesteps=["20 ms", "5 ms"])
    assert grid.timesteps == grid.variants == ("5 ms", "20 ms")
    settings = [grid.settings(cell) for cell in grid.cells]
    assert all("world.options.timestep=1000000 ns" in each for each in settings)
    own = [next(one for one in each if one.startswith("timestep=")) for each in settings[:2]]
    assert own == [
        "timestep=5 ms", "timestep=20 ms",
    ]  # fmt: skip
    assert grid.load(grid.cells[0]).timestep == 5_000_000


def test_the_own_step_of_the_world_stays_if_it_divides_all() -> None:
    assert RunGrid.of("braitenberg_husky", [], [], 1, timesteps=["20 ms", "10 ms"]).world_step_ns is None


def test_a_difference_of_time_steps_has_one_cause() -> None:
    with pytest.raises(ExperimentError, match="one brain and one world"):
        RunGrid.of("braitenberg_husky", ["event", "spinnaker"], [], 1, timesteps=["20 ms", "10 ms"])
    with pytest.raises(ExperimentError, match="not both"):
        RunGrid.of("braitenberg_husky", [], [], 1, controls=["rewire"], timesteps=["20 ms", "10 ms"])
    with pytest.raises(ExperimentError, match="twice"):
        RunGrid.of("braitenberg_husky", [], [], 1, timesteps=["20 ms", "0.02 s"])
