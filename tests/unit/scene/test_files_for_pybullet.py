"""URDF as PyBullet's users write it: PyBullet reads it in its own way, and the platform means the same."""

from __future__ import annotations

from math import inf
from pathlib import Path

import pytest
from golden import Golden

from nrp_core.findings import Code
from nrp_core.scene.model import Model, Plane
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf import read_model

MASS = '<inertial><mass value="{}"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
ENDS = '<parent link="base"/><child link="arm"/>'


def read(folder: Path, body: str) -> Model:
    path = folder / "robot.urdf"
    path.write_text(f'<robot name="r2">\n{body}\n</robot>')
    return read_model(path)


def arm(folder: Path, kind: str, inside: str = "") -> Model:
    links = "".join(f'<link name="{name}">{MASS.format(1)}</link>' for name in ("base", "arm"))
    return read(folder, f'{links}<joint name="j" type="{kind}">{ENDS}{inside}</joint>')


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "continuous"])
def test_crossed_limits_of_a_joint_are_none(tmp_path: Path, kind: str, golden: Golden) -> None:
    found = arm(tmp_path, kind, '<limit lower="1" upper="-1" effort="5" velocity="2"/>')
    (joint,) = found.joints
    assert (joint.lower, joint.upper, joint.effort, joint.velocity) == (-inf, inf, 5, 2)
    (warning,) = found.warnings
    assert (warning.code, warning.line) == (Code.NRP384, 2)
    assert "(-1)" in warning.message
    golden(warning.message)


def test_a_spherical_joint_is_a_ball_joint(tmp_path: Path) -> None:
    found = arm(tmp_path, "spherical")
    assert [(joint.kind, joint.parent, joint.child) for joint in found.joints] == [("ball", "base", "arm")]


def test_a_plane_without_a_mass_is_ground_that_faces_along_its_normal(tmp_path: Path, golden: Golden) -> None:
    plane = '<collision><geometry><plane normal="0 1 0"/></geometry></collision>'
    found = read(tmp_path, f'<link name="ground">{MASS.format(0)}{plane}</link>')
    (shape,) = found.links[0].collisions
    assert (found.static, shape.geometry) == (True, Plane())
    assert shape.pose.rotate((0.0, 0.0, 1.0)) == pytest.approx((0, 1, 0))
    (warning,) = found.warnings
    golden(warning.message)


@pytest.mark.parametrize(("mass", "static"), [(0, True), (0.001, False)])
def test_only_a_mass_of_0_keeps_a_thing_in_place(tmp_path: Path, mass: float, static: bool) -> None:
    box = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
    assert read(tmp_path, f'<link name="base">{MASS.format(mass)}{box}</link>').static is static


def test_a_visual_without_a_size_is_left_out_and_reported(tmp_path: Path, golden: Golden) -> None:
    shapes = "".join(f'<visual><geometry><sphere radius="{r}"/></geometry></visual>' for r in ("0.0", "2"))
    found = read(tmp_path, f'<link name="base">{MASS.format(1)}{shapes}</link>')
    assert [(each.name, each.pose) for each in found.links[0].visuals] == [("base_visual_1", Pose())]
    (warning,) = found.warnings
    assert "'base_visual'" in warning.message
    golden(warning.message)


def test_properties_of_contacts_that_cannot_be_set_are_reported_by_pybullet(tmp_path: Path) -> None:
    pytest.importorskip("pybullet")
    from nrp_core import Scene, worlds

    contact = '<contact>\n<contact_cfm value="0"/><contact_erp value="1"/><stiffness value="3"/></contact>'
    contact = contact.replace("</contact>", '<damping value="1"/></contact>')
    model = read(tmp_path, f'<link name="base">{MASS.format(1)}{contact}</link>')
    backend = worlds().load("pybullet")
    with backend.open(Scene((model,)), seed=1, options=backend.options()) as world:
        said = [(each.message, each.line) for each in world.warnings if each.code is Code.NRP383]
    assert said == [
        ("<contact_cfm> of the <contact> of 'base' is not used", 3),
        ("<contact_erp> of the <contact> of 'base' is not used", 3),
    ]
