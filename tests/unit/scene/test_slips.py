"""Mistakes in files of robots that a reader could pass over are reported."""

from __future__ import annotations

from pathlib import Path

import nrp_experiments.bodies
import pytest

from nrp_core import read_model

_BODIES = Path(nrp_experiments.bodies.__path__[0])
_POSITION = "gz::sim::systems::JointPositionController"
_LIMIT = "<limit><lower>-2</lower><upper>2</upper><effort>20</effort><velocity>10</velocity></limit>"
_REACH = "<range><min>0.1</min><max>8</max></range>"


def _said(path: Path) -> list[str]:
    """Return the warnings about the file of a robot."""
    return [str(warning) for warning in read_model(path).warnings]


def _edited(folder: Path, file: str, old: str, new: str) -> list[str]:
    text = (_BODIES / file).read_text("utf-8")
    assert old in text
    (folder / file).write_text(text.replace(old, new, 1), "utf-8")
    return _said(folder / file)


@pytest.mark.parametrize("file", ["arm.sdf", "pioneer.sdf", "pan_tilt.sdf", "hexapod.sdf", "fly.sdf"])
def test_the_bodies_that_ship_have_no_slip(file: str) -> None:
    assert _said(_BODIES / file) == []


@pytest.mark.parametrize(
    ("file", "old", "new", "words"),
    [
        ("arm.sdf", _LIMIT, f"{_LIMIT}<limit><lower>-1</lower></limit>", "a second <limit> in the <axis> is"),
        (
            "arm.sdf",
            "<mass>0.8</mass>",
            "<mass>0.8</mass><mass>80</mass>",
            "a second <mass> in the <inertial>",
        ),
        ("pioneer.sdf", _REACH, f"{_REACH}<range><max>1</max></range>", "a second <range> in the <ray> is"),
        ("arm.sdf", f'name="{_POSITION}"', 'name="gz::sim::systems::JointController"', "of JointController"),
        (
            "pioneer.sdf",
            '<model name="pioneer">',
            '<model name="pioneer"><self_collide>maybe</self_collide>',
            "<self_collide> maybe of a <model> is not simulated",
        ),
    ],
)
def test_a_slip_in_the_file_of_a_robot_is_reported(
    tmp_path: Path, file: str, old: str, new: str, words: str
) -> None:
    said = _edited(tmp_path, file, old, new)
    assert any(words in one for one in said), said


def test_an_element_that_is_repeated_with_the_same_contents_is_not_reported(tmp_path: Path) -> None:
    assert _edited(tmp_path, "arm.sdf", "<mass>0.8</mass>", "<mass>0.8</mass><mass>0.8</mass>") == []


_URDF = """<robot name="arm">
  <link name="base"><inertial><mass value="5"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>
    <collision group="2"><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <link name="upper"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.1" rpy="0 0 0"/><axis xyz="0 1 0"/><dynamics damping="0.1"/>
    <limit lower="-1.5" upper="1.5" effort="50" velocity="2"/>
    <safety_controller soft_lower_limit="-1" soft_upper_limit="1" k_velocity="1"/></joint>
</robot>"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("", "", None),
        ('lower="-1.5" upper', 'lower="-1.5" acceleration="9" upper', None),
        (
            'lower="-1.5"',
            'lowwer="-1.5"',
            "<limit> has no attribute 'lowwer': ignored; did you mean 'lower'?",
        ),
        ('rpy="0 0 0"', 'rpi="0 0 0"', "<origin> has no attribute 'rpi': ignored; did you mean 'rpy'?"),
        ('<axis xyz="0 1 0"/>', '<axis zyx="0 1 0"/>', "<axis> has no attribute 'zyx': ignored"),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 1 0" rpy="0 0.0 -0"/>', None),  # as exported
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 1 0" rpy="0 0 1"/>', "'rpy': ignored; it belongs in <origin>"),
        ("</robot>", '<gazebo><maxContacts value="64"/></gazebo></robot>', None),
        ("<limit ", "<limits ", "URDF has no <limits> in a <joint>: ignored; did you mean 'limit'?"),
        (
            'damping="0.1"',
            'dampng="0.1"',
            "<dynamics> has no attribute 'dampng': ignored; did you mean 'damp",
        ),
        (
            "<collision ",
            "<visual><collision/><geometry><box size='1 1 1'/></geometry></visual><collision ",
            "URDF has no <collision> in a <visual>: ignored; it belongs in <link>",
        ),
        ("</geometry></collision>", "</geometry><material name='grey'/></collision>", None),  # as exported
        (
            "<dynamics ",
            "<joint_properties ",
            "URDF has no <joint_properties> in a <joint>: ignored; it is <dynamics",
        ),
        ("<axis ", '<joint_properties damping="9"/><axis ', None),  # for other programs, beside <dynamics>
        ("<axis ", '<axis xyz="1 0 0"/><axis ', "a second <axis> in the <joint> 'shoulder' is ignored"),
    ],
)
def test_a_slip_in_urdf_is_reported(tmp_path: Path, old: str, new: str, words: str | None) -> None:
    (tmp_path / "arm.urdf").write_text(_URDF.replace(old, new, 1))
    found = [str(warning) for warning in read_model(tmp_path / "arm.urdf").warnings]
    assert len(found) == (words is not None)
    assert words is None or words in found[0]


_CART = """<robot name="cart"><link name="base">{}</link><link name="arm"/>
<joint name="elbow" type="revolute" {}><parent link="base"/><child link="arm"/><axis xyz="0 1 0">{}</axis>
<limit lower="-1" upper="1" effort="10" velocity="2"/></joint></robot>"""


@pytest.mark.parametrize(
    ("link", "joint", "axis", "words"),
    [
        ("", "", "0 0 1", "the text '0 0 1' in <axis> is ignored: URDF has values in attributes; write xyz="),
        ("", 'damping="5"', "", "<joint> has no attribute 'damping': ignored; it belongs in <dynamics>"),
        ("", 'rpy="0 0 1"', "", "<joint> has no attribute 'rpy': ignored; it belongs in <origin>"),
        ("", 'effort="5"', "", "<joint> has no attribute 'effort': ignored; it belongs in <limit>"),
        ("<visual><origin/><geometry><sphere radius='1'/></geometry></visual>", "", "", ""),
    ],
)
def test_a_value_of_urdf_in_another_place_is_reported(
    tmp_path: Path, link: str, joint: str, axis: str, words: str
) -> None:
    (tmp_path / "cart.urdf").write_text(_CART.format(link, joint, axis))
    said = [str(one) for one in read_model(tmp_path / "cart.urdf").warnings]
    assert any(words in one for one in said) if words else not any("ignored" in one for one in said), said


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            'type="camera"',
            'type="camra"',
            "sensors of type 'camra' are not simulated; did you mean 'camera'?",
        ),
        (
            "</camera>",
            "<noise><type>gausian</type></noise></camera>",
            "noise of type 'gausian' is not simulated; did you mean 'gaussian'?",
        ),
    ],
)
def test_a_misspelt_type_is_reported_with_the_right_spelling(
    tmp_path: Path, old: str, new: str, words: str
) -> None:
    assert any(words in one for one in _edited(tmp_path, "pan_tilt.sdf", old, new))
