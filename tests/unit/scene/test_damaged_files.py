"""Files damaged at random are usable or refused in one sentence: nothing crashes, nothing is half-loaded."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from copy import deepcopy
from dataclasses import fields, is_dataclass
from math import isfinite
from pathlib import Path
from typing import Any

import nrp_experiments.braitenberg_husky
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from nrp_core.errors import SceneError
from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.model import Box, Capsule, Cylinder, Scene, Sphere
from nrp_core.scene.reading.context import read_without
from nrp_core.scene.sdf import read_scene

SHIPPED = Path(nrp_experiments.braitenberg_husky.__file__).parent
WORDS = (
    *("", "0", "-1", "nan", "inf", "-inf", "1e400", "1e-320", "1e200", "1", "1 2 3", "0 0 0", "1.4"),
    *("world", "__model__", "a::b", "base", "arm", "revolute", "ball", "true", "\N{SNOWMAN}", "x" * 300),
)

ARM = """<sdf version="1.8"><world name="lab">
  <gravity>0 0 -9.8</gravity>
  <light name="sun" type="directional"><direction>0 1 -1</direction></light>
  <frame name="bench" attached_to="world"><pose degrees="true">1 2 3 0 0 90</pose></frame>
  <model name="robot"><pose relative_to="bench">0 0 1 0 0 0</pose>
    <link name="base"><inertial><mass>2</mass>
      <inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>
      <visual name="v"><geometry><box><size>1 1 1</size></box></geometry>
        <material><script><name>Gazebo/Red</name></script></material></visual>
      <collision name="c"><geometry><cylinder><radius>1</radius><length>2</length></cylinder></geometry>
        <surface><friction><ode><mu>1</mu><mu2>1</mu2></ode></friction></surface></collision>
      <sensor name="eye" type="camera"><update_rate>10</update_rate><camera><horizontal_fov>1</horizontal_fov>
        <image><width>4</width><height>3</height></image><clip><near>0.1</near><far>9</far></clip></camera></sensor>
    </link>
    <link name="arm"><pose relative_to="base">0 0 1 0 0 0</pose>
      <collision name="c"><geometry><sphere><radius>1</radius></sphere></geometry></collision></link>
    <joint name="elbow" type="revolute"><parent>base</parent><child>arm</child><pose>0 0 -1 0 0 0</pose>
      <axis><xyz expressed_in="base">0 1 0</xyz>
      <limit><lower>-1</lower><upper>1</upper></limit></axis></joint>
    <model name="hand"><pose>0 0 3 0 0 0</pose><link name="palm"><inertial/></link></model>
    <joint name="wrist" type="fixed"><parent>arm</parent><child>hand::palm</child></joint>
  </model>
  <state world_name="lab"><model name="robot"><pose>1 1 1 0 0 0</pose></model></state>
</world></sdf>"""
CART = """<robot name="cart"><material name="blue"><color rgba="0 0 1 1"/></material>
  <link name="base"><inertial><origin xyz="0 0 1" rpy="0 0 0"/><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1"/></inertial>
    <visual><geometry><box size="1 1 1"/></geometry><material name="blue"/></visual>
    <collision><geometry><sphere radius="1"/></geometry></collision></link>
  <link name="arm"><collision><geometry><cylinder radius="1" length="1"/></geometry></collision></link>
  <joint name="j" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 1"/>
    <axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="5" velocity="2"/><dynamics damping="0.1"/></joint>
  <gazebo reference="base"><mu1>0.5</mu1><material>Gazebo/Red</material><sensor name="eye" type="camera">
    <update_rate>9</update_rate><camera><image><width>4</width><height>3</height></image></camera></sensor>
  </gazebo>
