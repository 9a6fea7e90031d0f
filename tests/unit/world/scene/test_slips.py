"""Slips in files of robots that a reader could pass over are reported."""

from __future__ import annotations

from pathlib import Path

import nrp_experiments.bodies
import pytest

from nrp_core import Model, Scene, read_model
from nrp_core.world.drives.implausible import implausible_drives
from nrp_core.world.scene.implausible import implausible

_BODIES = Path(nrp_experiments.bodies.__path__[0])
_POSITION = "gz::sim::systems::JointPositionController"
_LIMIT = "<limit><lower>-2</lower><upper>2</upper><effort>20</effort><velocity>10</velocity></limit>"
_REACH = "<range><min>0.1</min><max>8</max></range>"
_MOMENTS = "<ixx>0.0003</ixx><iyy>0.004</iyy><izz>0.004</izz>"
_TYRE = """<collision name="tyre">
        <pose>0 0 0 1.5707963267948966 0 0</pose>
        <geometry><cylinder><radius>0.0975</radius><length>0.04</length></cylinder></geometry>
      </collision>"""
_ACROSS = "<pose>0 0 0 1.5707963267948966 0 0</pose>"
_BODY = "<size>0.44 0.28 0.17</size>"
_DISC = "<ixx>0.0019</ixx><iyy>0.0036</iyy><izz>0.0019</izz>"
_WHEEL = "<radius>0.0975</radius><length>0.04</length></cylinder></geometry>"
_EXCHANGED = "<radius>0.04</radius><length>0.0975</length></cylinder></geometry>"
_ROUND = '<collision name="a"><geometry><sphere><radius>0.2</radius></sphere></geometry></collision>'


def _surface(friction: float) -> str:
    return (
        f"{_WHEEL}<surface><friction><ode><mu>{friction}</mu><mu2>{friction}</mu2></ode></friction></surface>"
    )


def _said(path: Path) -> list[str]:
    """Return what is said about the file of a robot."""
    model: Model = read_model(path)
    found = [str(warning) for warning in model.warnings]
    found += [sentence for _, sentence in implausible(Scene((model,)), [model.name])]
    return found + list(implausible_drives(model, 0.02))


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
        ("arm.sdf", "<effort>20</effort>", "<effort>4e-4</effort>", "needs 1.2 N m to be held"),
        ("arm.sdf", "<p_gain>12<", "<p_gain>2e-3<", "even at the largest error it exerts"),
        ("arm.sdf", _MOMENTS, _MOMENTS.replace("0.0003", "0.3").replace("0.004", "4"), "is it in kg m^2?"),
        (
            "arm.sdf",
            _MOMENTS,
            "<ixx>0.004</ixx><iyy>0.0003</iyy><izz>0.004</izz>",
            "about the axis along which its sh",
        ),
        ("pioneer.sdf", _TYRE, "", "'left_wheel' has no collision shape, and others have"),
        (
            "pioneer.sdf",
            _REACH,
            f"{_REACH}<noise><type>gaussian</type><stddev>9</stddev></noise>",
            "its range is 8",
        ),
        ("arm.sdf", "<d_gain>1.5", "<d_gain>1500", "nears its target with a time constant of 125 s"),
        (
            "arm.sdf",
            "<damping>0.6</damping>",
            "<damping>0.6</damping><spring_stiffness>1e6</spring_stiffness>",
            "a stiffness of 1e+06, and its controller a gain of 12: commands hardly move it",
        ),
        ("arm.sdf", "<joint_name>elbow", "<joint_name>shoulder", "has 2 position controllers, on /arm/shou"),
        ("arm.sdf", f'name="{_POSITION}"', 'name="gz::sim::systems::JointController"', "of JointController"),
        (
            "pioneer.sdf",
            _REACH,
            "<range><min>7</min><max>8</max></range>",
            "measures nothing nearer than 7 m",
        ),
        ("pioneer.sdf", _REACH, "<range><min>0.1</min><max>80000</max></range>", "its range meant in mm?"),
        ("pan_tilt.sdf", "<horizontal_fov>1.047", "<horizontal_fov>3.1", "a field of view of 3.1 rad"),
        (
            "pioneer.sdf",
            _ACROSS,
            "<pose>0 0 0 0 0 0</pose>",
            "'left_wheel' lies across the axis of the joint",
        ),
        (
            "pioneer.sdf",
            '<model name="pioneer">',
            '<model name="pioneer"><self_collide>maybe</self_collide>',
            "<self_collide> is 'maybe', which is neither true nor false: ignored",
        ),
    ],
)
def test_a_slip_in_the_file_of_a_robot_is_reported(
    tmp_path: Path, file: str, old: str, new: str, words: str
) -> None:
    said = _edited(tmp_path, file, old, new)
    assert any(words in one for one in said), said


