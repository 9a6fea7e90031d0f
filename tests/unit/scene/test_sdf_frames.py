from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from math import pi
from pathlib import Path

import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model

ModelReader = Callable[..., Model]
TURN = pi / 2


def link(name: str, inside: str = "") -> str:
    return f'<link name="{name}">{inside}<inertial/></link>\n'


@pytest.mark.parametrize(
    ("pose", "expected"),
    [
        ("<pose>1 2 3 0 0 0.5</pose>", Pose.from_rpy((1, 2, 3), 0, 0, 0.5)),
        ("<pose/>", Pose()),
        ("", Pose()),
        ('<pose degrees="true">1 2 3 10 20 30</pose>', Pose.from_rpy((1, 2, 3), pi / 18, pi / 9, pi / 6)),
        (
            '<pose rotation_format="euler_rpy" degrees="1">0 0 0 0 0 90</pose>',
            Pose.from_rpy((0, 0, 0), 0, 0, TURN),
        ),
        ('<pose rotation_format="quat_xyzw">1 2 3 0 0 2 2</pose>', Pose.from_rpy((1, 2, 3), 0, 0, TURN)),
        ("<pose frame=''>1 2 3 0 0 0</pose>", Pose((1, 2, 3))),
    ],
)
def test_poses_are_read_in_every_notation(model: ModelReader, pose: str, expected: Pose) -> None:
    read = model(link("base", pose)).links[0].pose
    assert read.position == pytest.approx(expected.position)
    assert read.orientation == pytest.approx(expected.orientation)


@pytest.mark.parametrize(
    "pose",
    [
        "<pose>1 2 3</pose>",
        "<pose>1 2 3 0 0 nan</pose>",
        '<pose rotation_format="quat_xyzw">1 2 3 0 0 0</pose>',
        '<pose rotation_format="quat_xyzw">1 2 3 0 0 0 0</pose>',
        '<pose rotation_format="wxyz">1 2 3 0 0 0</pose>',
        '<pose relative_to="arm">0 0 0 0 0 0</pose>',
    ],
)
def test_a_pose_that_cannot_be_read_is_one_error(model: ModelReader, pose: str, golden: Golden) -> None:
    with golden.raises(SceneError) as refusal:
        model(link("base", pose))
    assert refusal.value.line == 4


@pytest.mark.parametrize(("attribute", "version"), [("relative_to", "1.7"), ("frame", "1.5")])
def test_a_pose_may_be_relative_to_another_link(model: ModelReader, attribute: str, version: str) -> None:
    read = model(
        link("base", f"<pose>1 0 0 0 0 {TURN}</pose>")
        + link("arm", f'<pose {attribute}="base">1 0 0 0 0 0</pose>')
        + link("hand", f'<pose {attribute}="arm">1 0 0 0 0 0</pose>'),
        version=version,
    )
    assert read.link("hand").pose.position == pytest.approx((1, 2, 0))
    assert read.link("hand").pose.yaw == pytest.approx(TURN)


@pytest.mark.parametrize(("version", "is_frame"), [("1.5", True), ("1.6", True), ("1.7", False)])
def test_the_model_is_a_frame_of_its_own_name_up_to_sdf_1_6(
    model: ModelReader, version: str, is_frame: bool, golden: Golden
) -> None:
    """Gazebo up to 9 ignores the frame of a pose; libsdformat refuses it from 1.7 on."""
    text = link("base", '<pose frame="robot">1 2 3 0 0 0</pose>')
    with nullcontext() if is_frame else golden.raises(SceneError, match="'robot'"):
        assert model(text, version=version).links[0].pose == Pose((1, 2, 3))


def test_frames_give_places_names(model: ModelReader) -> None:
    read = model(
        link("base")
        + '<frame name="mount" attached_to="base"><pose>0 0 1 0 0 0</pose></frame>'
        + '<frame name="tip" attached_to="mount"><pose>0 0 1 0 0 0</pose></frame>'
        + link("arm", '<pose relative_to="tip">1 0 0 0 0 0</pose>')
        + '<joint name="j" type="fixed"><parent>tip</parent><child>arm</child></joint>'
    )
    assert read.link("arm").pose.position == (1, 0, 2)
    assert read.joints[0].parent == "base"


def test_visuals_and_sensors_may_be_placed_in_another_frame(model: ModelReader) -> None:
    shape = "<geometry><sphere><radius>1</radius></sphere></geometry>"
    lamp = f'<visual name="lamp"><pose relative_to="__model__">0 0 5 0 0 0</pose>{shape}</visual>'
    read = model(link("base", f"<pose>0 0 2 0 0 0</pose>{lamp}"))
    assert read.links[0].visuals[0].pose.position == pytest.approx((0, 0, 3))


def test_poses_in_a_circle_are_refused(model: ModelReader, golden: Golden) -> None:
    with golden.raises(SceneError, match="'a'"):
        model(
            link("a", '<pose relative_to="b">0 0 0 0 0 0</pose>')
            + link("b", '<pose relative_to="a">0 0 0 0 0 0</pose>')
        )