</robot>"""
SOUND = {
    "arm": ET.fromstring(ARM),
    "cart": ET.fromstring(CART),
    "husky": ET.parse(SHIPPED / "husky.sdf").getroot(),
}


@st.composite
def damaged(draw: st.DrawFn, sound: ET.Element) -> ET.Element:
    """Change one to three elements of a tree."""
    root = deepcopy(sound)
    for _ in range(draw(st.integers(1, 3))):
        elements = list(root.iter())
        element = elements[draw(st.integers(0, len(elements) - 1))]
        _damage(draw, element, elements)
    return root


def _damage(draw: st.DrawFn, element: ET.Element, elements: list[ET.Element]) -> None:
    other = elements[draw(st.integers(0, len(elements) - 1))]
    match draw(st.sampled_from(("text", "attribute", "remove", "repeat", "graft", "rename", "forget"))):
        case "text":
            element.text = draw(st.sampled_from(WORDS))
        case "attribute" if element.attrib:
            element.attrib[draw(st.sampled_from(sorted(element.attrib)))] = draw(st.sampled_from(WORDS))
        case "forget" if element.attrib:
            del element.attrib[draw(st.sampled_from(sorted(element.attrib)))]
        case "remove" if len(element):
            element.remove(element[draw(st.integers(0, len(element) - 1))])
        case "repeat" if len(element):
            element.append(deepcopy(element[draw(st.integers(0, len(element) - 1))]))
        case "graft":
            element.append(deepcopy(other))
        case "rename":
            element.tag = other.tag


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("damaged")


@pytest.mark.one_of(6)
@pytest.mark.parametrize("name", sorted(SOUND))
@settings(max_examples=150, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_a_damaged_file_is_usable_or_refused_in_a_sentence(
    folder: Path, name: str, data: st.DataObject
) -> None:
    path = folder / f"{name}.sdf"
    path.write_bytes(ET.tostring(data.draw(damaged(SOUND[name]))))
    try:
        scene = read_scene(path)
    except SceneError as refusal:
        assert_is_a_sentence(refusal, path)
        return
    assert_usable(scene)
    assert len(scene.warnings) == len(set(scene.warnings))
    assert all(str(path) in str(warning) for warning in scene.warnings)


def assert_is_a_sentence(refusal: SceneError, path: Path) -> None:
    assert "\n" not in refusal.message
    assert refusal.path == path
    assert refusal.line


def assert_usable(scene: Scene) -> None:
    for model, link in scene.links():
        for part in (*link.visuals, *link.collisions):
            if isinstance(part.geometry, (Box, Capsule, Cylinder, Sphere)):
                assert all(size > 0 for size in numbers_in(part.geometry))
        assert all(map(isfinite, numbers_in((model.pose, link.pose, link.inertial, link.visuals))))
        assert link.inertial is None or link.inertial.mass > 0
    for model in scene.models:
        bodies_of(model)


def numbers_in(value: Any) -> list[float]:
    if isinstance(value, float):
        return [value]
    if isinstance(value, tuple):
        return [number for item in value for number in numbers_in(item)]
    if is_dataclass(value):
        return [number for each in fields(value) for number in numbers_in(getattr(value, each.name))]
    return []


@settings(max_examples=50)
@given(data=st.data())
def test_a_file_cut_short_is_refused_with_its_line(folder: Path, data: st.DataObject) -> None:
    path = folder / "cut.sdf"
    path.write_text(ARM[: data.draw(st.integers(0, len(ARM) - 1))])
    with pytest.raises(SceneError, match="not well-formed XML") as refusal:
        read_scene(path)
    assert refusal.value.line


def test_the_omitted_parts_of_a_line_are_reported_once(tmp_path: Path) -> None:
    """Of a line with several elements a sound one may go first."""
    path = tmp_path / "line.sdf"
    bad = '<link name="l"><pose>0 0 0 0 0</pose><inertial/></link>'
    path.write_text(f'<sdf version="1.9"><model name="m"><link name="k"/>{bad}</model></sdf>')
    _, findings = read_without(lambda without: read_scene(path, without=without))
    told = [str(each) for each in findings if "<pose> must hold 6 numbers" in str(each)]
    assert len(told) == 1
