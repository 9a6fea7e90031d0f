"""Where joints start."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from jointed import axis, joint, limit, link, weightless

from nrp_core.scene.posture import at_start, moved_into_limits

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
    assert [joint.name for joint in moved_into_limits(model)] == ["j", "k"]
    assert moved_into_limits(replace(model, starts=(("j", 0.5), ("k", -0.3)))) == []


def test_joints_start_at_the_given_positions_and_others_follow_them(open_world, read):
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


@pytest.mark.parametrize("starts", [(("j", 0.4),), (("j", 0.8), ("k", -0.45)), ()])
def test_links_of_a_model_at_its_start_are_where_the_engine_has_them(open_world, read, starts):
    model = replace(read(OUTSIDE), starts=starts)
    world = open_world(weightless(model))
    for part in at_start(model).links:
        there = world.link_motion("robot", part.name).pose
        here = model.pose @ part.pose
        assert there.position == pytest.approx(here.position, abs=1e-9)
        assert abs(np.dot(there.orientation, here.orientation)) == pytest.approx(1.0, abs=1e-9)
