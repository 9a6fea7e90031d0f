"""Where joints of loops start, by the geometry of linkages."""

from __future__ import annotations

from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest

from nrp_core.scene.loops import Loop
from nrp_core.scene.model import Joint, Link, Mimic, Model
from nrp_core.scene.posture import Posture, start_positions
from nrp_core.scene.rigid import Pose, Vector

LENGTH, APART = 0.5, 0.3
LEFT, RIGHT = (0.0, 0.0, 0.0), (APART, 0.0, 0.0)
LOW, END = (0.0, 0.0, -LENGTH), (APART, 0.0, -LENGTH)
ABOUT_Y = (0.0, 1.0, 0.0)


def hinge(
    name: str, parent: str, child: str, place: Vector, lower: float = -inf, upper: float = inf
) -> Joint:
    return Joint(name, "revolute", parent, child, Pose(place), ABOUT_Y, lower, upper)


def parallelogram(**limits: dict[str, float]) -> Model:
    """Return two cranks and the rod between their ends, which the loop holds to the right one."""
    joints = (
        hinge("a", "base", "left", LEFT, **limits.get("a", {})),
        hinge("b", "base", "right", RIGHT, **limits.get("b", {})),
        hinge("c", "left", "rod", LOW, **limits.get("c", {})),
    )
    links = tuple(Link(name) for name in ("base", "left", "right", "rod"))
    loop = Loop("d", "revolute", "right", "rod", Pose(END), ABOUT_Y)
    return Model("linkage", links, joints, static=False, loops=(loop,))


@pytest.mark.parametrize("angle", [0.3, -0.7])
def test_the_others_of_a_loop_start_where_they_close_it(angle: float) -> None:
    told = replace(parallelogram(), starts=(("a", angle),))
    limited = parallelogram(a={"lower": angle, "upper": pi} if angle > 0 else {"lower": -pi, "upper": angle})
    for model in (told, limited):
        assert start_positions(model) == pytest.approx({"a": angle, "b": angle, "c": -angle}, abs=1e-5)
        gaps = Posture(model, start_positions(model)).gaps(model.loops)
        assert np.abs(gaps).max() < 1e-6


def test_loops_that_are_closed_at_0_stay_there() -> None:
    assert start_positions(parallelogram()) == {}
    apart = (*parallelogram().joints, hinge("wrist", "rod", "hand", END, lower=0.2))
    model = replace(parallelogram(), links=(*parallelogram().links, Link("hand")), joints=apart)
    assert start_positions(model) == {"wrist": 0.2}


def test_limits_hold_where_a_loop_cannot_be_closed_within_them() -> None:
    model = parallelogram(a={"lower": 0.4}, b={"lower": -0.1, "upper": 0.1})
    starts = start_positions(model)
    assert (starts["a"], starts["b"]) == pytest.approx((0.4, 0.1))
    gaps, far = (np.abs(Posture(model, each).gaps(model.loops)).max() for each in (starts, {"a": 0.4}))
    assert 0.01 < gaps < far
    model = parallelogram(a={"lower": 0.4}, b={"lower": -0.1, "upper": 0.4})
    assert start_positions(model) == pytest.approx({"a": 0.4, "b": 0.4, "c": -0.4}, abs=1e-5)


def test_a_follower_stays_with_its_leader() -> None:
    a, b, c = parallelogram(a={"lower": 0.2}).joints
    model = replace(parallelogram(), joints=(a, replace(b, mimic=Mimic("a", 1.0, 0.0)), c))
    assert start_positions(model) == pytest.approx({"a": 0.2, "b": 0.2, "c": -0.2}, abs=1e-5)


def test_followers_of_followers_start_with_the_first_leader_in_any_order() -> None:
    a, b, c = parallelogram().joints
    chain = (replace(c, mimic=Mimic("b", 2.0, 0.0)), replace(b, mimic=Mimic("a", -1.0, 0.3)), a)
    for joints in (chain, chain[::-1]):
        model = replace(parallelogram(), joints=joints, loops=())
        assert start_positions(model) == pytest.approx({"b": 0.3, "c": 0.6})
        told = replace(model, starts=(("a", 0.1),))
        assert start_positions(told) == pytest.approx({"a": 0.1, "b": 0.2, "c": 0.4})
