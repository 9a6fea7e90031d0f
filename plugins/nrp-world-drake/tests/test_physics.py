"""Drake against formulas: friction of pairs, motors, surfaces, loops and what it lacks."""

from __future__ import annotations

from dataclasses import replace
from math import cos, inf
from pathlib import Path

import numpy as np
import pytest
from nrp_conformance.world.capability import INERTIA, arm
from nrp_conformance.world.kit import GRAVITY, at, floor, prop, rubbing
from nrp_world_drake import DrakeBackend

from nrp_core.errors import CapabilityError
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.loops import Loop
from nrp_core.scene.meshes.stl import write_stl
from nrp_core.scene.origin import Native
from nrp_core.scene.rigid import Pose
from nrp_core.world import (
    Box,
    ConcaveMesh,
    Inertial,
    Joint,
    JointController,
    Link,
    Mesh,
    Model,
    ModelMotion,
    Pid,
    Scene,
    Sphere,
    World,
)

WEIGHTLESS = (0.0, 0.0, 0.0)


def opened(*models: Model, gravity: tuple[float, float, float] = (0.0, 0.0, -GRAVITY)) -> World:
    backend = DrakeBackend()
    return backend.open(Scene(models, gravity=gravity), seed=1, options=backend.options())


def run(world: World, until_s: float) -> None:
    world.run_until(round(until_s * 1e9))


def test_a_contact_has_the_smaller_of_two_coefficients_of_friction() -> None:
    """No choice of one coefficient for each shape gives these three pairs by Drake's own rule."""
    pull = 0.6 * GRAVITY
    boxes = [
        rubbing(prop(name, Box((0.4, 0.4, 0.2)), at(0, y, 0.1), mass=1.0), friction)
        for name, y, friction in (("a", -1.0, 0.1), ("b", 0.0, 0.3), ("c", 1.0, 0.9))
    ]
    world = opened(rubbing(floor(), 0.5), *boxes, gravity=(pull, 0.0, -GRAVITY))
    run(world, 0.5)
    for name, friction in (("a", 0.1), ("b", 0.3), ("c", 0.5)):
        expected = 0.5 * (pull - friction * GRAVITY)
        allowed = (
            1.2 * friction * GRAVITY * 0.002
        )  # there is no friction in the step in which a contact begins
        assert world.model_motion(name).linear[0] == pytest.approx(expected, abs=allowed)


def test_a_body_at_rest_sinks_in_by_what_the_step_resolves() -> None:
    world = opened(floor(), prop("box", Box((0.2, 0.2, 0.2)), at(0, 0, 0.1), mass=3.0))
    run(world, 1.0)
    motion = world.model_motion("box")
    assert 0.1 - motion.pose.position[2] == pytest.approx(GRAVITY * 0.001**2, rel=0.05)
    assert motion.linear == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def test_a_motor_has_the_inertia_of_its_armature() -> None:
    free = replace(arm("effort").joints[0], kind="continuous")
    armature = Native("mujoco", "joint", (("name", "joint"), ("armature", "0.48")))
    world = opened(replace(arm("effort"), joints=(free,), native=(armature,)), gravity=WEIGHTLESS)
    world.advertise("/arm/cmd").publish(Float64(1.0))
    run(world, 0.5)
    assert world.joint_states("arm").velocities == pytest.approx([0.5 / (INERTIA + 0.48)], rel=1e-6)


@pytest.mark.parametrize("friction", [0.0, 2.0])
def test_a_firm_joint_holds_its_load_and_reports_it(friction: float) -> None:
    model = arm()
    joint = replace(model.joints[0], friction=friction)
    world = opened(
        replace(model, joints=(joint,), controllers=(JointController("joint", "position", "/arm/cmd", None),))
    )
    world.advertise("/arm/cmd").publish(Float64(-0.4))
    run(world, 2.0)
    states = world.joint_states("arm")
    assert states.positions == pytest.approx([-0.4], abs=1e-5)
    assert states.efforts == pytest.approx([-GRAVITY * 2.0 * 0.5 * cos(-0.4)], rel=1e-5)


def test_a_servo_with_gains_and_dry_friction_bears_the_load_together() -> None:
    model = arm()
    gains = JointController("joint", "position", "/arm/cmd", Pid(200.0, 0.0, 20.0))
    joint = replace(model.joints[0], friction=2.0, effort=inf)
    world = opened(replace(model, joints=(joint,), controllers=(gains,)))
    world.advertise("/arm/cmd").publish(Float64(-0.4))
    run(world, 3.0)
    (angle,), (effort,) = world.joint_states("arm").positions, world.joint_states("arm").efforts
    assert effort == pytest.approx(200.0 * (-0.4 - angle), rel=1e-3)
    assert effort + GRAVITY * 2.0 * 0.5 * cos(angle) == pytest.approx(-2.0, rel=1e-2)


