"""Values of sensors and controllers that are legal, and surely not meant."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core import read_model

_BOT = """<sdf version="1.9"><model name="bot">
  <link name="base">
    <inertial><mass>5</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>
    <collision name="hull"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>
    <sensor name="scan" type="gpu_lidar"><update_rate>10</update_rate>
      <lidar><scan><horizontal><samples>10</samples>{angles}</horizontal></scan>
        <range><min>0.1</min><max>8</max></range></lidar></sensor>
  </link>
  <link name="arm">
    <inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>
  <joint name="shoulder" type="revolute"><parent>base</parent><child>arm</child><axis><xyz>0 1 0</xyz>
    <limit><lower>-1</lower><upper>1</upper></limit></axis></joint>
  <plugin name="gz::sim::systems::JointPositionController" filename="gz-sim-joint-position-controller-system">
    <joint_name>shoulder</joint_name>{gains}</plugin>
</model></sdf>
"""
_ANGLES = "<min_angle>-3.1416</min_angle><max_angle>3.1416</max_angle>"
_GAINS = "<p_gain>2</p_gain><i_gain>0</i_gain><d_gain>0.1</d_gain><cmd_max>1000</cmd_max>"


def _warnings(folder: Path, angles: str = _ANGLES, gains: str = _GAINS) -> list[str]:
    path = folder / "bot.sdf"
    path.write_text(_BOT.format(angles=angles, gains=gains))
    return [str(warning) for warning in read_model(path).warnings]


@pytest.mark.parametrize(
    ("angles", "message"),
    [
        ("<min_angle>-90</min_angle><max_angle>90</max_angle>", "more than a turn; angles are in radians"),
        ("<min_angle>1</min_angle><max_angle>-1</max_angle>", "is above its <max_angle>"),
    ],
)
def test_angles_of_a_laser_that_cannot_be_meant_are_reported(
    tmp_path: Path, angles: str, message: str
) -> None:
    (warning,) = _warnings(tmp_path, angles=angles)
    assert message in warning


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ("<p_gian>2</p_gian>", "<p_gian> is not a parameter of the plugin 'JointPositionController'"),
        ("<p_gain>-2</p_gain>", "the <p_gain> of 'shoulder' is negative"),
    ],
)
def test_parameters_of_a_controller_that_cannot_be_meant_are_reported(
    tmp_path: Path, gains: str, message: str
) -> None:
    (warning,) = _warnings(tmp_path, gains=gains)
    assert message in warning


def test_a_full_turn_and_gains_of_a_controller_are_not_reported(tmp_path: Path) -> None:
    assert not _warnings(tmp_path)


_TWO = """<sdf version="1.9"><model name="bot">
  <link name="base">{body}{on_link}</link><link name="arm">{body}</link>
  <joint name="shoulder" type="revolute"><parent>base</parent><child>arm</child>{on_joint}<axis>
    <xyz>0 1 0</xyz><limit><lower>-1</lower><upper>1</upper></limit><dynamics>{dynamics}</dynamics>
  </axis></joint>
</model></sdf>
"""
_BODY = "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"
_RATE = "<update_rate>10</update_rate></sensor>"
_FORCE, _IMU = f'<sensor name="f" type="force_torque">{_RATE}', f'<sensor name="i" type="imu">{_RATE}'


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"on_link": _FORCE}, "'force_torque' belongs in a <joint> [NRP262]"),
        ({"on_joint": _IMU}, "of type 'imu' belongs in a <link> [NRP262]"),
        ({"dynamics": "<friction>-1</friction>"}, "is -1, which would push it: the value used is 0 [NRP264]"),
        ({"dynamics": "<spring_stiffness>-2</spring_stiffness>"}, "<spring_stiffness> of the joint"),
        ({"on_joint": _FORCE, "on_link": _IMU}, ""),
    ],
)
def test_sensors_of_the_wrong_holder_and_pushing_joints_are_reported(
    tmp_path: Path, parts: dict[str, str], message: str
) -> None:
    path = tmp_path / "bot.sdf"
    path.write_text(_TWO.format(body=_BODY, **{"on_link": "", "on_joint": "", "dynamics": "", **parts}))
    warnings = [str(warning) for warning in read_model(path).warnings]
    assert len(warnings) == bool(message)
    assert all(message in warning for warning in warnings)
