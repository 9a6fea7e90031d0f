"""Values of robots and rooms that contradict other values of the same file are reported, all in one check."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Level
from nrp_core.world.drives.implausible import implausible_drives
from nrp_core.world.scene.sdf import read_model

BUMP = """<sensor name="bump" type="contact"><update_rate>10</update_rate>
  <contact><collision>masst</collision></contact></sensor>
<sensor name="scan" type="ray"><update_rate>10</update_rate><ray>
  <scan><horizontal><samples>9</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan>
  <range><min>0</min><max>0.05</max></range></ray></sensor>
<sensor name="camera" type="camera">"""
EDITS = [
    ("husky.sdf", '<sensor name="camera" type="camera">', BUMP,
     "feels the collision 'masst', which its link 'eye_vision_camera' does not have; did you mean 'mast'?"),
    ("husky.sdf", "", "", "the sensor 'scan' of 'husky' measures up to 0.05 m, and the robot is 1.3"),
    ("husky.sdf", "<pose>-0.0856132 -0.000839955 0.238145", "<pose>-85.6132 -0.839955 238.145",
     "the centre of mass of the link 'base_link' of 'husky' is 253 m from the link"),
    ("husky.sdf", "<wheelSeparation>0.5709<", "<wheelSeparation>0.2855<",
     "has a wheel separation of 0.285 m, and its wheels are 0.571 m apart"),
    ("room.sdf", "<diffuse>0.7 0.7 0.7 1<", "<diffuse>0 0 0 1<", "the lights of the room are black"),
    ("room.sdf", "0.004</size></box>", "0.004</size></box><sphere><radius>1</radius></sphere>",
     "a <geometry> has one shape: <box> is used, and not <sphere> [NRP263]"),
    ("screen.sdf", "BlueGlow</name></script></material>",
     "BlueGlow</name></script></material><transparency>1</transparency>",
     "'left_vr_screen/body/screen_glass', which 'left_red' colours, is invisible at the start"),
]  # fmt: skip


def said(husky: Path, *settings: str) -> list[str]:
    found = validate_file(husky / "experiment.yaml", settings)
    return [str(one) for one in found if one.level is not Level.NOTE]


def test_each_value_of_a_robot_or_room_that_contradicts_another_is_reported(husky: Path) -> None:
    for file, old, new, _ in EDITS:
        text = (husky / file).read_text()
        assert old in text
        (husky / file).write_text(text.replace(old, new, 1))
    found = said(husky)
    for *_, words in EDITS:
        assert any(words in message for message in found), words


def test_a_drive_that_no_engine_can_move_is_refused_before_the_run(husky: Path) -> None:
    (message,) = said(husky, "world.robots.husky.fixed=true")
    assert "cannot move 'husky', whose base does not float freely [NRP209]" in message
    assert said(husky, "world.robots.husky.fixed=false") == []


@pytest.mark.parametrize(
    ("left", "right", "is_reported"), [("left", "right", False), ("right", "left", True)]
)
def test_wheels_on_the_wrong_side_are_reported(husky: Path, left: str, right: str, is_reported: bool) -> None:
    path, pairs = (
        husky / "husky.sdf",
        (("back", "Left"), ("back", "Right"), ("front", "Left"), ("front", "Right")),
    )
    text = path.read_text()
    for end, side in pairs:
        joint = f"<{end}{side}Joint>{end}_"
        assert joint in text
        text = text.replace(f"{joint}{side.lower()}", f"{joint}{left if side == 'Left' else right}")
    path.write_text(text)
    found = list(implausible_drives(read_model(path), 0.02))
    assert any("has its left wheels on the right" in one for one in found) == is_reported


def test_arguments_of_a_file_without_any_are_refused(husky: Path) -> None:
    (message,) = said(
        husky,
        "world.robots.husky.args={colour: red}",
        "transfer_functions=[]",
        "events=null",
        "criteria=null",
        "aliases=null",
        "comparison.vary=null",
    )
    assert "husky.sdf:5: this is not a xacro file, so it has no arguments" in message


def test_a_projection_that_is_made_twice_is_reported(husky: Path) -> None:
    path = husky / "brain.py"
    path.write_text(path.read_text() + "\nconnect([4], [7], weight=1.05e-4)\n")
    (message,) = said(husky)
    assert "two projections from" in message
    assert "have the label '[4] to [7]'" in message
