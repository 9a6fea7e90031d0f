"""Wheels, sensors and poses that are valid, but that do not fit the robot, are reported."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import nrp_experiments.braitenberg_husky
import pytest

from nrp_core import Model, Pose, Scene, read_model, read_scene
from nrp_core.findings import Code
from nrp_core.world.drives.implausible import implausible_drives, weightless_wheels
from nrp_core.world.robot_setup import Fitting, JointControl, fitted
from nrp_core.world.scene.implausible import implausible
from nrp_core.world.scene.model import Box, Collision, Joint, Sphere

_SHIPPED = Path(nrp_experiments.braitenberg_husky.__path__[0])
_AXIS = "<axis><xyz>0 1 0</xyz></axis>"


def _husky(folder: Path, old: str = "", new: str = "") -> Model:
    text = (_SHIPPED / "husky.sdf").read_text("utf-8")
    assert old in text
    path = folder / "husky.sdf"
    path.write_text(text.replace(old, new, 1), "utf-8")
    return read_model(path)


def _sentences(model: Model, timestep_s: float = 0.02) -> list[str]:
    found = [str(warning) for warning in model.warnings]
    found += [sentence for _, sentence in implausible(Scene((model,)), [model.name])]
    return found + list(implausible_drives(model, timestep_s))


def test_the_husky_that_ships_fits_its_drive(tmp_path: Path) -> None:
    assert _sentences(_husky(tmp_path)) == []


def test_a_wheel_whose_axis_points_right_is_turned_the_other_way_and_is_not_reported(tmp_path: Path) -> None:
    assert _sentences(_husky(tmp_path, _AXIS, "<axis><xyz>0 -1 0</xyz></axis>")) == []


@pytest.mark.parametrize(
    ("pattern", "mode", "words"),
    [
        (
            "back_left_joint",
            "velocity",
            "moves the joint 'back_left_joint', and so does a velocity controller on",
        ),
        (
            ".*",
            "trajectory",
            "'back_left_joint' (and 3 more of its joints), and so does a trajectory controller on",
        ),
    ],
)
def test_wheels_that_a_controller_moves_as_well_are_reported(
    tmp_path: Path, pattern: str, mode: Literal["velocity", "trajectory"], words: str
) -> None:
    model = fitted(_husky(tmp_path), Fitting(control=((pattern, JointControl(mode)),)))
    (sentence,) = _sentences(model)
    assert words in sentence


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "<wheelDiameter>0.3555",
            "<wheelDiameter>0.17775",
            "has wheels of 0.178 m diameter, and 'back_left_w",
        ),
        (
            "<wheelSeparation>0.5709",
            "<wheelSeparation>570.9",
            "wheel separation of 571 m, and its wheels are 0.571",
        ),
        (_AXIS, "<axis><xyz>0 0 1</xyz></axis>", "the joint 'back_left_joint' turns about the vertical"),
        (_AXIS, "<axis><xyz>1 0 0</xyz></axis>", "'back_left_joint' turns about the x axis, in which"),
        ('back_left_joint" type="continuous"', 'back_left_joint" type="fixed"', "'back_left_joint' is fixed"),
        ("<backLeftJoint>back_left", "<backLeftJoint>back_right", "'back_right_joint' on both sides"),
        (
            "<pose>-0.256 0.285475 0.035 0 0 0<",
            "<pose>-0.256 0.285475 -0.535475 0 0 0<",
            "cannot stand on both sides: its lowest wheels are 'back_left_joint' at z -0.535 m and",
        ),
        ("<commandTimeout>0.1<", "<commandTimeout>0.001<", "stops 0.001 s after a command"),
        (
            "wheelSeparation>0.5709</wheelSep",
            "wheelSeperation>0.5709</wheelSep",
            "did you mean <wheelSeparation>",
        ),
        ("<pose>0 0 0.132 0 0 0<", "<pose>0 0 132 0 0 0<", "the sensor 'camera' of 'husky' is 132 m from"),
        (
            "<pose>-0.16 0 0.23 0 0 0<",
            "<pose>-0.16 0 0.23 0 0 90<",
            "an angle of 90 rad, more than a turn",
        ),
        ("<format>R8G8B8<", "<format>RGB<", "the image format 'RGB' is not simulated: images are R8G8B8"),
        ("<pose>0 0 0.143 0 0 0<", "<static>true</static><pose>0 0 0.143 0 0 0<", "'husky' is static"),
    ],
)
def test_what_does_not_fit_is_reported_once(tmp_path: Path, old: str, new: str, words: str) -> None:
    if "wheelSeperation" in new:
        old, new = f"<{old}aration>", f"<{new.replace('</wheelSep', '</wheelSeper')}ation>"
    (sentence,) = _sentences(_husky(tmp_path, old, new))
    assert words in sentence


@pytest.mark.parametrize(
    ("roll_rad", "found"), [(3.14159, ["180 degrees"]), (1.5708, ["90 degrees"]), (0.5, [])]
)
def test_a_robot_that_does_not_start_on_its_wheels_is_reported(
    tmp_path: Path, roll_rad: float, found: list[str]
) -> None:
    model = replace(_husky(tmp_path), pose=Pose.from_rpy((0.0, 0.0, 1.0), roll_rad, 0.0, 0.0))
    assert [words in sentence for words, sentence in zip(found, _sentences(model), strict=True)] == [
        True
    ] * len(found)


@pytest.mark.parametrize(
    ("gravity", "words"),
    [
        ((0.0, 0.0, -98.0), "gravity is 0 0 -98 m/s^2, more than on Jupiter"),
        ((0.0, -9.8, 0.0), "gravity is 0 -9.8 0 m/s^2: it points to the side"),
    ],
)
def test_gravity_of_no_planet_is_reported(gravity: tuple[float, float, float], words: str) -> None:
    assert [sentence for _, sentence in implausible(Scene((), gravity=gravity), [])] == [words]


@pytest.mark.parametrize(("wind", "found"), [("5 0 0", 1), ("0 0 0", 0)])
def test_wind_that_is_not_simulated_is_reported(tmp_path: Path, wind: str, found: int) -> None:
    path = tmp_path / "room.sdf"
    path.write_text(
        '<sdf version="1.9"><world name="w">'
        f"<wind><linear_velocity>{wind}</linear_velocity></wind></world></sdf>"
    )
    assert [warning.code for warning in read_scene(path).warnings] == [Code.NRP263] * found


_NO_SHAPES = {
    "all": ("none of 'back_left_wheel' and the others has a shape", 4, None),
    "one": ("a wheel that touches nothing: 'back_left_wheel'", 1, None),
    "none": ("", 0, None),
    "on a skid": ("", 4, 0.0),
}


@pytest.mark.parametrize("case", _NO_SHAPES)
def test_wheels_that_touch_nothing_are_reported_unless_the_body_slides(tmp_path: Path, case: str) -> None:
    words, bare, friction = _NO_SHAPES[case]
    model = _husky(tmp_path)
    wheels = [link.name for link in model.links if link.name.endswith("_wheel")][:bare]
    links = [
        replace(link, collisions=())
        if link.name in wheels
        else replace(link, collisions=tuple(
            one if friction is None else replace(one, friction=friction) for one in link.collisions
        ))
        for link in model.links
    ]  # fmt: skip
    said = list(implausible_drives(replace(model, links=tuple(links)), 0.02))
    assert [words in sentence for sentence in said] == [True] * bool(words)


def test_a_wheel_whose_shape_is_on_a_link_that_is_fixed_to_it_touches_the_ground(tmp_path: Path) -> None:
    model = _husky(tmp_path)
    tyres, joints = [], []
    for link in model.links:
        if link.name.endswith("_wheel"):
            tyres.append(replace(link, name=f"{link.name}_tyre", sensors=()))
            joints.append(Joint(f"{link.name}_mount", "fixed", link.name, tyres[-1].name, link.pose))
    rims = [replace(one, collisions=()) if f"{one.name}_tyre" in {tyre.name for tyre in tyres} else one
            for one in model.links]  # fmt: skip
    made = replace(model, links=(*rims, *tyres), joints=(*model.joints, *joints))
    assert len(tyres) == 4
    assert list(implausible_drives(made, 0.02)) == []


def test_wheels_that_do_not_reach_the_ground_are_reported(tmp_path: Path) -> None:
    """The wheels reach 0.14275 m below the axle of the body, and the chassis, then, 0.03375 m below it."""
    text = (_SHIPPED / "husky.sdf").read_text("utf-8")
    (path := tmp_path / "high.sdf").write_text(text.replace("0.285475 0.035 ", "0.285475 0.285 "), "utf-8")
    (sentence,) = _sentences(read_model(path))
    gap_m = (0.285 - 0.17775) + 0.03375
    assert f"wheels that do not reach the ground: 'base_link' reaches {gap_m:.2g} m lower" in sentence


@pytest.mark.parametrize(
    ("low_m", "geometry", "friction", "is_reported"),
    [
        (0.02, Box((0.4, 0.3, 0.1)), 1.0, True),
        (0.005, Box((0.4, 0.3, 0.1)), 1.0, False),  # as in files with rounded numbers
        (0.02, Box((0.4, 0.3, 0.1)), 0.0, False),  # a runner that slides
        (0.02, Sphere(0.05), 1.0, False),  # a caster
    ],
)
def test_a_body_that_lies_on_the_ground_beside_its_wheels_is_reported(
    tmp_path: Path, low_m: float, geometry: Box | Sphere, friction: float, is_reported: bool
) -> None:
    model = _husky(tmp_path)
    lowest_m = 0.035 - 0.17775 - low_m
    shape = Collision("below", geometry, Pose((0.0, 0.0, lowest_m + 0.05)), friction=friction)
    base = model.link("base_link")
    low = replace(base, collisions=(*base.collisions, shape))
    links = [low if link.name == base.name else link for link in model.links]
    said = list(implausible_drives(replace(model, links=tuple(links)), 0.02))
    assert [f"reaches {low_m:.2g} m lower" in sentence for sentence in said] == [True] * is_reported


def test_wheels_in_one_place_are_reported(tmp_path: Path) -> None:
    text = (_SHIPPED / "husky.sdf").read_text("utf-8")
    (path := tmp_path / "narrow.sdf").write_text(text.replace("0.285475 0.035 ", "0 0.035 "), "utf-8")
    (sentence,) = [one for one in _sentences(read_model(path)) if "right wheels" in one]
    assert "has its left and right wheels in one place, that of 'back_left_wheel'" in sentence


@pytest.mark.parametrize(("torque", "is_reported"), [("35", False), ("0.1", False), ("0.035", True)])
def test_a_torque_that_moves_nothing_is_reported(tmp_path: Path, torque: str, is_reported: bool) -> None:
    """The acceleration is 4 wheels * torque / (0.17775 m * 45.4 kg): 0.05 m/s^2 for 0.1 N m."""
    said = _sentences(_husky(tmp_path, "<torque>35<", f"<torque>{torque}<"))
    assert ["has a torque of at most 0.035 N m, which accelerates" in one for one in said] == [
        True
    ] * is_reported


@pytest.mark.parametrize(
    ("gravity_z", "pulled", "words"),
    [(-9.8, True, ""), (0.0, True, "gravity is 0"), (-9.8, False, "gravity pulls no link of it")],
)
def test_wheels_that_no_weight_presses_on_the_ground_are_reported(
    tmp_path: Path, gravity_z: float, pulled: bool, words: str
) -> None:
    model = _husky(tmp_path)
    model = replace(model, links=tuple(replace(link, gravity=pulled) for link in model.links))
    found = list(weightless_wheels(model, (0.0, 0.0, gravity_z)))
    assert len(found) == bool(words)
    assert all("has wheels that nothing presses on the ground: " in one and words in one for one in found)