@pytest.mark.parametrize(
    ("frames", "words"),
    [
        ('<frame name="f" attached_to="base"/>', ""),
        ('<frame name="f" attached_to="g"/><frame name="g" attached_to="f"/>', "'f'"),
        ('<frame name="f"><pose relative_to="f">0 0 1 0 0 0</pose></frame>', "'f'"),
        ('<frame name="f" attached_to="bsae"/>', "'bsae'.*'base'"),
    ],
)
def test_a_frame_without_a_place_is_refused_even_if_nothing_uses_it(
    model: ModelReader, frames: str, words: str, golden: Golden
) -> None:
    with golden.raises(SceneError, match=words) if words else nullcontext():
        model(link("base") + frames)


def test_frames_attached_in_a_circle_are_refused(model: ModelReader, golden: Golden) -> None:
    frames = "".join(
        f'<frame name="{a}" attached_to="{b}"><pose relative_to="base"/></frame>' for a, b in ("fg", "gf")
    )
    joint = '<joint name="j" type="fixed"><parent>f</parent><child>arm</child></joint>'
    with golden.raises(SceneError):
        model(link("base") + link("arm") + frames + joint)


@pytest.mark.parametrize("tag", ["link", "frame", "model"])
def test_names_in_a_model_are_unique_among_all_that_have_frames(
    model: ModelReader, tag: str, golden: Golden
) -> None:
    inside = link("x") if tag == "model" else ""
    with golden.raises(SceneError, match="'base'.*<link>") as refusal:
        model(link("base") + f'<{tag} name="base">{inside}</{tag}>')
    assert refusal.value.line == 5


@pytest.mark.parametrize("name", ["world", "__model__", "__x__"])
def test_reserved_names_are_refused(model: ModelReader, name: str, golden: Golden) -> None:
    with golden.raises(SceneError, match=f"'{name}'"):
        model(link(name))


def test_the_canonical_link_is_the_base(model: ModelReader, write: Callable[..., Path]) -> None:
    assert [part.name for part in model(link("a") + link("b")).links] == ["a", "b"]
    path = write(f'<model name="robot" canonical_link="b">{link("a") + link("b")}</model>')
    assert [part.name for part in read_model(path).links] == ["b", "a"]


def test_a_missing_canonical_link_is_refused(write: Callable[..., Path], golden: Golden) -> None:
    path = write(f'<model name="robot" canonical_link="bass">{link("base")}</model>')
    with golden.raises(SceneError, match="'robot'.*'bass'.*'base'"):
        read_model(path)


def test_a_model_needs_a_link(model: ModelReader, golden: Golden) -> None:
    with golden.raises(SceneError, match="'robot'.*<link>"):
        model("")


# -- nested models

NESTED = (
    link("base")
    + f'<model name="arm"><pose>0 0 1 0 0 {TURN}</pose>'
    + link("root")
    + link("tip", "<pose>1 0 0 0 0 0</pose>")
    + '<joint name="elbow" type="revolute"><parent>root</parent><child>tip</child><axis/></joint></model>'
    + '<joint name="shoulder" type="revolute"><parent>base</parent><child>arm::root</child><axis/></joint>'
)


def test_nested_models_become_part_of_the_model(model: ModelReader) -> None:
    read = model(NESTED)
    assert [part.name for part in read.links] == ["base", "arm::root", "arm::tip"]
    assert [(j.name, j.parent, j.child) for j in read.joints] == [
        ("shoulder", "base", "arm::root"),
        ("arm::elbow", "arm::root", "arm::tip"),
    ]
    assert read.link("arm::tip").pose.position == pytest.approx((0, 1, 1))
    assert read.joints[1].pose.position == pytest.approx((0, 1, 1))
    assert read.joints[0].pose.yaw == pytest.approx(TURN)


def test_a_nested_model_is_a_frame_and_so_are_its_parts(model: ModelReader) -> None:
    read = model(
        NESTED
        + link("lamp", '<pose relative_to="arm::tip">1 0 0 0 0 0</pose>')
        + link("foot", '<pose relative_to="arm">0 0 -1 0 0 0</pose>')
    )
    assert read.link("lamp").pose.position == pytest.approx((0, 2, 1))
    assert read.link("foot").pose.position == pytest.approx((0, 0, 0))


def test_a_joint_to_a_nested_model_holds_its_canonical_link(model: ModelReader) -> None:
    read = model(NESTED.replace("<child>arm::root</child>", "<child>arm</child>"))
    assert read.joints[0].child == "arm::root"


def test_the_placement_frame_is_what_stands_at_the_pose(write: Callable[..., Path]) -> None:
    inside = link("base") + link("top", "<pose>0 0 2 0 0 0</pose>")
    path = write(f'<model name="robot" placement_frame="top"><pose>1 0 0 0 0 0</pose>{inside}</model>')
    assert read_model(path).pose.position == pytest.approx((1, 0, -2))


def test_poses_of_a_world_may_be_relative_to_its_models_and_frames(world: Callable[..., Scene]) -> None:
    scene = world(
        f'<frame name="corner"><pose>5 0 0 0 0 {TURN}</pose></frame>'
        f'<model name="cup"><pose relative_to="table::top">0 0 0.1 0 0 0</pose>{link("base")}</model>'
        f'<model name="table"><pose relative_to="corner">1 0 0 0 0 0</pose>'
        f"{link('top', '<pose>0 0 1 0 0 0</pose>')}</model>"
    )
    assert scene.model("table").pose.position == pytest.approx((5, 1, 0))
    assert scene.model("cup").pose.position == pytest.approx((5, 1, 1.1))
