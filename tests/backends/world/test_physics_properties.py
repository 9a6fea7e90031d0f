"""Gravity that changes in a run, and the physics step that does not, on both engines."""

from __future__ import annotations

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.messages.gazebo_srvs import SetPhysicsPropertiesRequest
from nrp_core.messages.geometry_msgs import Vector3
from nrp_core.scene.model import Box, Scene, Sphere
from nrp_core.scene.rigid import Pose

SET, GET = "/gazebo/set_physics_properties", "/gazebo/get_physics_properties"
MOON = -1.62


def falling(parts) -> Scene:
    return Scene((parts.prop("ball", Sphere(0.1), Pose((0.0, 0.0, 20.0)), mass=1.0),))


def height(world) -> float:
    return world.model_motion("ball").pose.position[2]


def test_a_ball_falls_on_by_another_gravity_from_where_it_is_and_as_fast_as_it_is(open_world, parts, advance):
    world = open_world(falling(parts))
    advance(world, 0.5)
    assert world.call(SET, gravity=Vector3(0.0, 0.0, MOON)).success
    advance(world, 0.5)
    speed = 9.8 * 0.5
    expected = 20.0 - speed * 0.25 - speed * 0.5 + MOON * 0.5**2 / 2
    assert height(world) == pytest.approx(expected, abs=0.01)
    told = world.call(GET)
    assert (told.gravity.z, told.time_step, told.pause) == (MOON, 0.002, False)


def test_a_snapshot_keeps_gravity_and_a_reset_brings_back_that_of_the_file(open_world, parts, advance):
    world = open_world(falling(parts))
    advance(world, 0.1)
    world.set_gravity((0.0, 0.0, 3.0))
    advance(world, 0.1)
    middle = world.snapshot()
    advance(world, 0.3)
    end = world.model_motion("ball")
    world.reset()
    assert world.call(GET).gravity.z == -9.8
    advance(world, 0.5)
    assert height(world) == pytest.approx(20.0 - 4.9 * 0.25, abs=0.01)
    world.restore(middle)
    assert world.call(GET).gravity.z == 3.0
    advance(world, 0.3)
    assert world.model_motion("ball") == end


def test_a_published_request_is_done_too_and_robots_drive_on(open_world, parts, driver, advance):
    world = open_world(parts.floor(), parts.husky())
    drive = driver(world)
    drive.drive(0.5, 0.0, 0.5)
    request = SetPhysicsPropertiesRequest(gravity=Vector3(0.0, 0.0, MOON))
    world.advertise(SET).publish(request)
    pose = drive.drive(0.5, 0.0, 0.5)
    assert pose.position[0] == pytest.approx(0.5, abs=0.01)
    with_friction = parts.prop("box", Box((0.2, 0.2, 0.2)), Pose((0.0, 2.0, 0.1)), mass=2.0)
    world.spawn(with_friction)
    assert world.scene.gravity[2] == MOON


@pytest.mark.parametrize("step_s", [0.001, 0.003])
def test_another_physics_step_is_refused_in_one_sentence_and_nothing_changes(open_world, parts, step_s):
    world = open_world(falling(parts))
    answer = world.call(SET, time_step=step_s, gravity=Vector3())
    assert not answer.success
    assert (
        f"the physics step is 0.002 s for the whole run and cannot be changed to {step_s} s"
        in answer.status_message
    )
    assert world.call(GET).gravity.z == -9.8


def test_gravity_must_be_finite(open_world, parts, golden: Golden):
    with golden.raises(SceneError):
        open_world(falling(parts)).set_gravity((0.0, 0.0, np.inf))
