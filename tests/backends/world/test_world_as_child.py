"""Joints of a world whose child is the world, which SDF allows from 1.10 on, against formulas."""

from __future__ import annotations

from math import cos, sqrt

import numpy as np
import pytest
from jointed import ARM, GRAVITY, MASS, ROUND, axis, joint, link

from nrp_core.scene.sdf import read_scene

STANDS = "<pose>1 0 2 0 0 0.5</pose>"
PLACED = '<pose relative_to="robot"/>'


@pytest.fixture
def room(tmp_path):
    """Read a world that a joint holds to a bob, whose centre of mass is below its frame."""

    def read(kind: str, more: str = ""):
        held = joint(kind, PLACED + more, parent="robot", child="world")
        bob = f'<model name="robot">{STANDS}{link("bob", com=(0.0, 0.0, -ARM))}</model>'
        (tmp_path / "room.sdf").write_text(f'<sdf version="1.10"><world name="w">{bob}{held}</world></sdf>')
        return read_scene(tmp_path / "room.sdf")

    return read


def positions(world) -> dict[str, float]:
    states = world.joint_states("robot")
    return dict(zip(states.names, states.positions.tolist(), strict=True))


def test_a_body_that_is_fixed_to_the_world_stays(open_world, advance, room) -> None:
    world = open_world(room("fixed"))
    advance(world, 0.5)
    assert world.model_motion("robot").pose.position == pytest.approx((1, 0, 2), abs=1e-6)


def test_the_world_rises_from_a_body_that_falls_along_a_rail(open_world, advance, room) -> None:
    world = open_world(room("prismatic", axis("0 0 1")))
    advance(world, 0.5)
    fallen = GRAVITY * 0.5**2 / 2
    assert positions(world)["j"] == pytest.approx(fallen, rel=0.01)
    assert world.link_motion("robot", "bob").pose.position == pytest.approx((1, 0, 2 - fallen), abs=0.015)


def test_the_world_turns_back_as_a_pendulum_swings(open_world, advance, room) -> None:
    """A small swing about an axis of the model, of a physical pendulum."""
    world = open_world(room("revolute", axis("1 0 0")))
    world.set_joints("robot", {"j": 0.05})
    frequency = sqrt(MASS * GRAVITY * ARM / ROUND)
    for step in range(1, 11):
        advance(world, 0.1)
        at = 0.05 * cos(frequency * 0.1 * step)
        assert positions(world)["j"] == pytest.approx(at, abs=2e-3)
        up = world.link_motion("robot", "bob").pose.rotate((0.0, 0.0, 1.0))
        across = np.array([-np.sin(0.5), np.cos(0.5), 0.0])  # y of the model; turning by -j tips z along it
        assert float(across @ up) == pytest.approx(at, abs=2e-3)


def test_the_first_axis_of_two_is_fixed_in_the_body(open_world, room) -> None:
    """The world in the frame of the body is turned about x of the body, then about y of the frame between."""
    world = open_world(room("universal", axis("1 0 0") + axis("0 1 0", tag="axis2")))
    world.set_joints("robot", {"j": 0.7, "j_axis2": 0.3})
    pose = world.link_motion("robot", "bob").pose
    x, y = 0.7, 0.3
    about_x = np.array([[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]])
    about_y = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    stood = np.array([[np.cos(0.5), -np.sin(0.5), 0], [np.sin(0.5), np.cos(0.5), 0], [0, 0, 1]])
    turned = np.array([pose.rotate(tuple(row)) for row in np.eye(3)]).T
    assert turned == pytest.approx(stood @ (about_x @ about_y).T, abs=1e-6)
