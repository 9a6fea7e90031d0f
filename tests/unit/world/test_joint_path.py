"""Paths through points in time, for any points."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.world.controllers.trajectory import JointPath, Knot

S = 1_000_000_000
NUMBERS = st.floats(-10.0, 10.0)


@st.composite
def paths(draw: st.DrawFn) -> JointPath:
    """Return a path whose knots tell positions, velocities too, or accelerations as well."""
    told = draw(st.integers(1, 3))
    times = sorted(draw(st.sets(st.integers(0, 20), min_size=2, max_size=6)))
    return JointPath(tuple(Knot(t * S // 4, *(draw(NUMBERS) for _ in range(told))) for t in times))


@given(paths())
def test_a_path_passes_its_knots_at_their_times_and_stops_at_the_last(path: JointPath) -> None:
    for knot in path.knots[:-1]:
        here, before = path.at(knot.t_ns), path.at(knot.t_ns - 1)
        assert here is not None
        assert here.position == pytest.approx(knot.position)
        if knot.velocity is not None:
            assert here.velocity == pytest.approx(knot.velocity)
        if before is not None:
            assert before.position == pytest.approx(knot.position, abs=1e-5)
            for field in ("velocity", "acceleration") if knot.velocity is not None else ():
                told = getattr(knot, field)
                assert told is None or getattr(before, field) == pytest.approx(told, abs=1e-3)
    last = path.knots[-1]
    assert path.at(last.t_ns) == path.at(last.t_ns + S).__class__(last.t_ns, last.position, 0.0, 0.0)


@given(paths(), st.integers(0, 5 * S))
def test_its_velocity_is_the_slope_of_its_position(path: JointPath, t_ns: int) -> None:
    early, late, here = path.at(t_ns), path.at(t_ns + 20_000), path.at(t_ns + 10_000)
    knots = [knot.t_ns for knot in path.knots]
    if early is None or any(t_ns <= t <= t_ns + 20_000 for t in knots):
        return
    assert here is not None
    assert late is not None
    slope = (late.position - early.position) / 20e-6
    assert here.velocity == pytest.approx(slope, abs=1e-3, rel=1e-3)


def test_before_its_first_knot_the_path_before_holds_as_long_as_it_is_kept() -> None:
    first = JointPath((Knot(0, 0.0), Knot(10 * S, 10.0)))
    then = JointPath((Knot(5 * S, 5.0), Knot(6 * S, 0.0)), first)
    assert then.at(3 * S) == first.at(3 * S)
    assert then.at(6 * S) == Knot(6 * S, 0.0, 0.0, 0.0)
    assert then.since(4 * S) == then
    assert then.since(5 * S).at(3 * S) is None
    assert then.until(5 * S) is first
    assert then.until(6 * S) is then
