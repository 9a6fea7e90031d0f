from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf

import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.devices import Noise
from nrp_core.scene.model import Model
from nrp_core.scene.rigid import Pose
from nrp_core.world.drives.wheels import WheelDrive
from nrp_core.world.sensors.camera import Camera
from nrp_core.world.sensors.laser import Laser

ModelReader = Callable[..., Model]


@pytest.fixture
def sensor(model: ModelReader) -> Callable[..., Model]:
    """Read a model with a sensor, which starts in line 5 of the file."""

    def read(inside: str, *, kind: str = "camera", name: str = "robot") -> Model:
        return model(
            f'<link name="eye"><inertial/>\n<sensor name="cam" type="{kind}">{inside}</sensor></link>',
            name=name,
        )

    return read


def camera(read: Model) -> Camera:
    (found,) = read.links[0].sensors
    return found


RATE = "<update_rate>30</update_rate>"


def test_a_camera_is_read(sensor: Callable[..., Model]) -> None:
    read = sensor(
        "<pose>0 0 1 0 0 0</pose><update_rate>25</update_rate><topic>image</topic><camera>"
        "<horizontal_fov>1.5</horizontal_fov><image><width>64</width><height>48</height></image>"
        "<clip><near>0.2</near><far>50</far></clip></camera>"
    )
    expected = Camera("cam", "/robot/image", 25, 1.5, 64, 48, 0.2, 50, Pose((0, 0, 1)))
    assert camera(read) == replace(expected, info_topic="/robot/camera_info")
    assert read.warnings == ()


def test_omitted_settings_of_a_camera_have_the_defaults_of_the_specification(
    sensor: Callable[..., Model],
) -> None:
    read = camera(sensor(f"{RATE}<camera/>"))
    assert (read.horizontal_fov, read.width, read.height, read.near, read.far) == (1.047, 320, 240, 0.1, 100)


@pytest.mark.parametrize(
    ("inside", "topic"),
    [
        ("", "/husky/eye/cam/image"),
        ("<topic>camera</topic>", "/husky/camera"),
        ("<topic>/camera</topic>", "/camera"),
        ("<topic>~/camera</topic>", "/husky/camera"),
        (
            '<topic>ignored</topic><plugin name="p" filename="libgazebo_ros_camera.so">'
            "<cameraName>front</cameraName><imageTopicName>image</imageTopicName></plugin>",
            "/husky/front/image",
        ),
        (
            '<plugin name="p" filename="libgazebo_ros_camera.so">'
            "<cameraName>front</cameraName><imageTopicName>/image</imageTopicName></plugin>",
            "/image",
        ),
        (
            '<plugin name="p" filename="libgazebo_ros_camera.so"><robotNamespace>/left</robotNamespace>'
            "<cameraName>front</cameraName></plugin>",
            "/left/front/image_raw",
        ),
        (
            '<plugin name="p" filename="libgazebo_ros_camera.so"><ros><namespace>demo</namespace></ros>'
            "<camera_name>front</camera_name></plugin>",
            "/husky/demo/front/image_raw",
        ),
        (
            '<plugin name="p" filename="libgazebo_ros_camera.so"><ros><namespace>/demo</namespace>'
            "<remapping>front/image_raw:=front/seen</remapping></ros>"
            "<camera_name>front</camera_name></plugin>",
            "/demo/front/seen",
        ),
        (
            '<plugin name="p" filename="libgazebo_ros_camera.so"><ros>'
            "<remapping>/front/camera_info:=/front/color/camera_info</remapping>"
            "<remapping>/front/image_raw:=/front/color/image_raw</remapping></ros>"
            "<camera_name>front</camera_name></plugin>",
            "/front/color/image_raw",
        ),
    ],
)
def test_the_topic_of_a_camera_is_the_plugins_else_its_own(
    sensor: Callable[..., Model], inside: str, topic: str
) -> None:
    assert camera(sensor(f"{RATE}{inside}<camera/>", name="husky")).topic == topic


