"""Values of robots and rooms that contradict other values of the same file are reported, all in one check."""

from __future__ import annotations

from pathlib import Path

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Level

EDITS = [
    ("husky.sdf", "<pose>-0.0856132 -0.000839955 0.238145", "<pose>-85.6132 -0.839955 238.145",
     "the centre of mass of the link 'base_link' of 'husky' is 253 m from the link"),
    ("room.sdf", "0.004</size></box>", "0.004</size></box><sphere><radius>1</radius></sphere>",
     "a <geometry> has one shape: <box> is used, and not <sphere> [NRP383]"),
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
