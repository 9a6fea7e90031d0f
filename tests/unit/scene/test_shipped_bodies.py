"""The bodies that ship are what they say they are."""

from __future__ import annotations

from math import pi, sin

import pytest
from nrp_experiments.bodies import FOLDER
from nrp_experiments.bodies import fly as insect
from nrp_experiments.bodies.hexapod import JOINTS, Hexapod, sdf

from nrp_core.scene.model import Model
from nrp_core.scene.rigid import Pose, Vector
from nrp_core.scene.sdf import read_model
from nrp_core.world.sensors.camera import Camera


@pytest.fixture(scope="module")
def hexapod() -> Model:
    return read_model(FOLDER / "hexapod.sdf")


def foot_of(model: Model, leg: str, **angles: float) -> Vector:
    """Return where a foot is, relative to the body, with some joints of the leg turned."""
    link = model.link(f"{leg}_gamma_link")
    foot = (link.pose @ link.collisions[0].pose).position
    joints = {joint.name: joint for joint in model.joints}
    for name in reversed(JOINTS):  # from the foot inwards, so that each joint is still where the file has it
        joint, half = joints[f"{leg}_{name}"], angles.get(name, 0.0) / 2
        x, y, z = (part * sin(half) for part in joint.axis)
        turned = Pose(orientation=(x, y, z, (1 - sin(half) ** 2) ** 0.5))
        foot = (joint.pose @ turned @ joint.pose.inverse() @ Pose(foot)).position
    return foot


LEGS = [f"{place}_{side}" for side in ("left", "right") for place in ("front", "middle", "rear")]


def test_the_walkers_file_equals_the_output_of_its_generator() -> None:
    assert sdf(Hexapod()) == (FOLDER / "hexapod.sdf").read_text()


def test_the_walker_has_six_legs_of_four_joints(hexapod: Model) -> None:
    assert [joint.name for joint in hexapod.joints] == [f"{leg}_{joint}" for leg in LEGS for joint in JOINTS]
    assert all(joint.kind == "revolute" and joint.effort == 40 for joint in hexapod.joints)
    mass = sum(link.inertial.mass for link in hexapod.links if link.inertial)
    assert mass == pytest.approx(9 + 6 * 1.4)


@pytest.mark.parametrize("leg", LEGS)
def test_the_walker_stands_on_its_feet(hexapod: Model, leg: str) -> None:
    x, y, z = foot_of(hexapod, leg)
    assert z + hexapod.pose.position[2] == pytest.approx(Hexapod().thick, abs=1e-5)
    assert y * (1 if "left" in leg else -1) > 0.3
    assert (x > 0.1) == ("front" in leg)
    assert (x < -0.1) == ("rear" in leg)


@pytest.mark.parametrize("leg", LEGS)
def test_its_joints_turn_to_the_same_side_on_all_legs(hexapod: Model, leg: str) -> None:
    at_rest, outward = foot_of(hexapod, leg), 1 if "left" in leg else -1
    assert foot_of(hexapod, leg, alpha=0.1)[0] > at_rest[0] + 0.02
    assert foot_of(hexapod, leg, beta=0.1)[2] > at_rest[2] + 0.01
    assert foot_of(hexapod, leg, delta=0.1)[2] > at_rest[2] + 0.01
    assert foot_of(hexapod, leg, gamma=0.1)[1] * outward > at_rest[1] * outward + 0.01


@pytest.mark.parametrize("raised", [0.2, 0.9])
def test_a_walker_of_other_measures_stands_too(raised: float, tmp_path) -> None:
    path = tmp_path / "walker.sdf"
    robot = Hexapod(raised=raised, shin=0.4, thigh=0.3)
    path.write_text(sdf(robot, "walker"))
    model = read_model(path)
    assert model.name == "walker"
    for leg in LEGS:
        assert foot_of(model, leg)[2] + robot.height == pytest.approx(robot.thick, abs=1e-5)


def test_the_two_wheeler_stands_level_on_wheels_and_caster() -> None:
    pioneer = read_model(FOLDER / "pioneer.sdf")
    height = pioneer.pose.position[2]
    caster = next(part for part in pioneer.links[0].collisions if part.name == "caster")
    assert caster.friction == 0
    assert caster.pose.position[2] + height == pytest.approx(caster.geometry.radius)
    wheels = [pioneer.link(f"{side}_wheel").collisions[0] for side in ("left", "right")]
    assert [wheel.geometry.radius for wheel in wheels] == [pytest.approx(height)] * 2
    (drive,) = pioneer.drives
    assert (drive.command_topic, drive.separation, drive.wheel_diameter) == ("/pioneer/cmd_vel", 0.331, 0.195)
    assert sum(link.inertial.mass for link in pioneer.links if link.inertial) == pytest.approx(9.0)


def test_the_camera_head_is_held_and_looks_ahead() -> None:
    head = read_model(FOLDER / "pan_tilt.sdf")
    joints = {joint.name: joint for joint in head.joints}
    assert joints["hold"].parent == "world"
    assert (joints["pan"].axis, joints["tilt"].axis) == ((0, 0, 1), (0, 1, 0))
    assert joints["tilt"].upper < pi / 2
    (eye,) = head.link("head").sensors
    assert isinstance(eye, Camera)
    assert eye.topic == "/pan_tilt/eye/image_raw"
    assert eye.pose.rotate((1.0, 0.0, 0.0)) == (1, 0, 0)


@pytest.fixture(scope="module")
def fly() -> Model:
    return read_model(FOLDER / "fly.sdf")


def test_the_flys_file_equals_the_output_of_its_generator() -> None:
    assert insect.sdf(insect.Fly()) == (FOLDER / "fly.sdf").read_text()


def test_the_fly_has_true_size_and_six_legs_of_seven_joints(fly: Model) -> None:
    names = [f"{leg}_{joint}" for leg in LEGS for joint in insect.JOINTS]
    assert [joint.name for joint in fly.joints] == ["proboscis", *(n.replace("rear", "hind") for n in names)]
    assert sum(link.inertial.mass for link in fly.links if link.inertial) == pytest.approx(1e-6, rel=0.01)
    assert not fly.warnings


def test_the_fly_stands_on_its_feet(fly: Model) -> None:
    feet = [link for link in fly.links if link.collisions]
    assert len(feet) == 6
    for link in feet:
        height = (link.pose @ link.collisions[0].pose).position[2] + fly.pose.position[2]
        assert height == pytest.approx(insect.Fly().foot, abs=1e-8)
