"""Parameters of plugins and elements of sensors without effect, and right ones that look alike."""

from __future__ import annotations

from math import inf
from pathlib import Path

import pytest
from golden import Golden

from nrp_core import read_model
from nrp_core.errors import SceneError

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
        ("<odometryRate>20 50</odometryRate>", "<odometryRate> is '20 50', which is not a number: ignored"),
        (
            "<robotNamespace>a<commandTopic>go</commandTopic></robotNamespace>",
            "<commandTopic> in <robotNamespace> is ignored; in the plugin 'gazebo_ros_diff_drive' it",
        ),
        (
            "<ros><namepsace>a</namepsace></ros>",
            "<namepsace> is not a parameter of the plugin 'gazebo_ros_diff_drive': ignored; did you",
        ),
        (
            '<plugin name="other" filename="x.so"><topic>a</topic></plugin>',
            "<plugin> in a <plugin> is ignored; it belongs beside it",
        ),
        ("<link><pose/></link>", "<link> in a <plugin> is ignored; it belongs beside it"),
    ],
)
def test_a_parameter_of_a_drive_without_effect_is_reported(tmp_path: Path, more: str, message: str) -> None:
    (warning,) = _warnings(tmp_path, plugin=_DRIVE.format(more=more))
    assert message in warning


@pytest.mark.parametrize(
    "more",
    [
        "<wheelDiameter>0.2</wheelDiameter>",
        "<updateRateHZ>20.0</updateRateHZ><gaussianNoise>0 0.0 0</gaussianNoise><odometryRate/>",
        "<odometryFrame>odom</odometryFrame><robotBaseFrame>base</robotBaseFrame><rosDebugLevel>na</rosDebugLevel>",
        "<publishWheelTF>False</publishWheelTF><publishTf>1</publishTf><publishOdomTF>true</publishOdomTF>",
        "<wheelAcceleration>0.0</wheelAcceleration><wheelTorque>20</wheelTorque><alwaysOn>true</alwaysOn>",
        "<ros><namespace/><remapping>odom:=way</remapping><argument>--x</argument></ros><other/>",
        "<odometrySource>world</odometrySource><broadcastTF>0</broadcastTF><publishTopic>tree</publishTopic>",
    ],
)
def test_other_parameters_of_gazebo_s_drive_are_not_reported(tmp_path: Path, more: str) -> None:
    assert not _warnings(tmp_path, plugin=_DRIVE.format(more=more))


def test_parameters_that_act_in_gazebo_alone_are_one_warning_for_a_plugin(tmp_path: Path) -> None:
    more = "<slipRatio>1.8</slipRatio><updateRate>9</updateRate><slip>0 0.1</slip>"
    (warning,) = _warnings(tmp_path, plugin=_DRIVE.format(more=more))
    assert "cart.sdf:10" in warning
    assert "the plugin 'gazebo_ros_diff_drive' acts here without <slipRatio> and <slip>" in warning


def test_the_parameters_of_an_unknown_plugin_are_not_reported_beside_it(tmp_path: Path) -> None:
    plugin = '<plugin name="p" filename="libcliff.so"><threshold>0.1</threshold></plugin>'
    ray = f'<sensor name="s" type="ray"><update_rate>9</update_rate><ray>{_RANGES}</ray>{plugin}</sensor>'
    (warning,) = _warnings(tmp_path, sensor=ray)
    assert "the plugin 'cliff' is unknown and has no effect" in warning


@pytest.mark.parametrize(("least", "reported"), [("-2", False), ("-1", True)])
def test_a_lower_limit_is_reported_unless_it_is_the_upper_one_with_the_other_sign(
    tmp_path: Path, least: str, reported: bool
) -> None:
    plugin = (
        '<plugin name="gz::sim::systems::JointPositionController" filename="x"><joint_name>left</joint_name>'
        f"<p_gain>1</p_gain><i_gain>1</i_gain><i_max>2</i_max><i_min>{least}</i_min></plugin>"
    )
    assert bool(_warnings(tmp_path, plugin=plugin)) is reported


_SYSTEM = '<plugin name="gz::sim::systems::{}" filename="{}"><topic>states</topic></plugin>'


@pytest.mark.parametrize(
    ("system", "file", "slip"),
    [
        ("JointStatePublisher", "gz-sim-joint-state-publsher-system", "gz-sim-joint-state-publisher-system"),
        (
            "JointStatePublisher",
            "libignition-gazebo-joint-state-publisher-sytem.so",
            "ignition-gazebo-joint-",
        ),
        ("JointStatePublisher", "gz-sim-joint-state-publisher-system", ""),
        ("JointStatePublisher", "libignition-gazebo6-joint-state-publisher-system.so", ""),
        ("JointStatePublisher", "libour_own_publisher.so", ""),
        ("JointStatePublisher", "", ""),
    ],
)
def test_a_misspelt_file_of_a_plugin_that_is_found_by_its_class_is_reported(
    tmp_path: Path, system: str, file: str, slip: str
) -> None:
    said = _warnings(tmp_path, plugin=_SYSTEM.format(system, file))
    assert [f"did you mean '{slip}" in one for one in said] == [True] * bool(slip)


