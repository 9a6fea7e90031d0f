"""Where joints start."""

from __future__ import annotations

from dataclasses import replace

import pytest
from jointed import axis, joint, limit, link, weightless

OUTSIDE = (
    link("bob")
    + joint("revolute", axis("0 0 1", limit(0.3, 0.9)))
    + link("tip", at=(1, 0, 0))
    + joint("prismatic", axis("1 0 0", limit(-0.5, -0.2)), name="k", parent="bob", child="tip")
)


def positions(world) -> list[float]:
    return world.joint_states("robot").positions.tolist()


def test_joints_whose_limits_exclude_0_start_at_rest_at_the_nearest_limit(open_world, read, advance):
    model = read(OUTSIDE)
    world = open_world(weightless(model))
    for begin in (lambda: None, world.reset, lambda: world.reset("poses")):
        begin()
        assert positions(world) == pytest.approx([0.3, -0.2], abs=1e-12)
        advance(world, 0.3)
        assert positions(world) == pytest.approx([0.3, -0.2], abs=1e-3)
        assert abs(world.joint_states("robot").velocities).max() < 1e-2
        world.set_joints("robot", {"j": 0.7})
    (said,) = [str(each) for each in model.warnings if "exclude 0" in each.message]
    assert "'j' at 0.3, 'k' at -0.2" in said


def test_joints_start_where_they_are_told_to_and_others_follow_them(open_world, read):
    follows = (
        '<mimic joint="j"><multiplier>2</multiplier><offset>0.1</offset><reference>0</reference></mimic>'
    )
    body = link("bob") + joint("revolute", axis("0 0 1", limit(-1, 1)))
    body += link("tip") + joint("revolute", axis("0 0 1", follows), name="k", parent="bob", child="tip")
    world = open_world(weightless(replace(read(body), starts=(("j", 0.4),))))
    assert positions(world) == pytest.approx([0.4, 0.9], abs=1e-12)


def test_a_joint_that_follows_another_one_at_a_distance_starts_there(open_world, read, advance):
    body = link("bob") + joint("continuous", axis("0 1 0"))
    follows = '<mimic joint="j"><multiplier>0.1</multiplier><offset>0.05</offset></mimic>'
    body += link("rack") + joint("prismatic", axis("1 0 0", follows), name="k", parent="world", child="rack")
    world = open_world(weightless(read(body)))
    assert positions(world) == pytest.approx([0.0, 0.05], abs=1e-12)
    advance(world, 0.2)
    assert positions(world) == pytest.approx([0.0, 0.05], abs=1e-6)  # nothing pulls at them