def test_a_camera_without_a_rate_gets_one_with_a_warning(
    sensor: Callable[..., Model], golden: Golden
) -> None:
    read = sensor("<camera/>")
    assert camera(read).rate_hz == 30
    assert "<update_rate>: 30" in str(read.warnings[0])
    golden(str(read.warnings[0]))


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ("", "<sensor> needs a <camera>"),
        ("<camera><image><width>0</width></image></camera>", "<width>"),
        ("<camera><image><width>10.5</width></image></camera>", "10.5.*240"),
        (
            "<camera><image><width>100000</width><height>100000</height></image></camera>",
            "'cam'.*100000.*100000.*268,435,456",
        ),
        ("<camera><horizontal_fov>3.2</horizontal_fov></camera>", "3.2"),
        (
            "<camera><clip><near>5</near><far>1</far></clip></camera>",
            "",
        ),
    ],
)
def test_a_camera_that_cannot_be_is_refused(
    sensor: Callable[..., Model], inside: str, message: str, golden: Golden
) -> None:
    with golden.raises(SceneError, match=message) as refusal:
        sensor(inside)
    assert refusal.value.line == 5


def test_a_camera_has_noise_but_no_distortion(sensor: Callable[..., Model], golden: Golden) -> None:
    noise = "<noise><type>gaussian</type><mean>0.1</mean><stddev>0.2</stddev></noise>"
    read = sensor(f"{RATE}<camera>{noise}<distortion><k1>1</k1></distortion></camera>")
    assert read.links[0].sensors[0].noise == Noise(0.1, 0.2)
    (warning,) = read.warnings
    assert "<distortion>" in str(warning)
    golden(str(warning))


def test_other_sensors_are_warned_of_once(model: ModelReader, golden: Golden) -> None:
    sensors = "".join(f'<sensor name="{n}" type="thermal"/>\n' for n in "ab")
    read = model(f'<link name="eye"><inertial/>\n{sensors}</link>')
    assert read.links[0].sensors == ()
    (warning,) = read.warnings
    assert "robot.sdf:5" in str(warning)
    golden(str(warning))


def test_sensors_that_share_a_topic_get_one_each_in_a_row_of_them(model: ModelReader) -> None:
    imu = '<sensor name="{}" type="imu"><topic>/sonar</topic><update_rate>50</update_rate></sensor>\n'
    taken = imu.format("c").replace("/sonar", "/sonar_2")
    read = model(f'<link name="eye"><inertial/>\n{imu.format("a")}{imu.format("b")}{taken}</link>')
    assert [each.topic for each in read.links[0].sensors] == ["/sonar", "/sonar_3", "/sonar_2"]
    (warning,) = read.warnings
    said = (
        "the sensors 'a' of 'eye' and 'b' of 'eye' have the topic '/sonar': that of the second is '/sonar_3'"
    )
    assert said in str(warning)


def test_a_sonar_has_its_ranges_on_the_topic_of_its_scans_also_if_that_is_taken(model: ModelReader) -> None:
    ranges = "<topic>/sonar</topic><sonar><min>0.1</min><max>2</max></sonar>"
    sonar = f'<sensor name="{{}}" type="sonar">{ranges}</sensor>'
    read = model(f'<link name="eye"><inertial/>{sonar.format("a")}{sonar.format("b")}</link>')
    topics = [(each.topic, each.range_topic) for each in read.links[0].sensors if isinstance(each, Laser)]
    assert topics == [("/sonar", "/sonar"), ("/sonar_2", "/sonar_2")]


def test_the_second_of_two_sensors_of_one_name_gets_another_one(model: ModelReader, golden: Golden) -> None:
    imu = '<sensor name="a" type="imu"><update_rate>50</update_rate></sensor>\n'
    read = model(f'<link name="eye"><inertial/>\n{imu}{imu}{imu}</link>')
    assert [each.name for each in read.links[0].sensors] == ["a", "a_2", "a_3"]
    assert len({each.topic for each in read.links[0].sensors}) == 3
    first, second = read.warnings
    assert "robot.sdf:6" in str(first)
    golden(str(first))
    assert "renamed 'a_3'" in str(second)


