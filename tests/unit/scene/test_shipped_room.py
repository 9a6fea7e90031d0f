"""The robot and the room of the experiment that ships: the numbers that its behaviour depends on."""

from __future__ import annotations

import colorsys
from importlib.resources import files
from math import pi
from pathlib import Path

import pytest

from nrp_core.scene.model import Box, Cylinder, Inertial, Model, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model, read_scene
from nrp_core.world.drives.wheels import WheelDrive
from nrp_core.world.sensors.camera import Camera

FOLDER = Path(str(files("nrp_experiments.braitenberg_husky")))
WHEELS = ("back_left", "back_right", "front_left", "front_right")


@pytest.fixture(scope="module")
def husky() -> Model:
    return read_model(FOLDER / "husky.sdf")


@pytest.fixture(scope="module")
def room() -> Scene:
    return read_scene(FOLDER / "room.sdf")


def test_both_files_are_read_without_a_warning(husky: Model, room: Scene) -> None:
    assert room.with_model(husky).warnings == ()


# -- the robot


def test_the_chassis_has_its_mass_and_its_box(husky: Model) -> None:
    base = husky.links[0]
    assert base.name == "base_link"
    assert base.inertial == Inertial(
        33.855,
        Pose((-0.0856132, -0.000839955, 0.238145)),
        (2.2343, 3.42518, 2.1241, -0.023642, 0.275174, 0.00239624),
    )
    (hull,) = base.collisions
    assert (hull.geometry, hull.pose.position) == (Box((1.0074, 0.5709, 0.2675)), (0, 0, 0.1))


@pytest.mark.parametrize("name", WHEELS)
def test_the_wheels_spin_about_y_with_the_larger_moment(husky: Model, name: str) -> None:
    wheel = husky.link(f"{name}_wheel")
    x, y = (0.256 if "front" in name else -0.256), (0.285475 if "left" in name else -0.285475)
    assert wheel.pose.position == (x, y, 0.035)
    assert wheel.inertial == Inertial(2.6357, Pose(), (0.0246688, 0.0441058, 0.0246688, 0, 0, 0))
    (tyre,) = wheel.collisions
    assert (tyre.geometry, tyre.friction) == (Cylinder(0.17775, 0.1143), 1)
    assert tyre.pose.rotate((0.0, 0.0, 1.0)) == pytest.approx((0, -1, 0))


def test_the_wheel_joints_come_in_the_order_of_its_joint_states(husky: Model) -> None:
    movable = [joint for joint in husky.joints if joint.kind != "fixed"]
    assert [joint.name for joint in movable] == [f"{name}_joint" for name in WHEELS]
    assert {(joint.kind, joint.axis) for joint in movable} == {("continuous", (0, 1, 0))}


def test_the_drive_is_the_huskys(husky: Model) -> None:
    assert husky.drives == (
        WheelDrive(
            name="husky_diff_controller",
            command_topic="/husky/cmd_vel",
            left=("back_left_joint", "front_left_joint"),
            right=("back_right_joint", "front_right_joint"),
            separation=0.5709,
            wheel_diameter=0.3555,
            torque=35,
            timeout=0.1,
            rate_hz=100,
            odometry_topic="/husky/odom",
            wheel_speeds_topic="/husky/wheel_speeds",
        ),
    )
    assert husky.joint_states_topic == "/husky/joint_states"


def test_the_camera_sees_what_the_papers_did(husky: Model) -> None:
    eye = husky.link("eye_vision_camera")
    assert eye.pose.position == (-0.16, 0, 0.23)
    assert eye.sensors == (
        Camera(
            "camera",
            "/husky/camera",
            30,
            1.57,
            320,
            240,
            0.1,
            100,
            Pose((0, 0, 0.132)),
            info_topic="/husky/camera/camera_info",
        ),
    )


def test_nothing_that_is_drawn_hides_the_lens(husky: Model) -> None:
    lens = husky.link("eye_vision_camera")
    heights = [
        visual.pose.position[2] + visual.geometry.size[2] / 2
        for visual in lens.visuals
        if isinstance(visual.geometry, Box)
    ]
    assert heights
    assert max(heights) < lens.sensors[0].pose.position[2]


