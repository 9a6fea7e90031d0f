"""Every misspelt element and attribute, and every value of another kind, is reported."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as ET

import nrp_experiments
import pytest

from nrp_core import read_model, read_scene
from nrp_core.errors import SceneError
from nrp_core.findings import Level
from nrp_core.scene.rigid import Pose

_SHIPPED = Path(nrp_experiments.__path__[0])
_FREE = ("plugin",)
"""Elements with contents of their own; those of one plugin are tested with the plugin."""


def _misspelt(word: str) -> str:
    """Return a word without its second letter, or twice if it has one only."""
    return word[:1] + word[2:] if len(word) > 2 else word * 2


def _said(path: Path) -> set[str]:
    """Return what is said about a file: its warnings, or why it is refused."""
    try:
        read = read_scene(path) if "<world" in path.read_text("utf-8") else read_model(path)
    except SceneError as error:
        return {error.message}
    return {warning.message for warning in read.warnings if warning.level is Level.WARNING}


def _changes(root: ET.Element) -> Iterator[tuple[str, int, str]]:
    """Yield each kind of element and attribute once, with the number of its first element and its name."""
    seen: set[str] = set()
    parents = {child: parent for parent in root.iter() for child in parent}
    for number, element in enumerate(root.iter()):
        parent = parents.get(element)
        if ":" in element.tag or "}" in element.tag or parent is None or parent.tag in _FREE:
            continue
        for attribute in ("", *element.attrib):
            what = f"<{parent.tag}><{element.tag} {attribute}>"
            if what not in seen:
                seen.add(what)
                yield what, number, attribute


def _misspell(element: ET.Element, attribute: str) -> None:
    if attribute:
        element.attrib[_misspelt(attribute)] = element.attrib.pop(attribute)
    else:
        element.tag = _misspelt(element.tag)


@pytest.mark.one_of(6)
@pytest.mark.parametrize(
    "file",
    [
        "bodies/arm.sdf",
        "bodies/pioneer.sdf",
        "bodies/pan_tilt.sdf",
        "braitenberg_husky/husky.sdf",
        "braitenberg_husky/room.sdf",
    ],
)
def test_every_misspelt_element_and_attribute_of_a_shipped_file_is_reported(
    tmp_path: Path, file: str
) -> None:
    for sibling in (_SHIPPED / file).parent.glob("*.sdf"):
        (tmp_path / sibling.name).symlink_to(sibling)
    original = (_SHIPPED / file).read_text("utf-8")
    path = tmp_path / "changed.sdf"
    path.write_text(original, "utf-8")
    before = _said(path)
    assert before == set()
    tried, silent = 0, []
    for what, number, attribute in _changes(ET.fromstring(original)):
        changed = ET.fromstring(original)
        _misspell(list(changed.iter())[number], attribute)
        path.write_bytes(ET.tostring(changed))
        tried += 1
        if not _said(path) - before:
            silent.append(what)
    assert tried > 20
    assert silent == []


def test_a_pose_that_another_replaces_is_not_reported(tmp_path: Path) -> None:
    robot, room = tmp_path / "robot.sdf", tmp_path / "room.sdf"
    link = '<link name="l"><inertial><mass>1</mass></inertial></link>'
    robot.write_text(f'<sdf version="1.9"><model name="m"><pose>0 0 1 0 0 0</pose>{link}</model></sdf>')
    assert read_model(robot, pose=Pose((1.0, 0.0, 0.0))).warnings == ()
    include = "<include><uri>robot.sdf</uri><pose>2 0 0 0 0 0</pose></include>"
    room.write_text(f'<sdf version="1.9"><world name="w">{include}</world></sdf>')
    assert read_scene(room).warnings == ()


def test_a_static_model_without_links_has_no_misspelt_ones(tmp_path: Path) -> None:
    path = tmp_path / "room.sdf"
    usual = "<pose>1 0 0 0 0 0</pose><self_collide>0</self_collide><plugin name='p' filename='p'/>"
    for inner, number in (("", 0), ("<lnik/>", 1)):
        path.write_text(_WORLD.format("<model name='n'><static>1</static>" + usual + inner + "</model>", ""))
        assert len([one for one in _said(path) if "<link>?" in one]) == number


_WORLD = '<sdf version="1.9"><world name="w">{}<model name="m"><static>1</static>{}</model></world></sdf>'
_BOX = "<geometry><box><size>1 1 1</size></box></geometry>"
_LINK = f'<link name="l"><collision name="c">{_BOX}{{}}</collision></link>'


@pytest.mark.parametrize(
    ("world", "collision", "said"),
    [
        ("<physics><max_ste_psize>0.002</max_ste_psize></physics>", "",
         "<max_ste_psize> is not an element of <physics>: ignored; did you mean <max_step_size>?"),
        ('<light nmae="sun" name="sun" type="point"/>', "",
         "<light> has no attribute 'nmae': ignored; did you mean 'name'?"),
        ('<light name="sun" type="piont"/>', "", "'piont'"),
        ("", "<surface><friction><ode><um>1</um></ode></friction></surface>",
         "<um> is not an element of <ode>: ignored"),
        ("", "<surface><contact><ode><kd>1</kd><kpp>1</kpp></ode></contact></surface>",
         "<kpp> is not an element of <ode>: ignored"),
        ("", "<surface><friction><ode><mu>1<mu2>1</mu2></mu></ode></friction></surface>",
         "<mu2> is not an element of <mu>: ignored; it belongs in <ode>, beside <mu>"),
        ("", "<surface><mu>1</mu></surface>", "<mu> is not an element of <surface>: ignored"),
        ("", "<surface>0.7</surface>", "the text '0.7' in <surface>, which holds elements, is ignored"),
    ],
)  # fmt: skip
def test_unknown_elements_and_attributes_of_sdf_are_reported(
    tmp_path: Path, world: str, collision: str, said: str
) -> None:
    path = tmp_path / "room.sdf"
    path.write_text(_WORLD.format(world, _LINK.format(collision)))
    found = _said(path)
    assert len(found) == 1
    assert said in next(iter(found))


@pytest.mark.parametrize(
    ("world", "collision"),
    [
        ('<physics name="1ms" type="ignored"><max_step_size>0.001</max_step_size></physics>', ""),
        ("<physics><ode><solver><type>quick</type><iters>50</iters></solver></ode></physics>", ""),
        ("<scene><sky><clouds><speed>12</speed></clouds></sky><ambient>1 1 1</ambient></scene>", ""),
        ('<gui fullscreen="0"><camera name="c"><anything/></camera></gui>', ""),
        ('<light name="sun" type="directional" xmlns:x="y" x:z="1"/>', ""),
        ("", "<pose/>"),
        ("", '<surface><friction><ode><fdir1 gz:expressed_in="l">1 0 0</fdir1></ode></friction></surface>'),
        ("", "<surface><contact><ode><kp>1e+15</kp><min_depth>inf</min_depth></ode></contact></surface>"),
        ("", "<gz:own><thing>1</thing></gz:own>"),
    ],
)  # fmt: skip
def test_elements_and_attributes_of_sdf_are_not_reported(tmp_path: Path, world: str, collision: str) -> None:
    path = tmp_path / "room.sdf"
    path.write_text(_WORLD.format(world, _LINK.format(collision)))
    assert _said(path) == set()


def test_a_name_that_old_files_write_as_text_is_not_reported(tmp_path: Path) -> None:
    path = tmp_path / "room.sdf"
    shape = "<geometry><sphere><radius>1</radius></sphere></geometry>"
    visual = f'<visual name="v">{shape}<material>{{}}</material></visual>'
    for script, said in (
        ("<script>Gazebo/Red</script>", set()),
        ("<script><name/></script>", {"the <script> has no <name>: shown grey"}),
    ):
        path.write_text(_WORLD.format("", f'<link name="l">{visual.format(script)}</link>'))
        assert _said(path) == said


_ROBOT = """<robot name="r">
  <link name="base">{link}</link><link name="arm"/>
  <joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>{joint}</joint>
  {robot}