# -- drives

LINKS = "".join(f'<link name="{name}"><inertial/></link>' for name in ("base", "fl", "fr", "bl", "br"))
JOINTS = "".join(
    f'<joint name="{name}_joint" type="continuous"><parent>base</parent><child>{name}</child></joint>'
    for name in ("fl", "fr", "bl", "br")
)


@pytest.fixture
def drive(model: ModelReader) -> Callable[[str], WheelDrive]:
    """Read the one drive of a four-wheeled model, whose plugin starts in line 5."""

    def read(plugin: str) -> WheelDrive:
        robot = model(f"{LINKS}{JOINTS}\n{plugin}", name="husky")
        assert robot.warnings == ()
        (found,) = robot.drives
        return found

    return read


DriveReader = Callable[[str], WheelDrive]


def test_the_huskys_plugin_is_a_drive(drive: DriveReader) -> None:
    wheels = "".join(
        f"<{tag}Joint>{name}_joint</{tag}Joint>"
        for tag, name in (("backLeft", "bl"), ("backRight", "br"), ("frontLeft", "fl"), ("frontRight", "fr"))
    )
    plugin = f'<plugin name="drive" filename="libhusky_gazebo_plugins.so">{wheels}'
    assert drive(plugin + "</plugin>") == WheelDrive(
        name="drive",
        command_topic="/husky/husky/cmd_vel",
        left=("bl_joint", "fl_joint"),
        right=("br_joint", "fr_joint"),
        separation=0.55,
        wheel_diameter=0.3,
        torque=15,
        timeout=0.1,
        rate_hz=100,
        odometry_topic="/husky/odom",
        wheel_speeds_topic="/husky/husky/wheel_speeds",
    )
    other = drive(
        f"{plugin}<wheelSeparation>0.6</wheelSeparation><wheelDiameter>0.4</wheelDiameter><torque>35</torque>"
        "<updateRate>50</updateRate><commandTopic>go</commandTopic><commandTimeout>0.2</commandTimeout></plugin>"
    )
    assert (other.separation, other.wheel_diameter, other.torque, other.rate_hz) == (0.6, 0.4, 35, 50)
    assert (other.command_topic, other.timeout) == ("/husky/go", 0.2)


def test_gazebos_differential_drive_for_ros_1(drive: DriveReader) -> None:
    read = drive(
        '<plugin name="d" filename="libgazebo_ros_diff_drive.so"><leftJoint>bl_joint</leftJoint>'
        "<rightJoint>br_joint</rightJoint><wheelTorque>7</wheelTorque><robotNamespace>/r1</robotNamespace>"
        "<odometryTopic>/odom</odometryTopic></plugin>"
    )
    assert replace(read, pose_variances=(), twist_variances=()) == WheelDrive(
        "d", "/r1/cmd_vel", ("bl_joint",), ("br_joint",), 0.34, 0.15, 7, inf, 100, "/odom", None
    )
    assert read.pose_variances == read.twist_variances == (1e-5, 1e-5, 1e12, 1e12, 1e12, 1e-3)


@pytest.mark.parametrize(
    ("left", "mode", "told"),
    [
        ("fl", "", True),
        ("fl", "<legacyMode>true</legacyMode>", True),
        ("fl", "<legacyMode>false</legacyMode>", False),
        ("fr", "", False),
        ("fr", "<legacyMode>true</legacyMode>", False),
    ],
)
def test_joints_that_are_named_the_other_way_round_for_the_old_mode_of_the_plugin_are_exchanged(
    model: ModelReader, left: str, mode: str, told: bool
) -> None:
    right = {"fl": "fr", "fr": "fl"}[left]
    inside = f"<leftJoint>{left}_joint</leftJoint><rightJoint>{right}_joint</rightJoint>{mode}"
    plugin = f'<plugin name="d" filename="libgazebo_ros_diff_drive.so">{inside}</plugin>'
    robot = model(f'<link name="base"><inertial/></link>{ROLLERS}{JOINTS}{plugin}')
    (drive,) = robot.drives
    assert isinstance(drive, WheelDrive)
    assert (drive.left, drive.right) == (("fl_joint",), ("fr_joint",))
    assert ["exchanges the sides" in str(warning) for warning in robot.warnings] == [True] * told