def test_a_ball_rests_in_a_bowl_that_is_not_convex(tmp_path: Path) -> None:
    """Two slopes of 45 degrees that meet; by its convex hull the surface would be full."""
    points = [(x, y, abs(x)) for y in (-1.0, 1.0) for x in (-1.0, 0.0, 1.0)]
    faces = [(0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4)]
    path = tmp_path / "valley.stl"
    write_stl(path, np.array([[points[k] for k in face] for face in faces]))
    valley = prop("valley", ConcaveMesh(path, (1.0, 1.0, 1.0)))
    world = opened(valley, prop("ball", Sphere(0.2), at(0.0, 0.0, 0.29), mass=1.0))
    run(world, 1.0)
    x, _, z = world.model_motion("ball").pose.position
    assert (x, z) == pytest.approx((0.0, 0.2 * 2**0.5), abs=0.02 * 0.2)  # of its mesh


def test_a_mesh_of_micrometres_touches_by_points(tmp_path: Path) -> None:
    """Drake finds no pressure field in it; files have such splinters."""
    corners = 1e-5 * np.array([(-1.0, -1.0, -0.2), (1.0, -1.0, -0.2), (0.0, 1.0, -0.2), (0.0, 0.0, 0.2)])
    path = tmp_path / "splinter.stl"
    write_stl(path, np.array([corners[list(face)] for face in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))]))
    world = opened(floor(), prop("splinter", Mesh(path, (1.0, 1.0, 1.0)), at(0, 0, 0.001), mass=1.0))
    run(world, 0.5)
    assert world.model_motion("splinter").pose.position[2] == pytest.approx(0.0, abs=1e-4)


def test_a_loop_keeps_its_points_together() -> None:
    """A four-bar linkage: two cranks and a coupler whose other end a loop holds."""
    moment = (0.01, 0.01, 0.01, 0.0, 0.0, 0.0)
    links = tuple(
        Link(name, pose, Inertial(1.0, inertia=moment))
        for name, pose in (("left", Pose()), ("right", Pose((1.0, 0, 0))), ("bar", Pose((0.0, 0, 0.5))))
    )
    along = (0.0, 1.0, 0.0)
    joints = (
        Joint("a", "continuous", "world", "left", Pose(), along),
        Joint("b", "continuous", "world", "right", Pose((1.0, 0.0, 0.0)), along),
        Joint("c", "continuous", "left", "bar", Pose((0.0, 0.0, 0.5)), along),
    )
    loop = Loop("d", "revolute", "right", "bar", Pose((1.0, 0.0, 0.5)), along)
    world = opened(Model("bars", links, joints, loops=(loop,)), gravity=(1.0, 0.0, -GRAVITY))
    run(world, 0.5)
    a, b, c = world.joint_states("bars").positions.tolist()
    assert abs(a) > 0.1
    assert (b, c) == pytest.approx((a, -a), abs=1e-4)


def test_a_mechanism_of_mjcf_is_named() -> None:
    tendon = Native("mujoco", "tendon", (), "", (Native("", "fixed"), Native("", "fixed")))
    world = opened(replace(arm(), native=(tendon,)))
    messages = [str(each.message) for each in world.engine.warnings]
    assert messages == ["Drake does not have the 2 <fixed> in <tendon> of 'arm'"]


def test_a_ball_joint_that_is_led_is_refused() -> None:
    ball = Joint("joint", "ball", "world", "bob")
    led = replace(
        arm(), joints=(ball,), controllers=(JointController("joint", "position", "/arm/cmd", None),)
    )
    with pytest.raises(CapabilityError, match="arm/joint"):
        opened(led)


def test_an_orientation_keeps_its_length_while_a_body_turns() -> None:
    """Drake lets the four numbers of a free body grow by ``(w step / 2)^2 / 2`` in each step."""
    world = opened(prop("box", Box((0.2, 0.2, 0.2)), Pose(), mass=1.0), gravity=WEIGHTLESS)
    world.engine.place("box", ModelMotion(Pose(), (0.0, 0.0, 0.0), (0.0, 0.0, 20.0)))
    run(world, 1.0)
    orientation = world.model_motion("box").pose.orientation
    assert sum(part * part for part in orientation) == pytest.approx(1.0, abs=1e-12)
