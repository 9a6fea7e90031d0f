"""A model's own file reaches Gazebo as it is; only what the experiment decides is changed."""

from dataclasses import replace

import pytest
from golden import Golden
from lxml import etree
from nrp_world_gazebo.own_files import NotOwnError, folders_of, own_sdf

from nrp_core.world import Inertial, Link, Model, read_model
from nrp_core.world.engine_kit.simulated import simulated_bodies

ROVER = """<?xml version="1.0"?>
<sdf version="1.6">
  <model name="rover">
    <link name="body">
      <pose>0 0 0.1 0 0 0</pose>
      <inertial><mass>5</mass></inertial>
      <collision name="c">
        <geometry><box><size>0.4 0.3 0.1</size></box></geometry>
        <surface><friction><ode><mu>0.7</mu><slip1>0.01</slip1></ode></friction></surface>
      </collision>
      <visual name="v">
        <geometry><box><size>0.4 0.3 0.1</size></box></geometry>
        <material>
          <script><uri>materials/scripts/rover.material</uri><name>Rover/Paint</name></script>
          <shader type="pixel"/>
        </material>
      </visual>
      <sensor name="bumper" type="contact"><contact><collision>c</collision></contact></sensor>
    </link>
    {wheels}
    <plugin name="thrust" filename="libMyThruster.so"><gain unit="N">3.5</gain></plugin>
  </model>
</sdf>
"""
WHEEL = """
    <link name="{side}">
      <pose>0 {y} 0.1 -1.5707963 0 0</pose>
      <inertial><mass>0.5</mass></inertial>
      <collision name="tyre">
        <geometry><cylinder><radius>0.1</radius><length>0.05</length></cylinder></geometry>
        <surface><friction><ode><mu>1.1</mu></ode></friction></surface>
      </collision>
    </link>
    <joint name="{side}_axle" type="revolute"><parent>body</parent><child>{side}</child>
      <axis><xyz>0 0 1</xyz><dynamics><friction>0.1</friction></dynamics></axis></joint>
"""
DRIVE = """
    <plugin name="drive" filename="libgazebo_ros_diff_drive.so"><commandTopic>cmd_vel</commandTopic>
      <leftJoint>left_axle</leftJoint><rightJoint>right_axle</rightJoint>
      <wheelSeparation>0.4</wheelSeparation><wheelDiameter>0.2</wheelDiameter></plugin>
"""


PLAIN = ROVER.format(wheels="")


def rover(folder, text=PLAIN):
    scripts = folder / "materials/scripts"
    scripts.mkdir(parents=True, exist_ok=True)
    (scripts / "rover.material").write_text("material Rover/Paint {}")
    file = folder / "rover.sdf"
    file.write_text(text)
    return read_model(file)


def given(model, *, physical=False):
    """Return what Gazebo is given of a model."""
    return own_sdf(model, simulated_bodies(model, 0.002, physical))


def canonical(element):
    return etree.tostring(element, method="c14n2", strip_text=True)


def test_plugins_materials_sensors_and_surfaces_are_those_of_the_file(tmp_path):
    sdf = given(rover(tmp_path))
    file = etree.fromstring(PLAIN.encode(), etree.XMLParser(remove_comments=True))
    file.find(".//uri").text = f"file://{tmp_path}/materials/scripts/rover.material"
    assert canonical(sdf) == canonical(file)
    assert folders_of(sdf) == {tmp_path / "materials/scripts"}


@pytest.mark.parametrize(("physical", "friction"), [(False, "0.0"), (True, "1.1")])
def test_only_a_planar_drive_takes_the_friction_of_its_wheels(tmp_path, physical, friction):
    wheels = WHEEL.format(side="left", y=0.2) + WHEEL.format(side="right", y=-0.2) + DRIVE
    sdf = given(rover(tmp_path, ROVER.format(wheels=wheels)), physical=physical)
    assert [each.text for each in sdf.iterfind(".//link[@name='left']//mu")] == [friction]
    assert [each.text for each in sdf.iterfind(".//link[@name='body']//mu")] == ["0.7"]
    assert (sdf.find(".//joint[@name='left_axle']//friction") is None) == (not physical)


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ('version="1.6"', 'version="1.9"', "rover.sdf.*SDF 1.9.*11.*1.7"),
        ("rover.material</uri>", "other.material</uri>", "'materials/scripts/other.material'"),
    ],
)
def test_a_file_that_gazebo_would_read_otherwise_is_written_anew(tmp_path, old, new, reason, golden: Golden):
    with golden.raises(NotOwnError, match=reason):
        given(rover(tmp_path, PLAIN.replace(old, new)))


def test_a_model_that_was_changed_or_has_no_file_is_written_anew(tmp_path, golden: Golden):
    model = rover(tmp_path)
    more = replace(model, links=(*model.links, Link("mast", inertial=Inertial(1.0))))
    with golden.raises(NotOwnError):
        given(more)
    with golden.raises(NotOwnError):
        given(Model("m", (Link("link", inertial=Inertial(1.0)),)))
