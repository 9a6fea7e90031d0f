"""Things of the room that are only seen or only felt are noted."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from nrp_core.findings import Code, Finding, Level

HALL = "slalom_pioneer/hall.sdf"
BOX = "<geometry><box><size>0.5 0.5 1</size></box></geometry>"
SEEN, FELT = f'<visual name="v">{BOX}</visual>', f'<collision name="c">{BOX}</collision>'
HIDDEN = SEEN.replace("</visual>", "<transparency>1</transparency></visual>")
ADDED = (
    "{model: ../bodies/pioneer.sdf, add_sensors: [{type: camera, link: laser, pose: [0.1, 0, 0, 0, 0, 0]}]}"
)

Slalom = Callable[[str, str, str], list[Finding]]


def notes(found: list[Finding]) -> list[str]:
    return [one.message for one in found if one.code is Code.NRP298 and one.level is Level.NOTE]


@pytest.mark.parametrize(
    ("shapes", "z", "words"),
    [
        (SEEN, 0.5, "robots pass through 'post': seen, and without collision shapes"),
        (SEEN + FELT, 0.5, ""),
        (SEEN, 5.0, ""),  # hangs above them
        (SEEN, -0.48, ""),  # a mark on the ground
        (SEEN.replace("0.5 0.5 1", "90 90 20"), 0.0, ""),  # a sky
        (HIDDEN, 0.5, ""),
        (FELT, 0.5, ""),  # there is no camera
    ],
)
def test_a_thing_that_robots_drive_through_is_noted(
    slalom: Slalom, shapes: str, z: float, words: str
) -> None:
    link = f'<static>true</static><pose>5 0 {z} 0 0 0</pose><link name="link">{shapes}</link>'
    post = f'<model name="post">{link}</model>'
    found = [one for one in notes(slalom(HALL, "</world>", f"{post}</world>")) if "'post'" in one]
    assert found == [words] * bool(words)


def test_a_goal_that_robots_drive_into_is_not_noted(slalom: Slalom) -> None:
    goal = "criteria:\n  there:\n    near: {model: pioneer, other: post, within: 1 m}"
    slalom("slalom_pioneer/experiment.yaml", "criteria:", goal)
    link = f'<static>true</static><pose>5 0 0.5 0 0 0</pose><link name="link">{SEEN}</link>'
    assert notes(slalom(HALL, "</world>", f'<model name="post">{link}</model></world>')) == []


def test_a_robot_that_is_held_drives_through_nothing(slalom: Slalom) -> None:
    slalom("bodies/pioneer.sdf", "<parent>base</parent><child>laser", "<parent>world</parent><child>base")
    link = f'<static>true</static><pose>5 0 0.5 0 0 0</pose><link name="link">{SEEN}</link>'
    found = notes(slalom(HALL, "</world>", f'<model name="post">{link}</model></world>'))
    assert not any("'post'" in one for one in found)


@pytest.mark.parametrize(
    ("shapes", "words"),
    [
        (FELT, "no image shows 'post': touched, and without anything to see"),
        (FELT + HIDDEN, "no image shows 'post': touched, and without anything to see"),
        (FELT + SEEN, ""),
    ],
)
def test_a_thing_that_no_camera_sees_is_noted(slalom: Slalom, shapes: str, words: str) -> None:
    slalom("slalom_pioneer/experiment.yaml", "{model: ../bodies/pioneer.sdf}", ADDED)
    link = f'<static>true</static><pose>5 0 0.5 0 0 0</pose><link name="link">{shapes}</link>'
    post = f'<model name="post">{link}</model>'
    found = [one for one in notes(slalom(HALL, "</world>", f"{post}</world>")) if "'post'" in one]
    assert found == [words] * bool(words)


def test_exchanged_files_of_a_room_and_a_robot_are_named(slalom: Slalom) -> None:
    text = "  scene: hall.sdf\n  robots:\n    pioneer: {model: ../bodies/pioneer.sdf}"
    swapped = "  scene: ../bodies/pioneer.sdf\n  robots:\n    pioneer: {model: hall.sdf}"
    found = slalom("slalom_pioneer/experiment.yaml", text, swapped)
    assert any("is 'scene' the file of a robot?" in one.message for one in found)


OUTWARD = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
INWARD = "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n"


@pytest.mark.parametrize(
    ("faces", "size", "x", "with_camera", "is_reported"),
    [
        (INWARD, 1, 5, True, True),
        (OUTWARD, 1, 5, True, False),
        (INWARD, 40, -10, True, False),  # the robot is inside, as in a sky
        (INWARD, 1, 5, False, False),
    ],
)
def test_a_mesh_that_is_turned_inside_out_is_doubted(
    slalom: Slalom, tmp_path: Path, faces: str, size: int, x: int, with_camera: bool, is_reported: bool
) -> None:
    corners = f"v 0 0 0\nv {size} 0 0\nv 0 {size} 0\nv 0 0 {size}\n"
    (tmp_path / "slalom_pioneer/post.obj").write_text(corners + faces)
    if with_camera:
        slalom("slalom_pioneer/experiment.yaml", "{model: ../bodies/pioneer.sdf}", ADDED)
    mesh = '<visual name="v"><geometry><mesh><uri>post.obj</uri></mesh></geometry></visual>'
    link = f'<static>true</static><pose>{x} {x / 5 - 1} -1 0 0 0</pose><link name="link">{mesh}</link>'
    found = slalom(HALL, "</world>", f'<model name="post">{link}</model></world>')
    words = "the mesh of the visual 'v' of 'post/link' faces inward"
    assert [one.level for one in found if words in one.message] == [Level.WARNING] * is_reported