def test_the_robot_stands_on_its_wheels_where_its_file_puts_it(husky: Model) -> None:
    assert husky.pose.position[2] == pytest.approx(0.17775 - 0.035, abs=1e-3)


# -- the room


def test_the_floor_is_flat_at_height_0(room: Scene) -> None:
    (floor,) = room.model("floor").links[0].collisions
    assert isinstance(floor.geometry, Box)
    assert floor.pose.position[2] + floor.geometry.size[2] / 2 == pytest.approx(0)
    assert room.model("carpet").links[0].collisions == ()


def test_the_walls_leave_the_room_its_size(room: Scene) -> None:
    walls = {wall.name: wall for wall in room.model("walls").links[0].collisions}
    assert set(walls) == {"west", "east", "south", "north"}

    def inside(name: str, axis: int, sign: int) -> float:
        wall = walls[name]
        assert isinstance(wall.geometry, Box)
        return wall.pose.position[axis] + sign * wall.geometry.size[axis] / 2

    assert inside("west", 0, 1) == pytest.approx(-5.476)
    assert inside("east", 0, -1) == pytest.approx(6.748)
    assert inside("south", 1, 1) == pytest.approx(-7.533)
    assert inside("north", 1, -1) == pytest.approx(4.378)


@pytest.mark.parametrize(("name", "y", "yaw"), [("left_vr_screen", -2.44, pi), ("right_vr_screen", 2.44, 0)])
def test_the_screens_stand_to_both_sides(room: Scene, name: str, y: float, yaw: float) -> None:
    screen = room.model(name)
    assert screen.pose.position == (0, y, 0.65)
    assert abs(screen.pose.yaw) == pytest.approx(yaw)
    glass = room.visuals[f"{name}/body/screen_glass"]
    assert (glass.geometry, glass.pose.position) == (Box((1.96, 0.015, 1.1)), (0, 0.02, 0.75))
    assert glass.rgba == (0, 0, 1, 1)
    assert (screen.pose @ glass.pose).position == pytest.approx((0, y * 2.46 / 2.44, 1.4))


def test_the_left_screen_is_on_the_left_of_a_robot_that_looks_along_minus_x(room: Scene) -> None:
    robot = Pose.from_rpy((0, 0, 0), 0, 0, pi)
    _, to_the_left, _ = (robot.inverse() @ room.model("left_vr_screen").pose).position
    assert to_the_left == pytest.approx(2.44)


def test_no_other_part_of_a_screen_is_between_the_glass_and_the_room(room: Scene) -> None:
    body = room.model("right_vr_screen").link("body")
    glass = next(visual for visual in body.visuals if visual.name == "screen_glass")

    def span(visual: object, axis: int) -> tuple[float, float]:
        size, middle = visual.geometry.size[axis], visual.pose.position[axis]  # type: ignore[attr-defined]
        return middle - size / 2, middle + size / 2

    face, _ = span(glass, 1)
    for part in body.visuals:
        before = span(part, 1)[0] < face
        covers = all(
            span(part, axis)[0] < span(glass, axis)[1] - 1e-9
            and span(part, axis)[1] > span(glass, axis)[0] + 1e-9
            for axis in (0, 2)
        )
        assert not (before and covers), part.name


def test_a_robot_stops_at_the_stand_about_60_cm_from_the_glass(room: Scene) -> None:
    body = room.model("right_vr_screen").link("body")
    heights, fronts = [], []
    for part in body.collisions:
        assert isinstance(part.geometry, Box)
        heights.append(0.65 + part.pose.position[2] - part.geometry.size[2] / 2)
        fronts.append(part.pose.position[1] - part.geometry.size[1] / 2)
    assert min(heights) == pytest.approx(0)
    stops_at = 1.0074 / 2 + (0.02 - min(fronts))
    assert stops_at == pytest.approx(0.6, abs=0.02)


def test_nothing_in_the_room_is_red(room: Scene, husky: Model) -> None:
    for path, visual in room.with_model(husky).visuals.items():
        hue, saturation, _ = colorsys.rgb_to_hsv(*visual.rgba[:3])
        assert saturation * 255 < 30 or 10 < hue * 360 < 350, path
