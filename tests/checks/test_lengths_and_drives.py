"""Lengths in another unit and drives that cannot move their robot are reported; shipped robots are not."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import nrp_experiments.bodies
import nrp_experiments.braitenberg_husky
import pytest

from nrp_core import Model, Pose, read_model
from nrp_core.checks.subjects.drives import wrong_drives
from nrp_core.checks.subjects.lengths import unlikely_lengths
from nrp_core.checks.validate import validate_file
from nrp_core.findings import Code
from nrp_core.world.robot_setup import JointControl, RobotSetup, set_up_robot

BODIES = Path(nrp_experiments.bodies.__path__[0])
HUSKY = Path(nrp_experiments.braitenberg_husky.__path__[0]) / "husky.sdf"
TYRE = """<collision name="tyre">
        <pose>0 0 0 1.5707963267948966 0 0</pose>
        <geometry><cylinder><radius>0.0975</radius><length>0.04</length></cylinder></geometry>
      </collision>"""
BODY = "<size>0.44 0.28 0.17</size>"


def edited(folder: Path, file: Path, old: str = "", new: str = "", count: int = 1) -> Model:
    text = file.read_text("utf-8")
    assert old in text
    (folder / file.name).write_text(text.replace(old, new, count), "utf-8")
    return read_model(folder / file.name)


def codes(model: Model) -> list[Code]:
    found = (*unlikely_lengths(model, is_robot=True), *wrong_drives(model))
    return [code for code, _ in found]


@pytest.mark.parametrize("file", [*sorted(BODIES.glob("*.sdf")), HUSKY], ids=lambda file: file.name)
def test_the_bodies_that_ship_are_not_reported(file: Path) -> None:
    weightless = [Code.NRP371] if file.name == "worm_in_water.sdf" else []  # its inertia plays no part
    assert codes(read_model(file)) == weightless


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        (BODY, "<size>0.9 0.6 0.3</size>", None),
        (BODY, "<size>45 37 24</size>", Code.NRP371),  # cm
        (BODY, "<size>450 370 240</size>", Code.NRP371),  # mm
        ("<pose>-0.045 0 0.055 0 0 0</pose>", "<pose>-45 0 55 0 0 0</pose>", Code.NRP381),
        ("<pose>-0.03 0 0.137 0 0 0</pose>", "<pose>-0.3 0 1.37 0 0 0</pose>", None),
        (TYRE, "", Code.NRP375),
    ],
)
def test_a_value_of_the_pioneer_in_another_unit_is_reported(
    tmp_path: Path, old: str, new: str, code: Code | None
) -> None:
    assert codes(edited(tmp_path, BODIES / "pioneer.sdf", old, new)) == [code] * (code is not None)


@pytest.mark.parametrize(
    ("roll", "found"), [(0.0, []), (0.6, []), (1.0, [Code.NRP370]), (3.14159, [Code.NRP370])]
)
def test_a_robot_with_wheels_that_starts_tilted_is_reported(
    tmp_path: Path, roll: float, found: list[Code]
) -> None:
    model = read_model(HUSKY, pose=Pose.from_rpy((0.0, 0.0, 1.0), roll, 0.0, 0.0))
    assert codes(model) == found


@pytest.mark.parametrize(("low_m", "is_reported"), [(0.05, False), (-0.15, True)])
def test_a_robot_that_rests_on_its_body_is_reported(tmp_path: Path, low_m: float, is_reported: bool) -> None:
    """The wheels of the pioneer reach 9.75 cm below its origin."""
    skid = f'<collision name="skid"><pose>0 0 {low_m} 0 0 0</pose><geometry><sphere><radius>0.02</radius>'
    model = edited(
        tmp_path, BODIES / "pioneer.sdf", '<collision name="body">',
        skid + '</sphere></geometry></collision><collision name="body">',
    )  # fmt: skip
    assert codes(model) == [Code.NRP375] * is_reported


@pytest.mark.parametrize(("pattern", "mode"), [("back_left_joint", "velocity"), (".*", "trajectory")])
def test_wheels_that_a_controller_moves_too_are_reported(
    pattern: str, mode: Literal["velocity", "trajectory"]
) -> None:
    model = set_up_robot(read_model(HUSKY), RobotSetup(control=((pattern, JointControl(mode)),)))
    assert codes(model) == [Code.NRP376]


def test_two_controllers_of_one_joint_are_reported(tmp_path: Path) -> None:
    model = edited(tmp_path, BODIES / "arm.sdf", "<joint_name>elbow", "<joint_name>shoulder")
    assert codes(model) == [Code.NRP376]


@pytest.mark.one_of(2)
@pytest.mark.parametrize(("step", "found"), [("2 ms", []), ("20 ms", [Code.NRP372]), ("2 us", [Code.NRP372])])
def test_steps_of_physics_in_another_unit_are_reported(husky: Path, step: str, found: list[Code]) -> None:
    findings = validate_file(husky / "experiment.yaml", [f"world.options.timestep={step}"])
    assert [one.code for one in findings if one.code is Code.NRP372] == found