def test_gazebos_differential_drive_for_ros_2(drive: DriveReader) -> None:
    read = drive(
        '<plugin name="d" filename="libgazebo_ros_diff_drive.so"><ros><namespace>/demo</namespace>'
        "<remapping>cmd_vel:=go</remapping></ros><left_joint>bl_joint</left_joint>"
        "<right_joint>br_joint</right_joint><wheel_separation>0.5</wheel_separation>"
        "<wheel_diameter>0.2</wheel_diameter><max_wheel_torque>20</max_wheel_torque></plugin>"
    )
    assert replace(read, pose_variances=(), twist_variances=()) == WheelDrive(
        "d", "/demo/go", ("bl_joint",), ("br_joint",), 0.5, 0.2, 20, inf, 100, "/demo/odom", None
    )


def test_gazebos_skid_steer_drive(drive: DriveReader) -> None:
    read = drive(
        '<plugin name="d" filename="libgazebo_ros_skid_steer_drive.so">'
        "<leftFrontJoint>fl_joint</leftFrontJoint><rightFrontJoint>fr_joint</rightFrontJoint>"
        "<leftRearJoint>bl_joint</leftRearJoint><rightRearJoint>br_joint</rightRearJoint></plugin>"
    )
    assert (read.left, read.right) == (("bl_joint", "fl_joint"), ("br_joint", "fr_joint"))
    assert (read.separation, read.wheel_diameter, read.torque) == (0.4, 0.15, 5)


ROLLERS = "".join(
    f'<link name="{name}"><pose>{x} {y} 0 0 0 0</pose><inertial/><collision name="c"><geometry><cylinder>'
    f"<radius>0.15</radius><length>0.1</length></cylinder></geometry></collision></link>"
    for name, x, y in (("fl", 0.3, 0.25), ("fr", 0.3, -0.25), ("bl", -0.3, 0.25), ("br", -0.3, -0.25))
)


def test_the_drive_among_gazebos_own_plugins_takes_its_sizes_from_the_wheels(model: ModelReader) -> None:
    inside = "<left_joint>fl_joint</left_joint><right_joint>fr_joint</right_joint><torque>9</torque>"
    plugin = f'<plugin name="d" filename="libDiffDrivePlugin.so">{inside}</plugin>'
    robot = model(f'<link name="base"><inertial/></link>{ROLLERS}{JOINTS}{plugin}')
    assert robot.warnings == ()
    wheels = ("fl_joint",), ("fr_joint",)
    assert robot.drives == (WheelDrive("d", "/robot/vel_cmd", *wheels, 0.5, 0.3, 9.0, inf, 100),)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0.25 0 0", "0 0 0", "'fl_joint'.*'fr_joint'"),
        ("cylinder>", "empty>", "'fl'"),
    ],
)
def test_wheels_without_a_size_are_refused(
    model: ModelReader, old: str, new: str, message: str, golden: Golden
) -> None:
    links = f'<link name="base"><inertial/></link>{ROLLERS.replace("-0.25", "0.25").replace(old, new)}'
    inside = "<left_joint>fl_joint</left_joint><right_joint>fr_joint</right_joint>"
    with golden.raises(SceneError, match=message):
        model(f'{links}{JOINTS}<plugin name="d" filename="libDiffDrivePlugin.so">{inside}</plugin>')


@pytest.mark.parametrize("scope", ["gz::sim", "ignition::gazebo"])
def test_the_differential_drive_of_gz_sim(drive: DriveReader, scope: str) -> None:
    read = drive(
        f'<plugin name="{scope}::systems::DiffDrive" filename="gz-sim-diff-drive-system">'
        "<left_joint>bl_joint</left_joint><left_joint>fl_joint</left_joint>"
        "<right_joint>br_joint</right_joint><right_joint>fr_joint</right_joint>"
        "<wheel_separation>1.25</wheel_separation><wheel_radius>0.3</wheel_radius></plugin>"
    )
    assert (read.left, read.right) == (("bl_joint", "fl_joint"), ("br_joint", "fr_joint"))
    assert (read.separation, read.wheel_diameter, read.torque) == (1.25, 0.6, inf)
    assert (read.command_topic, read.odometry_topic) == ("/model/husky/cmd_vel", "/model/husky/odometry")


