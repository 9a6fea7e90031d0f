"""Sensors of SDF beside cameras: lasers, inertial sensors, contacts, forces, true poses."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from math import pi

from nrp_core.errors import did_you_mean
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.model import Joint, Link
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.plugins import plugin_name, ros_namespace, vector_in, warn_of_plugin
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sensing import ContactSensor, ForceTorque, GroundTruth, Imu, Laser, Noise, Sensor
from nrp_core.world.scene.sensor_parts import noise_of, plugin_topic, rate_of, topic_of
from nrp_core.world.topics import resolve_name

Place = Callable[[Element], Pose]

_SCANS, _POINTS = "sensor_msgs/LaserScan", "sensor_msgs/PointCloud2"
_LASER_OUTPUTS = {
    "gazebo_ros_laser": _SCANS,
    "gazebo_ros_gpu_laser": _SCANS,
    "gazebo_ros_block_laser": _POINTS,
    "gazebo_ros_velodyne_laser": _POINTS,
    "gazebo_ros_velodyne_gpu_laser": _POINTS,
    "gazebo_ros_ray_sensor": _POINTS,  # unless it says otherwise
}
_IMU_TOPICS = {"gazebo_ros_imu_sensor": "topicName"}
_CONTACT_TOPICS = {"gazebo_ros_bumper": "bumperTopicName"}
_FORCE_TOPICS = {"gazebo_ros_ft_sensor": "topicName"}


def read_laser(sensor: Element, link: str, reading: Reading, place: Place) -> Laser:
    """Read a ``<ray>`` or ``<lidar>`` of one or several layers."""
    laser = sensor.section("lidar" if sensor.find("lidar") else "ray")
    horizontal = laser.section("scan").section("horizontal")
    reach = laser.section("range")
    vertical = laser.section("scan").section("vertical")
    layers = _count(vertical, 1)
    low, high = reach.number("min", 0.0), reach.number("max", 10.0)
    if not 0 <= low < high:
        raise reach.error(f"a laser's <min> range ({low:g} m) must be below its <max> ({high:g} m)")
    scans, points = _laser_topics(sensor, link, layers, reading)
    return Laser(
        sensor.attribute("name"),
        scans,
        rate_of(sensor, reading),
        _count(horizontal, 640),
        horizontal.number("min_angle", -pi / 2),
        horizontal.number("max_angle", pi / 2),
        low,
        high,
        place(sensor),
        layers,
        vertical.number("min_angle", 0.0) if layers > 1 else 0.0,
        vertical.number("max_angle", 0.0) if layers > 1 else 0.0,
        points,
        noise=noise_of(laser, reading),
    )


def _count(angles: Element, default: int) -> int:
    """Return how many rays there are from one angle to the other."""
    return max(1, round(angles.positive("samples", default) * angles.positive("resolution", 1.0)))


def _laser_topics(sensor: Element, link: str, layers: int, reading: Reading) -> tuple[str, str | None]:
    """Return the topics of scans and points: those that ROS plugins name, else those of gz-sim."""
    scans = sensor.word("topic", reading.topic_of(link, f"{sensor.attribute('name')}/scan"))
    points = f"{scans}/points" if layers > 1 else None
    for plugin in sensor.all("plugin"):
        usual = _LASER_OUTPUTS.get(plugin_name(plugin))
        output = plugin.word("output_type", usual or "")
        if usual is None:
            warn_of_plugin(plugin, reading)
        elif output == _SCANS:
            scans = plugin_topic(plugin, "topicName", scans)
        else:
            if output != _POINTS:
                reading.notes.warn(plugin, f"points are served as {_POINTS}, not as {output}")
            points = plugin_topic(plugin, "topicName", points or f"{scans}/points")
    return resolve_name(scans, reading.robot), resolve_name(points, reading.robot) if points else None


def read_imu(sensor: Element, link: str, reading: Reading, place: Place) -> Imu:
    """Read an inertial sensor; its noise is that of its acceleration along x."""
    name = sensor.attribute("name")
    noise = noise_of(sensor.section("imu").section("linear_acceleration").section("x"), reading)
    for plugin in sensor.all("plugin") if not noise else ():
        noise = Noise(0.0, plugin.number("gaussianNoise", 0.0))
    topic = topic_of(sensor, reading.topic_of(link, f"{name}/imu"), _IMU_TOPICS, reading)
    return Imu(name, topic, rate_of(sensor, reading), place(sensor), noise=noise)


def read_contact(sensor: Element, link: str, reading: Reading, place: Place) -> ContactSensor:
    """Read a contact sensor."""
    name, contact = sensor.attribute("name"), sensor.section("contact")
    usual = contact.word("topic") or reading.topic_of(link, f"{name}/contact")
    topic = topic_of(sensor, usual, _CONTACT_TOPICS, reading)
    collisions = tuple(each.text.rpartition("::")[2] for each in contact.all("collision"))
    return ContactSensor(name, topic, rate_of(sensor, reading), collisions, place(sensor))


def read_force_torque(sensor: Element, joint: str, reading: Reading) -> ForceTorque:
    """Read the force-torque sensor of a ``<joint>``."""
    name, section = sensor.attribute("name"), sensor.section("force_torque")
    frame = section.word("frame", "child")
    if frame not in ("child", "parent", "sensor"):
        raise section.error(f"a <frame> is child, parent or sensor, not '{frame}'")
    topic = topic_of(sensor, reading.topic_of(joint, f"{name}/forcetorque"), _FORCE_TOPICS, reading)
    onto_child = section.word("measure_direction", "child_to_parent") == "parent_to_child"
    return ForceTorque(name, topic, rate_of(sensor, reading), joint, frame, onto_child)


def read_sensor_plugin(plugin: Element, links: list[Link], joints: list[Joint], reading: Reading) -> bool:
    """Add the sensor that a ``<plugin>`` of a model stands for to its link; False if it is none."""
    name = plugin_name(plugin)
    if name == "OdometryPublisher":
        _give(links, links[0].name, _odometry(plugin, links[0], reading))
        return True
    if name not in ("gazebo_ros_p3d", "gazebo_ros_imu", "gazebo_ros_ft_sensor"):
        return False
    topic = resolve_name(
        f"{ros_namespace(plugin)}/{plugin.require('topicName').text}".lstrip("/"), reading.robot
    )
    if plugin.require("topicName").text.startswith("/"):
        topic = plugin.require("topicName").text
    called = plugin.attributes.get("name") or name
    rate_hz = plugin.number("updateRate", 0.0) or 100.0
    noise = Noise(0.0, plugin.number("gaussianNoise", 0.0))
    if name == "gazebo_ros_ft_sensor":
        joint = _named(plugin.require("jointName"), [each.name for each in joints], "joint")
        child = next(each.child for each in joints if each.name == joint)
        _give(links, child, ForceTorque(called, topic, rate_hz, joint, noise=noise))
        return True
    link = _named(plugin.require("bodyName"), [each.name for each in links], "link")
    offset = Pose.from_rpy(vector_in(plugin, "xyzOffset"), *vector_in(plugin, "rpyOffset"))
    sensor: Sensor = Imu(called, topic, rate_hz, offset, noise=noise)
    if name == "gazebo_ros_p3d":
        frame = plugin.word("frameName", "world").strip("/")
        reference = "world" if frame in ("map", "world", "odom") else frame
        if reference != "world":
            reading.notes.warn(plugin, f"the true pose is told in the world, not in '{frame}'")
        sensor = GroundTruth(called, topic, rate_hz, offset, noise=noise)
    _give(links, link, sensor)
    return True


def _odometry(plugin: Element, link: Link, reading: Reading) -> GroundTruth:
    """Read what tells where a model is in gz-sim."""
    topic = resolve_name(plugin.word("odom_topic", f"/model/{reading.robot}/odometry"), reading.robot)
    rate_hz = plugin.positive("odom_publish_frequency", 50.0)
    name = plugin.attributes.get("name") or "odometry"
    return GroundTruth(name, topic, rate_hz, link.pose.inverse(), along_link=True)


def joint_sensors(joint: Element, links: list[Link], reading: Reading) -> None:
    """Add the sensors of a ``<joint>`` to its child link."""
    for sensor in joint.all("sensor"):
        if sensor.attribute("type") == "force_torque":
            child = joint.require("child").text
            _give(links, child, read_force_torque(sensor, joint.attribute("name"), reading))
        else:
            reading.notes.warn(sensor, f"sensors of type '{sensor.attribute('type')}' are not simulated")


def _give(links: list[Link], name: str, sensor: Sensor) -> None:
    for index, link in enumerate(links):
        if link.name == name:
            links[index] = replace(link, sensors=(*link.sensors, sensor))


def _named(element: Element, names: list[str], what: str) -> str:
    if element.text not in names:
        raise element.error(f"the model has no {what} '{element.text}'{did_you_mean(element.text, names)}")
    return element.text


def renamed(sensors: tuple[Sensor, ...], named: Callable[[str], str]) -> Iterator[Sensor]:
    """Yield the sensors of a model whose parts have other names."""
    for sensor in sensors:
        yield replace(sensor, joint=named(sensor.joint)) if isinstance(sensor, ForceTorque) else sensor
