from __future__ import annotations

from math import cos, hypot, isclose, pi, sin

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st

from nrp_core.errors import SceneError
from nrp_core.scene.model import Link, Model, Scene
from nrp_core.scene.rigid import Pose

metres = st.floats(-10, 10)
vectors = st.tuples(metres, metres, metres)
angles = st.floats(-pi, pi)
poses = st.builds(Pose.from_rpy, vectors, angles, angles, angles)
rounding = {"rel": 1e-9, "abs": 1e-9}


def same(a: Pose, b: Pose) -> bool:
    """Whether two poses are one; q and -q are the same rotation."""
    apart = hypot(*(x - y for x, y in zip(a.position, b.position, strict=True)))
    dot = sum(x * y for x, y in zip(a.orientation, b.orientation, strict=True))
    return apart < 1e-9 and isclose(abs(dot), 1, abs_tol=1e-9)


@given(poses, poses, poses)
def test_composition_is_associative(a: Pose, b: Pose, c: Pose) -> None:
    assert same((a @ b) @ c, a @ (b @ c))


@given(poses)
def test_the_identity_changes_nothing(a: Pose) -> None:
    assert same(Pose() @ a, a)
    assert same(a @ Pose(), a)


@given(poses)
def test_a_pose_and_its_inverse_cancel(a: Pose) -> None:
    assert same(a @ a.inverse(), Pose())
    assert same(a.inverse() @ a, Pose())


@given(poses, poses)
def test_the_inverse_of_a_product_is_the_product_of_inverses_backwards(a: Pose, b: Pose) -> None:
    assert same((a @ b).inverse(), b.inverse() @ a.inverse())


@given(poses, vectors)
def test_a_rotation_keeps_lengths(a: Pose, v: tuple[float, float, float]) -> None:
    assert hypot(*a.rotate(v)) == pytest.approx(hypot(*v), **rounding)


@given(poses, vectors)
def test_composing_with_a_pose_moves_its_point(a: Pose, v: tuple[float, float, float]) -> None:
    moved = [p + r for p, r in zip(a.position, a.rotate(v), strict=True)]
    assert (a @ Pose(v)).position == pytest.approx(moved, **rounding)


@given(angles, st.one_of(angles, st.sampled_from([pi / 2, -pi / 2])), angles)
def test_roll_pitch_yaw_name_the_rotation_they_were_read_from(roll: float, pitch: float, yaw: float) -> None:
    pose = Pose.from_rpy((0, 0, 0), roll, pitch, yaw)
    again = Pose.from_rpy((0, 0, 0), *pose.rpy)
    for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        assert again.rotate(axis) == pytest.approx(pose.rotate(axis), abs=1e-6)


@given(st.floats(-pi + 1e-6, pi - 1e-6), st.floats(-1.5, 1.5), st.floats(-pi + 1e-6, pi - 1e-6))
def test_within_their_range_the_angles_come_back(roll: float, pitch: float, yaw: float) -> None:
    assert Pose.from_rpy((0, 0, 0), roll, pitch, yaw).rpy == pytest.approx((roll, pitch, yaw), abs=1e-6)


@pytest.mark.parametrize(
    ("roll", "pitch", "yaw", "axis", "turned"),
    [
        (0, 0, pi / 2, (1, 0, 0), (0, 1, 0)),
        (pi / 2, 0, 0, (0, 1, 0), (0, 0, 1)),
        (0, pi / 2, 0, (1, 0, 0), (0, 0, -1)),
        (0, 0.3, pi, (1, 0, 0), (-cos(0.3), 0, -sin(0.3))),
    ],
)
def test_angles_turn_about_fixed_axes_x_then_y_then_z(
    roll: float, pitch: float, yaw: float, axis: tuple[float, ...], turned: tuple[float, ...]
) -> None:
    pose = Pose.from_rpy((0, 0, 0), roll, pitch, yaw)
    assert pose.rotate(axis) == pytest.approx(turned, abs=1e-12)  # type: ignore[arg-type]


def test_quaternions_hold_w_last() -> None:
    assert Pose().orientation == (0, 0, 0, 1)
    half = sin(pi / 4)
    assert Pose.from_rpy((0, 0, 0), 0, 0, pi / 2).orientation == pytest.approx((0, 0, half, half))


@given(vectors.filter(lambda v: hypot(*v) > 1e-3))
def test_pointing_takes_z_to_the_direction(v: tuple[float, float, float]) -> None:
    direction = tuple(part / hypot(*v) for part in v)
    assert Pose.pointing(direction).rotate((0.0, 0.0, 1.0)) == pytest.approx(direction, abs=1e-6)  # type: ignore[arg-type]


def test_pointing_down_turns_upside_down() -> None:
    assert Pose.pointing((0.0, 0.0, -1.0)).rotate((0.0, 0.0, 1.0)) == pytest.approx((0, 0, -1))


@given(angles)
def test_yaw_is_the_heading(yaw: float) -> None:
    x, y, _ = Pose.from_rpy((1, 2, 3), 0, 0, yaw).rotate((1.0, 0.0, 0.0))
    assert (x, y) == pytest.approx((cos(yaw), sin(yaw)), abs=1e-12)


@pytest.mark.parametrize(
    "pose",
    [
        Pose((1.0, 2.0)),  # type: ignore[arg-type]
        Pose(1.0),  # type: ignore[arg-type]
        Pose((0.0, float("nan"), 0.0)),
        Pose(orientation=(0.0, 0.0, 1.57)),  # type: ignore[arg-type]
        Pose(orientation=(0.0, 0.0, 0.0, 2.0)),
        (0.0, 0.0, 1.0),
    ],
)
def test_a_scene_refuses_an_invalid_pose(pose: Pose, golden: Golden) -> None:
    with golden.raises(SceneError, match="'m'"):
        Scene((Model("m", (Link("body"),), pose=pose),))
    with golden.raises(SceneError, match="'body'.*'m'"):
        Scene((Model("m", (Link("body", pose=pose),)),))


def test_a_scene_takes_poses_of_whole_numbers_arrays_and_rounded_quaternions() -> None:
    position, orientation = np.array([1.0, 2.0, 3.0], np.float32), (0.0, 0.0, 0.70711, 0.70711)
    for pose in (Pose((1, 2, 0)), Pose(position, orientation)):  # type: ignore[arg-type]
        assert Scene((Model("m", (Link("body"),), pose=pose),)).model("m").pose is pose