def test_a_car_whose_flag_cannot_be_read_is_refused(tmp_path: Path, golden: Golden) -> None:
    corners = ("rear_left", "rear_right", "front_left", "front_right")
    wheels = "".join(f"<{corner}_joint>left</{corner}_joint>" for corner in corners)
    ball = '<collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>'
    plugin = f"""<plugin name="car" filename="libgazebo_ros_ackermann_drive.so">{wheels}
      <publish_odom>falze</publish_odom></plugin>"""
    path = tmp_path / "cart.sdf"
    path.write_text(_CART.format(body=_BODY + ball, sensor="", in_joint="", plugin=plugin))
    with golden.raises(SceneError, match="<publish_odom>.*'falze'.*'false'"):
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
            "<frame>.*'chlid'.*'child'",
        ),
        (
            "<measure_direction>child_to_parrent</measure_direction>",
            "'child_to_parent'",
        ),
    ],
)
def test_a_word_of_a_force_sensor_that_is_not_one_is_refused(
    tmp_path: Path, settings: str, message: str, golden: Golden
) -> None:
    sensor = f'<sensor name="s" type="force_torque"><force_torque>{settings}</force_torque></sensor>'
    with golden.raises(SceneError, match=message):
        _warnings(tmp_path, in_joint=sensor)


_OF_PLUGINS = {
    "libgazebo_ros_planar_move.so": "commandTopic odometryTopic odometryFrame odometryRate=20 robotBaseFrame "
    "cmdTimeout=0.5 update_rate=100 publish_rate=10 publish_odom=true odometry_frame robot_base_frame",
    "libhector_gazebo_ros_imu.so": "bodyName=base frameId topicName serviceName updateRate=50 "
    "accelOffset=0 accelDrift=0 accelDriftFrequency=0 accelGaussianNoise=0 rateOffset=0 rateDrift=0 "
    "rateDriftFrequency=0 rateGaussianNoise=0 headingOffset=0 headingDrift=0 headingGaussianNoise=0",
    "libhector_gazebo_ros_gps.so": "bodyName=base frameId topicName velocityTopicName updateRate=4 "
    "referenceLatitude=1 referenceHeading=0 driftFrequency=0 gaussianNoise=0 velocityGaussianNoise=0",
    "gz-sim-diff-drive-system": "left_joint=left right_joint=right wheel_separation=1 wheel_radius=0.1 topic "
    "odom_topic tf_topic frame_id child_frame_id odom_publish_frequency=20 min_velocity=-1 max_velocity=1 "
    "min_acceleration=-1 max_linear_acceleration=1 max_angular_velocity=1 min_jerk=-1",
    "gz-sim-joint-position-controller-system": "joint_name=left topic sub_topic p_gain=1 i_gain=0 "
    "d_gain=0.1 i_max=1 i_min=-1 cmd_max=1000 cmd_min=-1000 cmd_offset=0 use_velocity_commands=false "
    "use_actuator_msg=false actuator_number=0 initial_position=0",
    "gz-sim-odometry-publisher-system": "odom_frame robot_base_frame odom_publish_frequency=50 odom_topic "
    "odom_covariance_topic tf_topic dimensions=3 gaussian_noise=0",
}
"""Parameters of Gazebo's plugins by their documentation; without a value, a name."""


@pytest.mark.parametrize("filename", _OF_PLUGINS)
def test_the_parameters_that_gazebo_documents_are_not_reported(tmp_path: Path, filename: str) -> None:
    given = [one.partition("=") for one in _OF_PLUGINS[filename].split()]
    tags = "".join(f"<{tag}>{value or 'some_name'}</{tag}>" for tag, _, value in given)
    plugin = f'<plugin name="p" filename="{filename}">{tags}</plugin>'
    words = ("is not a parameter", "neither true nor false", "not a number", "a second <")
    said = _warnings(tmp_path, plugin=plugin)
    assert [one for one in said if any(each in one for each in words)] == []
    misspelt = plugin.replace("opic>", "pic>").replace("updateRate>", "updateRates>")
    assert any("is not a parameter" in one for one in _warnings(tmp_path, plugin=misspelt))


@pytest.mark.parametrize(("given", "timeout_s"), [("0.5", 0.5), ("-1", inf), (None, inf)])
def test_a_base_without_wheels_stops_after_its_time_out(
    tmp_path: Path, given: str | None, timeout_s: float
) -> None:
    tag = "" if given is None else f"<cmdTimeout>{given}</cmdTimeout>"
    plugin = f'<plugin name="p" filename="libgazebo_ros_planar_move.so">{tag}</plugin>'
    path = tmp_path / "cart.sdf"
    path.write_text(_CART.format(body=_BODY, sensor="", in_joint="", plugin=plugin))
    (drive,) = read_model(path).drives
    assert getattr(drive, "timeout") == timeout_s  # noqa: B009 - of this kind of drive
