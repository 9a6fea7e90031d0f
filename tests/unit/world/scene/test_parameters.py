"""Parameters of plugins and elements of sensors without effect, and right ones that look alike."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core import Scene, read_model
from nrp_core.errors import SceneError
from nrp_core.world.scene.implausible import implausible

_BODY = "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>"
_CART = """<sdf version="1.9"><model name="cart">
  <link name="base">{body}{sensor}</link>
  <link name="l">{body}</link><link name="r">{body}</link>
  <joint name="left" type="continuous"><pose>0 0.2 0 0 0 0</pose><parent>base</parent><child>l</child>
    {in_joint}<axis><xyz>0 1 0</xyz></axis></joint>
  <joint name="right" type="continuous"><parent>base</parent><child>r</child>
    <axis><xyz>0 1 0</xyz></axis></joint>
  {plugin}
</model></sdf>
"""
_DRIVE = """<plugin name="drive" filename="libgazebo_ros_diff_drive.so">
  <leftJoint>left</leftJoint><rightJoint>right</rightJoint><legacyMode>false</legacyMode>
  <wheelSeparation>0.4</wheelSeparation><wheelDiameter>0.2</wheelDiameter>{more}</plugin>"""


def _warnings(folder: Path, **parts: str) -> list[str]:
    path = folder / "cart.sdf"
    path.write_text(_CART.format(body=_BODY, **{"sensor": "", "in_joint": "", "plugin": "", **parts}))
    return [str(warning) for warning in read_model(path).warnings]


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("<commandTopc>go</commandTopc>", "did you mean <commandTopic>?"),
        ("<wheelDiamater>0.3</wheelDiamater>", "did you mean <wheelDiameter>?"),
        (
            "<wheelDiameter>0.3</wheelDiameter>",
            "a second <wheelDiameter> in the plugin 'gazebo_ros_diff_drive'",
        ),
        (
            "<publishOdomTF>falze</publishOdomTF>",
            "<publishOdomTF> is 'falze', which is neither true nor false",
        ),
        ("<odometryRate>fast</odometryRate>", "<odometryRate> is 'fast', which is not a n"),
        ("<publishWheelTF>no</publishWheelTF>", "<publishWheelTF> is 'no', which is neither true nor false"),
    ],
)
def test_a_parameter_of_a_drive_without_effect_is_reported(tmp_path: Path, more: str, message: str) -> None:
    (warning,) = _warnings(tmp_path, plugin=_DRIVE.format(more=more))
    assert message in warning


@pytest.mark.parametrize(
    "more",
    [
        "<wheelDiameter>0.2</wheelDiameter>",
        "<updateRateHZ>20.0</updateRateHZ><gaussianNoise>0 0.1 0</gaussianNoise><odometryRate/>",
        "<odometryFrame>odom</odometryFrame><robotBaseFrame>base</robotBaseFrame><rosDebugLevel>na</rosDebugLevel>",
        "<publishWheelTF>False</publishWheelTF><publishTf>1</publishTf><publishOdomTF>true</publishOdomTF>",
        "<wheelAcceleration>1.8</wheelAcceleration><wheelTorque>20</wheelTorque><alwaysOn>true</alwaysOn>",
        "<odometrySource>world</odometrySource><broadcastTF>0</broadcastTF><publishTopic>tree</publishTopic>",
    ],
)
def test_other_parameters_of_gazebo_s_drive_are_not_reported(tmp_path: Path, more: str) -> None:
    assert not _warnings(tmp_path, plugin=_DRIVE.format(more=more))


def test_a_car_whose_flag_cannot_be_read_is_refused(tmp_path: Path) -> None:
    corners = ("rear_left", "rear_right", "front_left", "front_right")
    wheels = "".join(f"<{corner}_joint>left</{corner}_joint>" for corner in corners)
    ball = '<collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>'
    plugin = f"""<plugin name="car" filename="libgazebo_ros_ackermann_drive.so">{wheels}
      <publish_odom>falze</publish_odom></plugin>"""
    path = tmp_path / "cart.sdf"
    path.write_text(_CART.format(body=_BODY + ball, sensor="", in_joint="", plugin=plugin))
    with pytest.raises(SceneError, match="<publish_odom> is 'falze'; did you mean 'false'"):
        read_model(path)


_RANGES = (
    "<scan><horizontal><samples>9</samples></horizontal></scan><range><min>0.1</min><max>5</max></range>"
)


@pytest.mark.parametrize(
    ("kind", "settings", "message"),
    [
        ("sonar", f"<ray>{_RANGES}</ray>", "<ray> has no effect in the sensor 's', which is of type 'sonar'"),
        (
            "imu",
            "<camera><horizontal_fov>1</horizontal_fov></camera>",
            "<camera> has no effect in the sensor",
        ),
        ("contact", "<contact/><transceiver/>", "<transceiver> has no effect in the sensor 's'"),
        ("ray", f"<lidar>{_RANGES}</lidar><ray>{_RANGES}</ray>", "<ray> has no effect in the sensor 's'"),
        ("ray", f"<ray>{_RANGES}</ray>", ""),
        ("gpu_ray", f"<lidar>{_RANGES}</lidar>", ""),
        ("gps", "<navsat/>", ""),
        ("depth", "<camera><horizontal_fov>1</horizontal_fov></camera><visualize>1</visualize>", ""),
        ("imu", "<imu/><always_on>1</always_on><enable_metrics>0</enable_metrics>", ""),
    ],
)
def test_an_element_of_another_type_of_sensor_is_reported(
    tmp_path: Path, kind: str, settings: str, message: str
) -> None:
    sensor = f'<sensor name="s" type="{kind}"><update_rate>10</update_rate>{settings}</sensor>'
    warnings = [warning for warning in _warnings(tmp_path, sensor=sensor) if "has no effect" in warning]
    assert [message in warning for warning in warnings] == [True] * bool(message)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            "<frame>chlid</frame>",
            "<frame> must be one of child, parent, sensor, not 'chlid'; did you mean 'child'",
        ),
        (
            "<measure_direction>child_to_parrent</measure_direction>",
            "did you mean 'child_to_parent'",
        ),
    ],
)
def test_a_word_of_a_force_sensor_that_is_not_one_is_refused(
    tmp_path: Path, settings: str, message: str
) -> None:
    sensor = f'<sensor name="s" type="force_torque"><force_torque>{settings}</force_torque></sensor>'
    with pytest.raises(SceneError, match=message):
        _warnings(tmp_path, in_joint=sensor)


@pytest.mark.parametrize(
    ("name", "topic", "is_reported"),
    [("eye", "my scan", True), ("eye", "my_scan", False), ("my eye", "", False), ("eye", "", False)],
)
def test_a_topic_with_a_blank_is_reported_unless_a_part_has_one(
    tmp_path: Path, name: str, topic: str, is_reported: bool
) -> None:
    written = f"<topic>{topic}</topic>" if topic else ""
    path = tmp_path / "cart.sdf"
    sensor = f'<sensor name="{name}" type="imu"><update_rate>10</update_rate>{written}</sensor>'
    path.write_text(_CART.format(body=_BODY, sensor=sensor, in_joint="", plugin=""))
    said = [sentence for _, sentence in implausible(Scene((read_model(path),)), [])]
    assert [f"the topic '/cart/{topic}' of 'cart' has a blank" in one for one in said] == [True] * is_reported
