"""Rolling, controllers, slopes and loads against closed forms; images against ray casts of MuJoCo.

`benchmarks/parity.py` measures more of the same. Tolerances are a few times what is measured there.
"""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import files
from math import cos, exp, pi, radians, sin, sqrt
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from ray_images import ray_image

from nrp_core.dsl.tf_lib import detect_red
from nrp_core.messages.sensor_msgs import Image
from nrp_core.messages.std_msgs import Float64
from nrp_core.scene.devices import JointController, Pid
from nrp_core.scene.model import Box, Collision, Inertial, Joint, Link, Model, Scene, Sphere
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model, read_scene

GRAVITY = 9.8
RED = (1.0, 0.0, 0.0, 1.0)
SHIPPED = Path(str(files("nrp_experiments.braitenberg_husky")))


def slope(parts, degrees: float) -> tuple[Model, Pose]:
    """Return ground that rises along x, and its frame at the origin."""
    frame = Pose.from_rpy((0, 0, 0), 0, -radians(degrees), 0)
    return parts.prop("slope", Box((20, 20, 1)), frame @ Pose((0, 0, -0.5))), frame


@pytest.mark.parametrize("inertia", [0.4, 2 / 3])
def test_a_ball_rolls_down_by_its_moment_of_inertia(open_world, parts, advance, inertia):
    """A solid ball (2/5 m r^2) and a hollow one (2/3 m r^2) roll at g sin(a) / (1 + k) without slipping."""
    mass, radius = 2.0, 0.2
    ground, frame = slope(parts, 10)
    moment = inertia * mass * radius**2
    link = Link(
        "link",
        inertial=Inertial(mass, inertia=(moment, moment, moment, 0, 0, 0)),
        collisions=(Collision("c", Sphere(radius)),),
    )
    world = open_world(ground, Model("ball", (link,), pose=frame @ Pose((0, 0, radius))))
    advance(world, 1.0)
    motion = world.model_motion("ball")
    speed = GRAVITY * sin(radians(10)) / (1 + inertia)
    assert np.linalg.norm(motion.linear) == pytest.approx(speed, rel=0.01)
    assert np.linalg.norm(motion.angular) == pytest.approx(speed / radius, rel=0.01)


@pytest.mark.parametrize(("stiffness", "damping"), [(30.0, 2.0), (60.0, 4.0)])
def test_a_position_controller_answers_a_step_as_a_spring_and_a_damper(open_world, stiffness, damping):
    """Under-damped: 1 - e^(-ct) (cos wt + c/w sin wt) with c = d / 2J and w^2 = k/J - c^2."""
    mass, arm = 2.0, 0.5
    inertia = 0.02 + mass * arm**2
    bob = Link("bob", inertial=Inertial(mass, Pose((arm, 0, 0)), (0.02, 0.02, 0.02, 0, 0, 0)))
    hinge = Joint("hinge", "continuous", "world", "bob", axis=(0, 1, 0))
    control = JointController("hinge", "position", "/arm/hinge/cmd_pos", Pid(stiffness, 0.0, damping))
    arm_model = Model("arm", (bob,), (hinge,), pose=Pose((0, 0, 2)), controllers=(control,))
    world = open_world(Scene((arm_model,), gravity=(0.0, 0.0, 0.0)))
    world.advertise("/arm/hinge/cmd_pos").publish(Float64(1.0))
    decay = damping / (2 * inertia)
    omega = sqrt(stiffness / inertia - decay**2)
    off = []
    for step in range(1, 101):
        world.run_until(step * 20_000_000)
        t = step * 0.02
        angle = 1 - exp(-decay * t) * (cos(omega * t) + decay / omega * sin(omega * t))
        off.append(abs(float(world.joint_states("arm").positions[0]) - angle))
    assert max(off) < 0.03


@pytest.mark.parametrize("degrees", [-15, 5, 15])
def test_on_a_slope_a_robot_drives_as_far_as_on_flat_ground(open_world, parts, driver, degrees):
    ground, frame = slope(parts, degrees)
    world = open_world(ground, parts.husky(pose=frame @ Pose((0, 0, parts.standing))))
    robot = driver(world)
    start = robot.drive(0.0, 0.0, 0.5)
    way = start.inverse() @ robot.drive(0.5, 0.0, 4.0)
    assert way.position == pytest.approx((2.0, 0.0, 0.0), abs=0.02)
    assert way.yaw == pytest.approx(0.0, abs=0.005)


def test_a_load_changes_little(open_world, parts, driver):
    crate = parts.prop("crate", Box((0.4, 0.4, 0.2)), Pose((0.1, 0, parts.standing + 0.34)), mass=20.0)
    world = open_world(parts.floor(), parts.husky(), crate)
    robot = driver(world)
    robot.drive(0.0, 0.0, 0.5)
    pose = robot.drive(0.4, 0.5, 2.0)
    assert pose.position[:2] == pytest.approx((0.8 * sin(1.0), 0.8 * (1 - cos(1.0))), abs=0.01)
    assert pose.yaw == pytest.approx(1.0, abs=0.01)
    assert world.model_motion("crate").pose.position[2] > 0.35


@pytest.mark.parametrize("place", [(0.4, 0.6, -pi / 2), (-0.8, 0.3, -2.4), (0.0, -0.5, -1.0)])
def test_cameras_see_the_shipped_room_as_ray_casts_of_mujoco_do(open_world, place):
    x, y, yaw = place
    robot = read_model(SHIPPED / "husky.sdf", name="husky", pose=Pose.from_rpy((x, y, 0.14), 0, 0, yaw))
    scene = read_scene(SHIPPED / "room.sdf").with_model(robot)
    world = open_world(scene)
    world.engine.set_color("left_vr_screen/body/screen_glass", RED)
    image = world.engine.render("husky", "eye_vision_camera", "camera")
    link = robot.link("eye_vision_camera")
    (view,) = (sensor.views["camera"] for sensor in link.sensors)
    bodiless = replace(
        robot, links=tuple(each for each in robot.links if each is not link)
    )  # it is around the eye
    models = [bodiless if each.name == "husky" else _with_red_screen(each) for each in scene.models]
    eye = robot.pose @ link.pose @ view.pose
    wanted = ray_image(models, eye, view.width, view.height, view.horizontal_fov)
    assert (image == wanted).all(axis=2).mean() > 0.99
    assert shares_of_red(image) == pytest.approx(shares_of_red(wanted), abs=5e-4)
    assert max(shares_of_red(wanted)) > 0.02


def _with_red_screen(model: Model) -> Model:
    if model.name != "left_vr_screen":
        return model
    links = []
    for link in model.links:
        visuals = [replace(v, rgba=RED) if v.name == "screen_glass" else v for v in link.visuals]
        links.append(replace(link, visuals=tuple(visuals)))
    return replace(model, links=tuple(links))


def shares_of_red(image: npt.NDArray[np.uint8]) -> tuple[float, float]:
    height, width, _ = image.shape
    shares = detect_red(Image(height=height, width=width, encoding="rgb8", data=image))
    return shares.left, shares.right
