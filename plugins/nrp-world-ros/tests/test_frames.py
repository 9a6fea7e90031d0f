"""The frames that ROS's tools are told of: a tree in which measurements are where they were made."""

from __future__ import annotations

from itertools import chain
from typing import Any

import pytest
from nrp_core import worlds
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.world import Box, Collision, Inertial, Joint, Laser, Link, Model, PlanarMove, Pose, Scene, World

from nrp_world_ros.frames import Frames

MOUNT = Pose.from_rpy((0.1, 0.2, 0.3), 0.0, 0.0, 0.5)
START = Pose.from_rpy((1.0, 2.0, 0.5), 0.0, 0.0, 0.7)
MASS = Inertial(1.0, inertia=(0.1, 0.1, 0.1, 0.0, 0.0, 0.0))


class Listener:
    """A node whose publishers have one subscriber, which keeps their messages."""

    def __init__(self) -> None:
        self.heard: dict[str, list[Any]] = {}
        self.latched: list[str] = []

    def publisher(self, topic: str, cls: type, *, latched: bool = False) -> Channel:
        self.latched += [topic] if latched else []
        return Channel(self.heard.setdefault(topic, []))


class Channel:
    def __init__(self, heard: list[Any]) -> None:
        self._heard = heard

    def peers(self) -> int:
        return 1

    def publish(self, message: Any) -> None:
        self._heard.append(message)


def rover() -> Model:
    """Return a base that slides, with an arm on a joint, and a laser on the arm."""
    hull = Collision("hull", Box((0.4, 0.4, 0.2)))
    laser = Laser("laser", "/scan", 10.0, pose=MOUNT)
    arm = Link("arm", Pose((0.0, 0.0, 0.4)), MASS, sensors=(laser,))
    joint = Joint("shoulder", "revolute", "base", "arm", arm.pose, lower=0.3, upper=1.0)
    drive = PlanarMove("move", "/rover/cmd_vel", odometry_topic="/rover/odom")
    return Model("rover", (Link("base", Pose(), MASS, collisions=(hull,)), arm), (joint,), (drive,), START)


def frames_of(world: World) -> dict[str, tuple[str, Pose]]:
    """Return the parent of each frame and its pose there."""
    listener = Listener()
    Frames(world, listener).send(world.now_ns)  # type: ignore[arg-type]
    return frames_in(*listener.heard["/tf"], *listener.heard["/tf_static"])


def frames_in(*messages: Any) -> dict[str, tuple[str, Pose]]:
    found = {}
    for each in chain.from_iterable(message.transforms for message in messages):
        at, turn = each.transform.translation, each.transform.rotation
        pose = Pose((at.x, at.y, at.z), (turn.x, turn.y, turn.z, turn.w))
        found[each.child_frame_id] = (each.header.frame_id, pose)
    return found


@pytest.fixture
def world():
    backend = worlds().load("mujoco")
    ground = Model("ground", (Link("floor", collisions=(Collision("f", Box((20, 20, 0.8))),)),), static=True)
    watching = Link("pole", Pose((0.0, 0.0, 2.0)), sensors=(Laser("above", "/above", 1.0, pose=MOUNT),))
    tower = Model("tower", (watching,), pose=START, static=True)
    with backend.open(Scene((rover(), ground, tower)), seed=1, options=backend.options()) as opened:
        opened.advertise("/rover/cmd_vel").publish(Twist(Vector3(0.5, 0.0, 0.0), Vector3(0.0, 0.0, 0.3)))
        opened.run_until(500_000_000)
        yield opened


def test_the_frames_are_a_tree_from_the_world_over_odometry_and_base_to_the_sensors(world: World) -> None:
    assert {name: parent for name, (parent, _) in frames_of(world).items()} == {
        "rover/odom": "world",
        "rover/base": "rover/odom",
        "rover/arm": "rover/base",
        "rover/arm/laser": "rover/arm",
        "tower/pole": "world",
        "tower/pole/above": "tower/pole",
    }


def test_static_frames_are_sent_once_and_latched(world: World) -> None:
    listener = Listener()
    frames = Frames(world, listener)  # type: ignore[arg-type]
    for _ in range(3):
        frames.send(world.now_ns)
    assert listener.latched == ["/tf_static"]
    (told,) = listener.heard["/tf_static"]
    assert set(frames_in(told)) == {"rover/arm/laser", "tower/pole", "tower/pole/above"}
    assert frames_in(told)["tower/pole"][1].position == pytest.approx((1.0, 2.0, 2.5))
    assert len(listener.heard["/tf"]) == 3


def test_followed_up_to_the_world_each_frame_is_where_the_world_has_it(world: World) -> None:
    frames = frames_of(world)

    def up(name: str) -> Pose:
        parent, pose = frames[name]
        return pose if parent == "world" else up(parent) @ pose

    arm = world.link_motion("rover", "arm").pose
    assert up("rover/odom").position == START.position
    assert up("rover/arm/laser").position == pytest.approx((arm @ MOUNT).position)
    assert up("rover/arm/laser").yaw == pytest.approx((arm @ MOUNT).yaw)


def test_the_base_is_in_the_frame_of_odometry_where_odometry_says(world: World) -> None:
    heard = world.subscribe("/rover/odom")
    world.run_until(1_000_000_000)
    parent, pose = frames_of(world)["rover/base"]
    message = heard.latest.message
    at = message.pose.pose.position
    assert (message.header.frame_id, message.child_frame_id) == (parent, "rover/base")
    assert pose.position == pytest.approx((at.x, at.y, at.z))
    assert pose.position[0] > 0.1
