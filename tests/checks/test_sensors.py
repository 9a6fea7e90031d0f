"""Sensors that cannot see the room are doubted; others are not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Code, Finding, Level

RIG = "<pose>0 0 0.132 0 0 0</pose>"
HOUSING = "<pose>0 0 0.1 0 0 0</pose>\n        <geometry><box><size>0.06 0.12 0.05</size></box></geometry>"
AHEAD = HOUSING.replace("0 0 0.1 ", "0.135 0 0.132 ").replace("0.06 0.12 0.05", "0.06 0.09 0.08")
"""It covers a quarter of the image."""
SCANNER = '<sensor name="scanner" type="ray">'
SIZE, RATE = "<width>320</width><height>240</height>", "<update_rate>30</update_rate>"
PIONEER = "bodies/pioneer.sdf"

Slalom = Callable[[str, str, str], list[Finding]]


def doubts(findings: list[Finding], *codes: Code) -> list[str]:
    return [one.message for one in findings if one.code in codes]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (RIG, RIG, ""),
        (RIG, "<pose>0.16 0 -0.13 0 0 0</pose>", "stands inside 'husky/"),
        (RIG, "<pose>0 0 -0.2 0 0 0</pose>", "stands inside 'husky/base_link', 0."),
        (HOUSING, AHEAD, "sees its own housing in the middle of its images, from 0.11 m: it covers"),
        (RIG, "<pose>0 0 0.132 0 -1.5708 0</pose>", "looks up: "),
        (RIG, "<pose>0 0 0.132 0 0.3 0</pose>", ""),  # it sees more of the floor
        (RATE, "<update_rate>60</update_rate>", ""),
        (SIZE, "<width>16</width><height>1</height>", ""),
    ],
)
def test_cameras_that_cannot_show_the_room_are_doubted(husky: Path, old: str, new: str, words: str) -> None:
    path = husky / "husky.sdf"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    found = doubts(validate_file(husky / "experiment.yaml"), Code.NRP298)
    assert len(found) == bool(words)
    assert all(words in one for one in found), found


def test_only_the_camera_inside_a_body_is_doubted_of_two_with_one_name(husky: Path) -> None:
    added = "world.robots.husky.add_sensors=[{type: camera, name: camera, link: base_link}]"
    (found,) = doubts(validate_file(husky / "experiment.yaml", [added]), Code.NRP298)
    assert "the camera 'camera' on 'husky/base_link' stands inside" in found


def test_a_robot_with_wheels_and_without_weight_is_doubted(slalom: Slalom) -> None:
    found = slalom("slalom_pioneer/hall.sdf", "<gravity>0 0 -9.8", "<gravity>0 0 0")
    assert "has wheels that nothing presses on the ground" in "".join(doubts(found, Code.NRP298))


@pytest.mark.parametrize(
    ("pose", "words"),
    [
        ("0 0 1.3 0 0 0", "sees nothing at the start, whatever the heading of 'pioneer'"),
        ("0 0 0 0 -1.5708 0", "looks up: "),
        ("0 0 0 0 0.5 0", ""),  # sees the floor
        ("0 0 0 0 0 3.14159", ""),
    ],
)
def test_scanners_that_pass_over_the_room_are_doubted(slalom: Slalom, pose: str, words: str) -> None:
    found = doubts(slalom(PIONEER, SCANNER, f"{SCANNER}<pose>{pose}</pose>"), Code.NRP298)
    assert len(found) == bool(words)
    assert all("the scanner 'scanner' on 'pioneer/laser'" in one and words in one for one in found)


def test_a_scanner_between_the_wheels_is_noted_with_the_wheel(
    slalom: Slalom,
) -> None:
    low = '<link name="laser">\n      <pose>-0.10 0 0.05'
    (found,) = [
        one
        for one in slalom(PIONEER, '<link name="laser">\n      <pose>0.10 0 0.22', low)
        if one.code is Code.NRP298
    ]
    assert found.level is Level.NOTE
    assert (
        "sees its own robot with 51% of its beams, mostly the link 'left_wheel', from 0.15 m" in found.message
    )