@pytest.mark.parametrize(
    ("file", "old", "right", "wrong", "words"),
    [
        ("pioneer.sdf", _BODY, "<size>0.9 0.6 0.3</size>", "<size>4.4 2.8 1.7</size>",
         "'base' of 'pioneer' are 4.4 x 2.8 x 1.7 m, and its visuals 0.45 x 0.37 x 0.24 m; is"),
        ("pioneer.sdf", _BODY, "<size>0.9 0.6 0.3</size>", "<size>44 28 17</size>",
         "'base' of 'pioneer' are 44 x 28 x 17 m, and its visuals 0.45 x 0.37 x 0.24 m; is"),
        ("arm.sdf", '<visual name="hand">', _ROUND + '<visual name="hand">', None, ""),  # in some directions
        ("pioneer.sdf", "<pose>-0.045 0 0.055 0 0 0</pose>", "<pose>-4.5 0 5.5 0 0 0</pose>",
         "<pose>-45 0 55 0 0 0</pose>", "the collision 'body' of the link 'base' of 'pioneer' is 71.1 m"),
        ("pioneer.sdf", "<pose>-0.03 0 0.137 0 0 0</pose>", "<pose>-0.3 0 1.37 0 0 0</pose>",
         "<pose>-30 0 137 0 0 0</pose>", "the visual 'deck' of the link 'base' of 'pioneer' is 140 m"),
        ("pioneer.sdf", _WHEEL, _WHEEL.replace("0.04<", "0.05<"), _EXCHANGED,
         "radius of 0.04 m and a length of 0.0975 m, and its visual the same numbers exchanged"),
        ("pioneer.sdf", _WHEEL, _surface(0.05), _surface(0), "has a wheel without friction, 'left_wheel'"),
        ("pioneer.sdf", _DISC, "<ixx>0.0019</ixx><iyy>0.0017</iyy><izz>0.0019</izz>",
         "<ixx>0.0036</ixx><iyy>0.0019</iyy><izz>0.0019</izz>", "a disc has its largest there; are"),
    ],
)  # fmt: skip
def test_a_shape_or_wheel_unlike_the_others_is_the_only_thing_that_is_reported(
    tmp_path: Path, file: str, old: str, right: str, wrong: str | None, words: str
) -> None:
    allowed = [one for one in _edited(tmp_path, file, old, right) if "centre of mass" not in one]
    assert allowed == []
    if wrong is not None:
        said = _edited(tmp_path, file, old, wrong)
        assert any(words in one for one in said), said
        assert all(words in one or "wheels of" in one or "lies across" in one for one in said), said


def test_visuals_in_mm_are_reported_once(tmp_path: Path) -> None:
    text = (
        (_BODIES / "arm.sdf")
        .read_text("utf-8")
        .replace("<size>0.3 0.04 0.05</size>", "<size>300 40 50</size>")
    )
    block = '<collision name="solid"><geometry><box><size>0.3 0.04 0.05</size></box></geometry></collision>'
    (tmp_path / "arm.sdf").write_text(text.replace('<visual name="bone">', f'{block}<visual name="bone">', 1))
    (said,) = _said(tmp_path / "arm.sdf")
    assert (
        said == "the visuals of 'arm' are 300 m large and its collision shapes 0.3 m; are they meant in mm?"
    )


def test_noise_of_a_laser_is_not_compared_with_brightness(tmp_path: Path) -> None:
    noise = f"{_REACH}<noise><type>gaussian</type><stddev>9</stddev></noise>"
    assert not any("brightness" in one for one in _edited(tmp_path, "pioneer.sdf", _REACH, noise))


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
        ("<limit ", "<limits ", "URDF has no <limits> in a <joint>: ignored; did you mean 'limit'?"),
        (
            'damping="0.1"',
            'dampng="0.1"',
            "<dynamics> has no attribute 'dampng': ignored; did you mean 'damp",
        ),
        (
            'soft_upper_limit="1"',
            'soft_upper_limit="-2"',
            "the soft_lower_limit of a <safety_controller>, -1",
        ),
        (
            "<collision ",
            "<visual><collision/><geometry><box size='1 1 1'/></geometry></visual><collision ",
            "URDF has no <collision> in a <visual>: ignored; it belongs in <link>",
        ),
        ("</geometry></collision>", "</geometry><material name='grey'/></collision>", None),  # as exported
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
def test_a_misspelt_type_is_told_with_what_is_meant(tmp_path: Path, old: str, new: str, words: str) -> None:
    assert any(words in one for one in _edited(tmp_path, "pan_tilt.sdf", old, new))
