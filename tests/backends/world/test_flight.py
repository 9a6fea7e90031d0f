"""Bodies that fly as they are told, on both engines."""

from __future__ import annotations

import numpy as np
import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.messages.base import Duration
from nrp_core.messages.geometry_msgs import Twist, Vector3, Wrench
from nrp_core.scene.model import Box, Collision, Inertial, Joint, Link, Model
from nrp_core.scene.rigid import Pose
from nrp_core.world.drives.flight import Flight


def drone(*joints: Joint, **options) -> Model:
    """Return a body of 2 kg with a rotor on its side, which puts the centre of mass beside the frame."""
    body = Link(
        "body",
        inertial=Inertial(2.0, Pose((0.05, 0.0, 0.0)), (0.02, 0.03, 0.04, 0.0, 0.0, 0.0)),
        collisions=(Collision("c", Box((0.4, 0.4, 0.1))),),
    )
    inertia = (1e-3, 1e-3, 2e-3, 0.0, 0.0, 0.0)
    rotor = Link("rotor", Pose((0.2, 0.2, 0.1)), Inertial(0.1, inertia=inertia))
    axle = Joint("axle", "continuous", "body", "rotor", Pose((0.2, 0.2, 0.1)))
    drive = Flight("flight", "/drone/cmd_vel", **options)
    return Model("drone", (body, rotor), (axle, *joints), (drive,), Pose((0.0, 0.0, 3.0)))


def fly(world, linear=(0.0, 0.0, 0.0), angular=(0.0, 0.0, 0.0)) -> None:
    world.advertise("/drone/cmd_vel").publish(Twist(Vector3(*linear), Vector3(*angular)))


def test_a_body_falls_until_its_first_command_and_then_hovers(open_world, advance):
    world = open_world(drone())
    advance(world, 0.2)
    fallen = world.model_motion("drone").pose.position[2]
    assert fallen == pytest.approx(3.0 - 4.9 * 0.04, abs=0.01)
    fly(world)
    advance(world, 2.0)
    motion = world.model_motion("drone")
    assert motion.linear == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    # a speed of 2 m/s is braked by the largest acceleration
    assert motion.pose.position[2] == pytest.approx(fallen - 1.96**2 / 2 / 20.0, abs=0.01)


def test_it_flies_a_helix(open_world, advance):
    world = open_world(drone())
    fly(world, (1.0, 0.3, 0.2), (0.0, 0.0, 0.5))
    advance(world, 4.0)
    pose, turned = world.model_motion("drone").pose, 2.0
    expected = [
        (1.0 * np.sin(turned) - 0.3 * (1 - np.cos(turned))) / 0.5,
        (1.0 * (1 - np.cos(turned)) + 0.3 * np.sin(turned)) / 0.5,
        3.0 + 0.8,
    ]
    assert pose.position == pytest.approx(expected, abs=0.04)  # 50 ms pass until it is as fast
    assert pose.yaw == pytest.approx(turned, abs=0.01)


def test_it_rolls_about_its_own_axis_as_long_as_that_is_commanded(open_world, advance):
    world = open_world(drone(initial=((0.0, 0.0, 0.0), (0.8, 0.0, 0.0))))
    advance(world, 1.0)
    roll, pitch, yaw = world.model_motion("drone").pose.rpy
    assert (roll, pitch, yaw) == pytest.approx((0.8, 0.0, 0.0), abs=5e-3)
    assert world.model_motion("drone").pose.position == pytest.approx((0.0, 0.0, 3.0), abs=5e-3)


def test_a_push_of_a_user_and_a_snapshot_do_not_end_it(open_world, advance):
    world = open_world(drone())
    fly(world, (0.5, 0.0, 0.0))
    advance(world, 0.5)
    push = Wrench(Vector3(0.0, 100.0, 0.0), Vector3())
    assert world.call("/gazebo/apply_body_wrench", "drone::body", wrench=push, duration=Duration(0, 10**8))
    advance(world, 0.04)
    assert world.model_motion("drone").linear[1] > 0.05
    middle = world.snapshot()
    advance(world, 1.0)
    end = world.model_motion("drone")
    assert end.linear == pytest.approx((0.5, 0.0, 0.0), abs=5e-3)  # the push has turned it a little
    world.restore(middle)
    advance(world, 1.0)
    assert world.model_motion("drone") == end
    world.reset()
    advance(world, 0.2)
    assert world.model_motion("drone").pose.position[2] == pytest.approx(3.0 - 4.9 * 0.04, abs=0.01)


def test_a_held_body_cannot_fly(open_world, golden: Golden):
    with golden.raises(SceneError, match="'flight'.*'drone'"):
        open_world(drone(Joint("nail", "fixed", "world", "body")))
