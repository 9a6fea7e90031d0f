"""What `nrp inspect` tells of a scene."""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import pytest

from nrp_core.scene.model import Scene
from nrp_core.scene.outline import Entry, SceneTopic, outline, topics_of
from nrp_core.scene.sdf import read_scene

HUSKY = Path(str(files("nrp_experiments.braitenberg_husky"))) / "husky.sdf"


def test_the_tree_follows_the_joints() -> None:
    text = "\n".join(outline(read_scene(HUSKY), "husky.sdf").lines())
    lines = text.splitlines()
    assert lines[0] == "husky.sdf: 1 model that moves; gravity 0 0 -9.8 m/s²"
    wheel = next(i for i, line in enumerate(lines) if "joint back_left_joint, continuous about 0 1 0" in line)
    assert "back_left_wheel: 2.636 kg" in lines[wheel + 1]
    assert lines[wheel].index("joint") < lines[wheel + 1].index("back")
    assert "camera 'camera', 30 Hz" in text
    assert "wheel drive 'husky_diff_controller'" in text


def test_topics_are_served_or_listened_to() -> None:
    (husky,) = read_scene(HUSKY).models
    assert topics_of(husky) == [
        SceneTopic("/husky/camera", False, "camera"),
        SceneTopic("/husky/camera/camera_info", False, "camera"),
        SceneTopic("/husky/cmd_vel", True, "husky_diff_controller"),
        SceneTopic("/husky/odom", False, "husky_diff_controller"),
        SceneTopic("/husky/wheel_speeds", False, "husky_diff_controller"),
        SceneTopic("/husky/joint_states", False, "joint states"),
    ]


def test_every_link_of_every_model_is_reported_once(world: Callable[..., Scene]) -> None:
    arm = (
        '<link name="upper"><inertial/></link><link name="lower"><inertial/></link>'
        '<joint name="elbow" type="revolute"><parent>upper</parent><child>lower</child>'
        "<axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>2</upper></limit></axis></joint>"
        '<joint name="hook" type="fixed"><parent>world</parent><child>upper</child></joint>'
    )
    rock = '<model name="rock"><static>1</static><link name="l"/></model>'
    text = "\n".join(outline(world(f'<model name="arm">{arm}</model>{rock}'), "room").lines())
    for name in ("upper: ", "lower: ", "rock at "):
        assert text.count(name) == 1
    assert "joint elbow, revolute about 0 1 0, -1 to 2 rad" in text
    assert "rock at 0 0 0: nothing to see; nothing to touch" in text


def test_an_empty_world_is_reported_as_empty(world: Callable[..., Scene]) -> None:
    assert list(outline(world(""), "room").lines()) == ["room: empty; gravity 0 0 -9.8 m/s²"]


@pytest.mark.parametrize(
    ("entry", "lines"),
    [
        (Entry("a"), ["a"]),
        (Entry("a", (Entry("b", (Entry("c"),)), Entry("d"))), ["a", "├─ b", "│ └─ c", "└─ d"]),
    ],
)
def test_branches_are_drawn(entry: Entry, lines: list[str]) -> None:
    assert [line.replace("│  ", "│ ") for line in entry.lines()] == lines
