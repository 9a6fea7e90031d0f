"""Gazebo's plugins as files name them."""

from __future__ import annotations

from nrp_core.world.scene.reading import Reading
from nrp_core.world.scene.xml_tree import Element

# what Gazebo needs to run at all, and every backend does by itself
_INFRASTRUCTURE = (
    "Physics",
    "UserCommands",
    "SceneBroadcaster",
    "Sensors",
    "Contact",
    "Imu",
    "gazebo_ros_api_plugin",
    "gazebo_ros_init",
    "gazebo_ros_factory",
    "gazebo_ros_state",
)


def plugin_name(plugin: Element) -> str:
    """Return what a ``<plugin>`` is known by.

    The class for a system of gz-sim (``DiffDrive``), else the file without its affixes
    (``gazebo_ros_camera`` of ``libgazebo_ros_camera.so``).
    """
    scope, _, system = plugin.attributes.get("name", "").rpartition("::systems::")
    if scope:
        return system
    return plugin.attributes.get("filename", "").removeprefix("lib").removesuffix(".so")


def ros_namespace(plugin: Element) -> str:
    """Return the namespace that a plugin for ROS (1 or 2) puts its topics below; empty for none."""
    namespace = plugin.find("ros", "namespace")
    return namespace.text if namespace else plugin.word("robotNamespace")


def warn_of_plugin(plugin: Element, reading: Reading) -> None:
    """Warn that a plugin does nothing here, unless there is nothing for it to do."""
    name = plugin_name(plugin)
    if name not in _INFRASTRUCTURE:
        reading.notes.warn(plugin, f"the plugin '{name}' is not known: it does nothing")
