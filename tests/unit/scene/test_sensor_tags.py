"""Lasers, inertial sensors, contacts, forces, true poses and joint controllers from the tags of files."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, pi

import pytest
from golden import Golden

from nrp_core.errors import SceneError
from nrp_core.scene.devices import JointController, Noise, Pid
from nrp_core.scene.model import Model
from nrp_core.scene.rigid import Pose
from nrp_core.world.drives.ackermann import Ackermann
from nrp_core.world.drives.flight import Flight
from nrp_core.world.drives.mecanum import PlanarMove
from nrp_core.world.sensors.camera import Camera
from nrp_core.world.sensors.contact import ContactSensor, ForceTorque
from nrp_core.world.sensors.ground_truth import GroundTruth
from nrp_core.world.sensors.laser import Laser
from nrp_core.world.sensors.navigation import Imu

ModelReader = Callable[..., Model]

BASE = '<link name="base"><inertial/>{}</link>'
ARM = (
    '<link name="base"><inertial/></link><link name="hand"><inertial/></link>'
    '<joint name="wrist" type="revolute"><parent>base</parent><child>hand</child><axis>'
    "<xyz>0 0 1</xyz></axis>{}</joint>"
)
NOISE = '<noise type="gaussian"><mean>0.1</mean><stddev>0.2</stddev></noise>'
SCAN = (
    "<scan><horizontal><samples>90</samples><min_angle>-1</min_angle><max_angle>"
    "1.5</max_angle></horizontal></scan>"
)


def sensors_of(model: ModelReader, body: str) -> tuple[object, ...]:
    return model(BASE.format(body)).links[0].sensors


@pytest.mark.parametrize(("kind", "tag"), [("ray", "ray"), ("gpu_ray", "ray"), ("lidar", "lidar")])
def test_a_laser(model: ModelReader, kind: str, tag: str) -> None:
    body = (
        f'<sensor name="front" type="{kind}"><pose>0 0 0.5 0 0 1</pose><update_rate>'
        f"15</update_rate><{tag}>{SCAN}"
        f"<range><min>0.2</min><max>7</max></range>{NOISE}</{tag}>"
        '<plugin name="p" filename="libgazebo_ros_laser.so"><topicName>laser/scan</topicName>'
        "</plugin></sensor>"
    )
    expected = Laser(
        "front", "/robot/laser/scan", 15.0, 90, -1.0, 1.5, 0.2, 7.0,
        Pose.from_rpy((0.0, 0.0, 0.5), 0.0, 0.0, 1.0), noise=Noise(0.1, 0.2),
    )  # fmt: skip
    assert sensors_of(model, body) == (expected,)


def test_a_laser_that_says_nothing_has_the_defaults_of_sdf(model: ModelReader) -> None:
    (laser,) = sensors_of(model, '<sensor name="a" type="ray"><update_rate>5</update_rate><ray/></sensor>')
    assert laser == Laser("a", "/robot/base/a/scan", 5.0, 640, -pi / 2, pi / 2, 0.0, 10.0)


def read_laser(model: ModelReader, plugin: str = "", scan: str = "") -> Laser:
    tag = f'<sensor name="a" type="gpu_ray"><update_rate>5</update_rate><ray>{scan}</ray>{plugin}</sensor>'
    (laser,) = sensors_of(model, tag)
    assert isinstance(laser, Laser)
    return laser


RAY_PLUGIN = (
    '<plugin name="p" filename="libgazebo_ros_ray_sensor.so"><ros><namespace>/bot</namespace>'
    "<remapping>~/out:=seen</remapping></ros>{}</plugin>"
)
POINT_PLUGIN = '<plugin name="p" filename="libgazebo_ros_{}.so"><topicName>/points</topicName></plugin>'
LAYERS = (
    "<scan><horizontal><samples>90</samples></horizontal><vertical><samples>16</samples>"
    "<min_angle>-0.26</min_angle><max_angle>0.2</max_angle></vertical></scan>"
)


def test_ros_2_remaps_a_laser(model: ModelReader, golden: Golden) -> None:
    scans = read_laser(model, RAY_PLUGIN.format("<output_type>sensor_msgs/LaserScan</output_type>"))
    assert (scans.topic, scans.points_topic) == ("/bot/seen", None)
    ignored = "<topicName>no</topicName><output_type>sensor_msgs/LaserScan</output_type>"
    assert read_laser(model, RAY_PLUGIN.format(ignored)).topic == "/bot/seen"
    points = read_laser(model, RAY_PLUGIN.format(""))  # what the plugin gives where it is not told
    assert (points.topic, points.points_topic) == ("/robot/base/a/scan", "/bot/seen")
    ranger = read_laser(model, RAY_PLUGIN.format("<output_type>sensor_msgs/Range</output_type>"))
    assert (ranger.points_topic, ranger.range_topic) == (None, "/bot/seen")
    old = RAY_PLUGIN.format("<output_type>sensor_msgs/PointCloud</output_type>")
    tag = f'<sensor name="a" type="ray"><update_rate>5</update_rate><ray/>{old}</sensor>'
    read = model(BASE.format(tag))
    assert "sensor_msgs/PointCloud2" in str(read.warnings[0])
    golden(str(read.warnings[0]))


@pytest.mark.parametrize("plugin", ["block_laser", "velodyne_laser", "velodyne_gpu_laser"])
def test_plugins_that_give_points(model: ModelReader, plugin: str) -> None:
    assert read_laser(model, POINT_PLUGIN.format(plugin)).points_topic == "/points"


def test_a_laser_of_several_layers_gives_points_as_in_gazebo_sim(model: ModelReader) -> None:
    laser = read_laser(model, scan=LAYERS)
    assert (laser.samples, laser.layers, laser.elevation_min, laser.elevation_max) == (90, 16, -0.26, 0.2)
    assert (laser.topic, laser.points_topic) == ("/robot/base/a/scan", "/robot/base/a/scan/points")


def test_an_imu_and_a_contact_sensor(model: ModelReader) -> None:
    imu = (
        '<sensor name="imu" type="imu"><update_rate>200</update_rate><topic>feel</topic><imu>'
        "<linear_acceleration>"
        f"<x>{NOISE}</x></linear_acceleration></imu></sensor>"
    )
    bumper = (
        '<sensor name="bump" type="contact"><update_rate>20</update_rate><contact><collision>'
        "base_hull</collision>"
        '</contact><plugin name="b" filename="libgazebo_ros_bumper.so"><bumperTopicName>'
        "/hit</bumperTopicName></plugin>"
        "</sensor>"
    )
    along_x = Noise(axes=(Noise(0.1, 0.2), Noise(), Noise()))
    assert sensors_of(model, imu + bumper) == (
        Imu("imu", "/robot/feel", 200.0, noise=along_x, turn_noise=Noise()),
        ContactSensor("bump", "/hit", 20.0, ("base_hull",)),
    )


@pytest.mark.parametrize(
    ("turning", "accelerated", "noise", "turn_noise"),
    [
        ("xyz", "xyz", Noise(0.1, 0.2), None),
        ("", "xyz", Noise(0.1, 0.2), Noise()),
        ("xyz", "", Noise(), Noise(0.1, 0.2)),
        ("xyz", "xz", Noise(axes=(Noise(0.1, 0.2), Noise(), Noise(0.1, 0.2))), Noise(0.1, 0.2)),
    ],
)
def test_turn_rates_of_an_imu_have_noise_of_their_own(
    model: ModelReader, turning: str, accelerated: str, noise: Noise, turn_noise: Noise | None
) -> None:
    axes = {"angular_velocity": turning, "linear_acceleration": accelerated}
    inner = "".join(
        f"<{name}>{''.join(f'<{axis}>{NOISE}</{axis}>' for axis in given)}</{name}>"
        for name, given in axes.items()
    )
    tag = f'<sensor name="imu" type="imu"><update_rate>200</update_rate><imu>{inner}</imu></sensor>'
    read = model(BASE.format(tag))
    (found,) = (sensor for link in read.links for sensor in link.sensors)
    assert isinstance(found, Imu)
    assert (found.noise, found.turn_noise) == (noise, turn_noise)
    assert not read.warnings


def test_a_depth_camera(model: ModelReader) -> None:
    plugin = (
        '<plugin name="k" filename="libgazebo_ros_openni_kinect.so"><cameraName>kinect</cameraName>'
        "<imageTopicName>rgb/image</imageTopicName><depthImageTopicName>"
        "depth/image</depthImageTopicName></plugin>"
    )
    (camera,) = sensors_of(
        model, f'<sensor name="c" type="depth"><update_rate>30</update_rate><camera/>{plugin}</sensor>'
    )
    assert isinstance(camera, Camera)
    assert (camera.topic, camera.depth_topic, camera.info_topic) == (
        "/robot/kinect/rgb/image",
        "/robot/kinect/depth/image",
        "/robot/kinect/camera_info",
    )


def test_a_force_torque_sensor_belongs_to_the_child_of_its_joint(model: ModelReader) -> None:
    sensor = (
        '<sensor name="ft" type="force_torque"><update_rate>50</update_rate><force_torque>'
        "<frame>parent</frame>"
        "<measure_direction>parent_to_child</measure_direction></force_torque></sensor>"
    )
    links = {link.name: link.sensors for link in model(ARM.format(sensor)).links}
    expected = ForceTorque("ft", "/robot/wrist/ft/forcetorque", 50.0, "wrist", "parent", True)
    assert links == {"base": (), "hand": (expected,)}


def test_a_true_pose(model: ModelReader) -> None:
    plugin = (
        '<plugin name="p3d" filename="libgazebo_ros_p3d.so"><bodyName>hand</bodyName>'
        "<topicName>truth</topicName>"
        "<updateRate>25</updateRate><gaussianNoise>0.01</gaussianNoise><xyzOffset>1 0 0</xyzOffset></plugin>"
    )
    links = {link.name: link.sensors for link in model(ARM.format("") + plugin).links}
    expected = GroundTruth("p3d", "/robot/truth", 25.0, Pose((1.0, 0.0, 0.0)), noise=Noise(0.0, 0.01))
    assert links["hand"] == (expected,)


def test_the_true_pose_of_ros_2_is_remapped(model: ModelReader) -> None:
    plugin = (
        '<plugin name="p3d" filename="libgazebo_ros_p3d.so"><ros><namespace>sim</namespace>'
        "<remapping>odom:=truth</remapping></ros><body_name>hand</body_name><frame_name>map</frame_name>"
        "<update_rate>25</update_rate><gaussian_noise>0.01</gaussian_noise><xyz_offset>1 0 0</xyz_offset>"
        "</plugin>"
    )
    read = model(ARM.format("") + plugin)
    links = {link.name: link.sensors for link in read.links}
    expected = GroundTruth("p3d", "/robot/sim/truth", 25.0, Pose((1.0, 0.0, 0.0)), noise=Noise(0.0, 0.01))
    assert links["hand"] == (expected,)
    assert read.warnings == ()


def test_the_generic_controllers_of_the_neurorobotics_platform(model: ModelReader, golden: Golden) -> None:
    plugin = (
        '<plugin name="c" filename="libgeneric_controller_plugin.so">'
        '<controller joint_name="wrist"><type>{}</type>'
        "<pid>100 1 2</pid></controller></plugin>"
    )
    for kind, topic in (("position", "cmd_pos"), ("velocity", "cmd_vel"), ("effort", "cmd_effort")):
        read = model(ARM.format("") + plugin.format(kind))
        expected = JointController("wrist", kind, f"/robot/wrist/{topic}", Pid(100.0, 1.0, 2.0))  # type: ignore[arg-type]
        assert read.controllers == (expected,)
        assert not read.warnings
    with golden.raises(SceneError, match="'speed'"):
        model(ARM.format("") + plugin.format("speed"))
    with golden.raises(SceneError, match="'wrost'.*'wrist'"):
        model(ARM.format("") + plugin.format("position").replace("wrist", "wrost"))


def test_the_controllers_of_gazebo_sim(model: ModelReader) -> None:
    plugins = "".join(
        f'<plugin name="gz::sim::systems::{system}" filename="x"><joint_name>wrist</joint_name></plugin>'
        for system in ("JointPositionController", "JointController", "ApplyJointForce")
    )
    position, velocity, effort = model(ARM.format("") + plugins).controllers
    start = "/model/robot/joint/wrist"
    assert position == JointController(
        "wrist", "position", f"{start}/0/cmd_pos", Pid(1.0, 0.1, 0.01, 1.0), initial=0.0
    )
    assert (velocity.kind, velocity.topic) == ("velocity", f"{start}/cmd_vel")
    assert (effort.kind, effort.topic) == ("effort", f"{start}/cmd_force")


@pytest.mark.parametrize(
    ("given", "topic", "said"),
    [
        ("<sub_topic>command/tilt</sub_topic>", "/model/robot/command/tilt", []),
        ("<sub_topic>tilt</sub_topic><topic>/servo</topic>", "/servo", []),
        (
            "<sub_topic>command</sub_topic><use_actuator_msg>true</use_actuator_msg>",
            "/model/robot/joint/wrist/cmd_vel",
            ["the joint 'wrist' takes numbers on /model/robot/joint/wrist/cmd_vel"],
        ),
    ],
)
def test_a_controller_of_gazebo_sim_may_name_its_topic(
    model: ModelReader, given: str, topic: str, said: list[str]
) -> None:
    """With both names Gazebo uses <topic>; messages for several actuators have another type."""
    plugin = '<plugin name="gz::sim::systems::JointController" filename="x">{}</plugin>'
    read = model(ARM.format("") + plugin.format(f"<joint_name>wrist</joint_name>{given}"))
    assert [each.topic for each in read.controllers] == [topic]
    assert [each in warning.message for each, warning in zip(said, read.warnings, strict=True)] == [
        True
    ] * len(said)


@pytest.mark.parametrize("kind", ["position", "velocity"])
def test_a_controller_of_gazebo_sim_starts_at_its_declared_target(model: ModelReader, kind: str) -> None:
    system = {"position": "JointPositionController", "velocity": "JointController"}[kind]
    plugin = (
        f'<plugin name="gz::sim::systems::{system}" filename="x"><joint_name>wrist</joint_name>'
        f"<initial_{kind}>0.5</initial_{kind}></plugin>"
    )
    (controller,) = model(ARM.format("") + plugin).controllers
    assert (controller.kind, controller.initial) == (kind, 0.5)


def test_a_planar_move(model: ModelReader) -> None:
    plugin = (
        '<plugin name="m" filename="libgazebo_ros_planar_move.so"><odometryRate>40</odometryRate></plugin>'
    )
    (drive,) = model(BASE.format("") + plugin).drives
    assert drive == PlanarMove("m", "/robot/cmd_vel", inf, 40.0, "/robot/odom")


def test_a_car(model: ModelReader) -> None:
    names = ("front_left", "front_right", "rear_left", "rear_right", "steer_left", "steer_right")
    links = "".join(f'<link name="{name}"><inertial/></link>' for name in names)
    joints = "".join(
        f'<joint name="{n}_joint" type="revolute"><parent>base</parent><child>{n}</child>'
        "<axis><xyz>0 1 0</xyz></axis></joint>"
        for n in names
    )
    wheels = "".join(
        f"<{side}_joint>{end}_{side}_joint</{side}_joint>"
        for side in ("left", "right")
        for end in ("front", "rear")
    )
    plugin = (
        f'<plugin name="gz::sim::systems::AckermannSteering" filename="x">{wheels}<wheel_base>2</wheel_base>'
        "<left_steering_joint>steer_left_joint</left_steering_joint><wheel_radius>0.3</wheel_radius>"
        "<right_steering_joint>steer_right_joint</right_steering_joint><topic>drive</topic></plugin>"
    )
    (drive,) = model(BASE.format("") + links + joints + plugin).drives
    assert isinstance(drive, Ackermann)
    (other,) = model(BASE.format("") + links + joints + plugin.replace("topic>", "sub_topic>")).drives
    assert (drive.command_topic, other.command_topic) == ("/robot/drive", "/model/robot/drive")
    assert drive.left == ("rear_left_joint", "front_left_joint")
    assert drive.steering == ("steer_left_joint", "steer_right_joint")
    assert (drive.command_topic, drive.wheel_base, drive.wheel_diameter) == ("/robot/drive", 2.0, 0.6)


def ros_car(
    tyre: str = "<cylinder><radius>0.3</radius><length>0.1</length></cylinder>", plugin: str = ""
) -> str:
    """Return a car that has the plugin for ROS 2, as SDF."""
    places = {
        "front_left": (2, 0.5),
        "front_right": (2, -0.5),
        "rear_left": (0, 0.6),
        "rear_right": (0, -0.6),
    }
    wheels = "".join(
        f'<link name="{name}"><pose>{x} {y} 0 0 0 0</pose><inertial/>'
        f'<collision name="c"><geometry>{tyre}</geometry></collision></link>'
        f'<joint name="{name}_joint" type="revolute"><parent>base</parent><child>{name}</child>'
        "<axis><xyz>0 1 0</xyz></axis></joint>"
        for name, (x, y) in places.items()
    )
    steering = "".join(
        f'<link name="{side}_knuckle"><inertial/></link><joint name="{side}_steering_joint" type="revolute">'
        f"<parent>base</parent><child>{side}_knuckle</child><axis><xyz>0 0 1</xyz></axis></joint>"
        for side in ("left", "right")
    )
    car = f'<plugin name="car" filename="libgazebo_ros_ackermann_drive.so">{plugin}</plugin>'
    return BASE.format("") + wheels + steering + car


def test_the_car_of_ros_2_has_the_measures_of_its_wheels(model: ModelReader) -> None:
    (drive,) = model(ros_car()).drives
    assert drive == Ackermann(
        "car", "/robot/cmd_vel",
        ("rear_left_joint", "front_left_joint"), ("rear_right_joint", "front_right_joint"),
        ("left_steering_joint", "right_steering_joint"), separation=1.0, wheel_base=2.0, wheel_diameter=0.6,
        max_steer=0.6, max_speed=20.0, steers=True,
    )  # fmt: skip


def test_the_car_of_ros_2_takes_names_and_limits_from_its_tags(model: ModelReader) -> None:
    ros = "<ros><namespace>/lot</namespace><remapping>cmd_vel:=go</remapping></ros>"
    (drive,) = model(
        ros_car(
            plugin=f"{ros}<max_steer>0.4</max_steer><max_speed>3</max_speed><publish_odom>true</publish_odom>"
        )
    ).drives
    assert isinstance(drive, Ackermann)
    assert (drive.command_topic, drive.odometry_topic) == ("/lot/go", "/lot/odom")
    assert (drive.max_steer, drive.max_speed) == (0.4, 3.0)


@pytest.mark.parametrize(
    "car",
    [
        ros_car(plugin="<rear_left_joint>rear_lft_joint</rear_left_joint>"),
        ros_car(tyre="<box><size>1 1 1</size></box>"),
    ],
)
def test_a_car_whose_wheels_are_unclear_is_refused(model: ModelReader, car: str, golden: Golden) -> None:
    with golden.raises(SceneError):
        model(car)


def test_a_rate_below_0_is_refused(model: ModelReader, golden: Golden) -> None:
    with golden.raises(SceneError, match="<update_rate>.*-5"):
        sensors_of(model, '<sensor name="imu" type="imu"><update_rate>-5</update_rate></sensor>')


@pytest.mark.parametrize(
    "file", ["gz-sim-velocity-control-system", "libignition-gazebo6-velocity-control-system.so"]
)
def test_the_velocity_control_of_gz_sim_moves_a_body_as_commanded(model: ModelReader, file: str) -> None:
    plugin = f'<link name="base"/><plugin name="v" filename="{file}">{{}}</plugin>'
    assert model(plugin.format("")).drives == (Flight("v", "/model/robot/cmd_vel"),)
    read = model(plugin.format("<initial_linear>1 0 2</initial_linear><link_name>base</link_name>"))
    assert read.drives == (Flight("v", "/model/robot/cmd_vel", ((1.0, 0.0, 2.0), (0.0, 0.0, 0.0))),)
    assert any("the <link_name> of a VelocityControl has no effect" in str(text) for text in read.warnings)


def test_a_multicopter_of_gz_sim_flies_on_the_topic_of_its_controller(model: ModelReader) -> None:
    read = model(
        '<link name="base"/><plugin name="gz::sim::systems::MulticopterVelocityControl" filename="x">'
        "<robotNamespace>X3</robotNamespace><commandSubTopic>gazebo/command/twist</commandSubTopic></plugin>"
    )
    (drive,) = read.drives
    assert isinstance(drive, Flight)
    assert drive.command_topic == "/X3/gazebo/command/twist"


def test_the_odometry_of_gz_sim_has_the_pose_of_the_model_and_velocities_along_it(
    model: ModelReader,
) -> None:
    read = model(
        '<link name="base"><pose>1 0 0 0 0 0</pose></link>'
        '<plugin name="o" filename="gz-sim-odometry-publisher-system"/>'
    )
    expected = GroundTruth("o", "/model/robot/odometry", 50.0, Pose((-1.0, 0.0, 0.0)), along_link=True)
    assert read.links[0].sensors == (expected,)


def test_odometry_that_a_drive_serves_on_the_same_topic_is_served_once(model: ModelReader) -> None:
    joints = "<left_joint>l</left_joint><right_joint>r</right_joint>"
    drive = f'<plugin name="d" filename="gz-sim-diff-drive-system">{joints}</plugin>'
    odometry = '<plugin name="o" filename="gz-sim-odometry-publisher-system"/>'
    wheels = "".join(
        f'<link name="{n}w"/><joint name="{n}" type="revolute"><parent>base</parent><child>{n}w</child>'
        "<axis><xyz>0 1 0</xyz></axis></joint>"
        for n in "lr"
    )
    for plugins in (drive + odometry, odometry + drive):
        read = model(f'<link name="base"/>{wheels}{plugins}')
        assert read.drives[0].odometry_topic == "/model/robot/odometry"
        assert read.links[0].sensors == ()


@pytest.mark.parametrize("system", ["forcetorque", "imu", "contact", "sensors", "user-commands", "physics"])
def test_systems_that_every_backend_is_are_not_warned_of(model: ModelReader, system: str) -> None:
    read = model(f'<link name="base"><inertial/></link><plugin name="x" filename="gz-sim8-{system}-system"/>')
    assert read.warnings == ()


@pytest.mark.parametrize("system", ["wind-effects", "thermal"])
def test_systems_that_are_not_simulated_are_named_in_a_warning(model: ModelReader, system: str) -> None:
    read = model(f'<link name="base"><inertial/></link><plugin name="x" filename="gz-sim-{system}-system"/>')
    name = "".join(word.capitalize() for word in system.split("-"))
    assert f"the plugin '{name}' is unknown and has no effect" in str(read.warnings[0])


def test_of_a_sensor_that_is_not_simulated_nothing_else_is_reported(model: ModelReader) -> None:
    radio = '<sensor name="radio" type="transceiver"><update_rate>5</update_rate><power>1</power></sensor>'
    said = [(each.code, each.subject) for each in model(BASE.format(radio * 2)).warnings]
    assert sorted(map(str, said)) == ["(Code.NRP262, 'transceiver')", "(Code.NRP266, 'radio')"]
