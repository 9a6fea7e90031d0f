"""The names of Gazebo's plugins in files."""

from __future__ import annotations

import re
from posixpath import join

from nrp_core.errors import slip_of
from nrp_core.findings import Code
from nrp_core.world.rigid.pose import Vector
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.topics import resolve_name

# plugins that Gazebo needs and every backend replaces
_INFRASTRUCTURE = (
    "Physics",
    "UserCommands",
    "SceneBroadcaster",
    "Sensors",
    "Contact",
    "Imu",
    "ForceTorque",
    "AirPressure",
    "Altimeter",
    "LogicalCamera",
    "Magnetometer",
    "NavSat",
    "gazebo_ros_api_plugin",
    "gazebo_ros_init",
    "gazebo_ros_factory",
    "gazebo_ros_state",
)

ROS_CONTROL = (
    "gazebo_ros_control",
    "gazebo_ros2_control",
    "gz_ros2_control-system",
    "ign_ros2_control-system",
)
"""The plugins that run the controllers of a file, if they name one."""

_SYSTEM_FILE = re.compile(r"(?:gz-sim|ignition-gazebo)\d*-(.+)-system")
_SYSTEM_NAMES = {
    "Forcetorque": "ForceTorque",
    "Navsat": "NavSat",
    "MulticopterControl": "MulticopterVelocityControl",
}


def plugin_name(plugin: Element) -> str:
    """Return the name by which a ``<plugin>`` is registered.

    The class for a system of gz-sim (``DiffDrive`` for ``gz::sim::systems::DiffDrive``, and for the files
    ``gz-sim-diff-drive-system`` and ``libignition-gazebo-diff-drive-system.so``), else the file without its
    affixes (``gazebo_ros_camera`` of ``libgazebo_ros_camera.so``).
    """
    scope, _, system = plugin.attributes.get("name", "").rpartition("::systems::")
    return system if scope else name_of_file(plugin)


def name_of_file(plugin: Element) -> str:
    """Return the name that a plugin has by its file: the class for a file of gz-sim, else the bare file."""
    file = plugin.attributes.get("filename", "").removeprefix("lib").removesuffix(".so")
    words = _SYSTEM_FILE.fullmatch(file)
    if words is None:
        return file
    name = "".join(word.capitalize() for word in words[1].split("-"))
    return _SYSTEM_NAMES.get(name, name)


def wrong_file(plugin: Element) -> str:
    """Return that the file of a system of gz-sim is misspelt; here its class is used. Empty if it is not."""
    scope, _, system = plugin.attributes.get("name", "").rpartition("::systems::")
    file = plugin.attributes.get("filename", "").strip()
    if not scope or not file or name_of_file(plugin) == system:
        return ""
    dashed = re.sub(r"(?<!^)(?=[A-Z])", "-", system).lower()
    files = [f"{simulator}-{dashed}-system" for simulator in ("gz-sim", "ignition-gazebo")]
    slip = slip_of(file.removeprefix("lib").removesuffix(".so"), files)
    return f"Gazebo has no file '{file}' for the plugin '{system}'{slip}" if slip else ""


def ros_namespace(plugin: Element) -> str:
    """Return the namespace of the topics of a plugin for ROS (1 or 2); empty for none."""
    namespace = plugin.find("ros", "namespace")
    return namespace.text if namespace else plugin.word("robotNamespace")


def ros_topic(plugin: Element, name: str, reading: Reading) -> str:
    """Return the topic of a plugin for ROS after the ``<remapping>`` rules of ROS 2."""
    return resolve_name(join(ros_namespace(plugin), remapped(plugin, name)), reading.robot)


def remapped(plugin: Element, name: str) -> str:
    """Return a name after the ``<remapping>`` rules of ROS 2, which give it as it is or in full."""
    ros = plugin.find("ros")
    rules = [rule.text.partition(":=") for rule in ros.all("remapping")] if ros else []
    named = (name, join("/", ros_namespace(plugin), name))
    return next((to.strip() for this, _, to in rules if this.strip() in named), name)


def vector_in(plugin: Element, tag: str) -> Vector:
    """Return the three numbers of a parameter, 0 if it is missing."""
    found = plugin.find(tag)
    x, y, z = found.numbers(3) if found else (0.0, 0.0, 0.0)
    return x, y, z


def warn_of_plugin(plugin: Element, reading: Reading) -> None:
    """Warn that a plugin has no effect here, unless it is not needed."""
    name = plugin_name(plugin)
    if name not in _INFRASTRUCTURE:
        message = f"the plugin '{name}' is unknown and has no effect"
        reading.notes.warn(plugin, Code.NRP261, message, subject=name)