@pytest.mark.parametrize(
    ("inside", "message", "line"),
    [
        ("", "", 5),
        ("<leftJoint>bl_joint</leftJoint>", "<rightJoint>", 5),
        (
            "<leftJoint>bl_joint</leftJoint>\n<rightJoint>bl_jiont</rightJoint>",
            "'bl_jiont'.*'bl_joint'",
            6,
        ),
        (
            "<leftJoint>bl_joint</leftJoint><rightJoint>br_joint</rightJoint><wheelDiameter>0</wheelDiameter>",
            "<wheelDiameter>",
            5,
        ),
    ],
)
def test_a_drive_that_cannot_be_is_refused(
    drive: DriveReader, inside: str, message: str, line: int, golden: Golden
) -> None:
    with golden.raises(SceneError, match=message) as refusal:
        drive(f'<plugin name="d" filename="libgazebo_ros_diff_drive.so">{inside}</plugin>')
    assert refusal.value.line == line


def test_nested_models_that_are_alike_have_topics_of_their_own(model: ModelReader) -> None:
    camera = '<sensor name="eye" type="camera"><camera/></sensor>'
    read = model(
        "".join(
            f'<model name="{side}"><link name="head"><inertial/>{camera}</link></model>'
            for side in ("left", "right")
        )
    )
    topics = [sensor.topic for link in read.links for sensor in link.sensors]
    assert topics == ["/robot/left/head/eye/image", "/robot/right/head/eye/image"]


def test_a_drive_of_a_nested_model_keeps_its_wheels(model: ModelReader) -> None:
    plugin = (
        '<plugin name="d" filename="libgazebo_ros_diff_drive.so"><leftJoint>bl_joint</leftJoint>'
        "<rightJoint>br_joint</rightJoint></plugin>"
    )
    read = model(f'<model name="cart">{LINKS}{JOINTS}{plugin}</model>')
    assert read.drives[0].left == ("cart::bl_joint",)
    assert read.drives[0].command_topic == "/robot/cmd_vel"


def test_an_unknown_plugin_is_warned_of(model: ModelReader, golden: Golden) -> None:
    plugin = '\n<plugin name="p" filename="libmy_thing.so"><anything><goes/></anything></plugin>'
    (warning,) = model(LINKS.split('<link name="fl">')[0] + plugin).warnings
    assert "robot.sdf:5" in str(warning)
    golden(str(warning))


@pytest.mark.parametrize(
    "system",
    ["Physics", "SceneBroadcaster", "UserCommands", "Sensors", "NavSat", "AirPressure", "LogicalCamera"],
)
def test_elements_that_gazebo_itself_needs_cause_no_warning(
    world: Callable[..., object], system: str
) -> None:
    scene = world(f'<plugin name="gz::sim::systems::{system}" filename="gz-sim-x-system"/>')
    assert scene.warnings == ()  # type: ignore[attr-defined]


# -- joint states


def test_a_robot_with_movable_joints_serves_their_states(model: ModelReader) -> None:
    assert model(LINKS + JOINTS, name="husky").joint_states_topic == "/husky/joint_states"
    publisher = (
        '<plugin name="gz::sim::systems::JointStatePublisher" filename="x"><topic>/js</topic></plugin>'
    )
    read = model(LINKS + JOINTS + publisher)
    assert read.joint_states_topic == "/js"
    assert read.warnings == ()


def test_a_robot_without_movable_joints_has_no_joint_states(model: ModelReader) -> None:
    fixed = JOINTS.replace("continuous", "fixed")
    assert model(LINKS + fixed).joint_states_topic is None