</robot>"""
_MASS = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
_CONTROL = '<gazebo><plugin name="c" filename="libgazebo_ros_control.so">{}</plugin></gazebo>'
_HARDWARE = '<ros2_control name="s" type="system"><joint name="j">{}</joint></ros2_control>'
_DRIVEN = (
    '<transmission name="t"><type>transmission_interface/SimpleTransmission</type><joint name="j">'
    "<hardwareInterface>{}</hardwareInterface></joint></transmission>"
)


def _robot(folder: Path, **parts: str) -> set[str]:
    path = folder / "robot.urdf"
    path.write_text(_ROBOT.format(**{"link": _MASS, "joint": "", "robot": "", **parts}))
    before = "the link 'arm' moves but has no mass: 0.0001 kg"
    return {one for one in _said(path) if one != before}


@pytest.mark.parametrize(
    ("part", "text", "said"),
    [
        ("joint", '<safety_controller k_velocity="fast"/>',
         "k_velocity of <safety_controller> must hold a number, not 'fast': ignored"),
        ("joint", '<dynamics damping="1"><limit effort="1" velocity="1"/></dynamics>',
         "URDF has no <limit> in a <dynamics>: ignored; it belongs in <joint>"),
        ("robot", '<gazebo refrence="arm"><mu1>1</mu1></gazebo>',
         "<gazebo> has no attribute 'refrence': ignored; did you mean 'reference'?"),
        ("robot", '<gazebo reference="base"><mu1>1<mu2>1</mu2></mu1></gazebo>',
         "<mu2> in <mu1>, which holds a value, is ignored"),
        ("robot", '<gazebo reference="base"><mu1>1</mu1><mu1>0.1</mu1></gazebo>',
         "a second <mu1> in the <gazebo> is ignored: the one of line 4 is used"),
        ("robot", _CONTROL.format("<paraemters>file.yaml</paraemters>"), "did you mean <parameters>?"),
        ("robot", _HARDWARE.format('<comand_interface name="position"/>'),
         "URDF has no <comand_interface> in a <joint>: ignored; did you mean 'command_interface'?"),
        ("robot", _HARDWARE.format('<state_interface name="position"><param name="intial_value">1</param>'
                                   "</state_interface>"),
         "<param> 'intial_value' is ignored; did you mean 'initial_value'?"),
        ("robot", _DRIVEN.format("ardware_interface/EffortJointInterface"),
         "joints cannot be commanded by 'ardware_interface/EffortJointInterface'; did you mean 'hardware_in"),
        ("robot", _DRIVEN.format("EffortJointInterface").replace("joint name", "jiont name").replace(
            "/joint", "/jiont"),
         "URDF has no <jiont> in a <transmission>: ignored; did you mean 'joint'?"),
        ("robot", '<material name="unused"><color rgba="1 2"/></material>',
         "rgba of <color> must hold 4 numbers, not '1 2': ignored"),
        ("link", f'{_MASS}<contact><stiffness vlaue="3"/></contact>',
         "<stiffness> has no attribute 'vlaue': ignored; did you mean 'value'?"),
    ],
)  # fmt: skip
def test_unknown_elements_and_attributes_of_urdf_are_reported(
    tmp_path: Path, part: str, text: str, said: str
) -> None:
    assert any(said in one for one in _robot(tmp_path, **{part: text})), _robot(tmp_path, **{part: text})


@pytest.mark.parametrize(
    ("part", "text"),
    [
        ("joint", '<safety_controller k_velocity="9" soft_lower_limit="-1"/><joint_properties spring="1"/>'),
        ("joint", '<role name="x"/><hardware id="3"/>'),
        ("robot", '<gazebo><static>0</static></gazebo><gazebo reference="base"><mu1 value="1"/></gazebo>'),
        ("robot", _CONTROL.format("<robotNamespace/><robotSimType>x</robotSimType><ros><namespace/></ros>")),
        ("robot", _HARDWARE.format('<command_interface name="effort"><param name="min">-1</param>'
                                   '<param name="gain">2</param></command_interface>')),
        ("robot", _DRIVEN.format("hardware_interface/EffortJointInterface")),
        ("robot", _DRIVEN.format("EffortJointInterface").replace(
            "</transmission>", '<actuator name="m"><mechanicalReduction>9</mechanicalReduction></actuator>'
            "<leftActuator/></transmission>")),
        ("link", f'{_MASS}<contact><lateral_friction value="1"/><friction_anchor/></contact>'),
    ],
)  # fmt: skip
def test_elements_and_attributes_of_urdf_are_not_reported(tmp_path: Path, part: str, text: str) -> None:
    assert _robot(tmp_path, **{part: text}) == set()
