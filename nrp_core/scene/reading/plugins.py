"""Plugins of files: their names, parameters and labels, and the drives and controllers that they describe."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from math import isfinite
from posixpath import join
from typing import Any, Final, NamedTuple, Protocol, TypeVar

from nrp_core.errors import BackendError, did_you_mean, hint_if_close
from nrp_core.findings import Code
from nrp_core.messages.base import resolve_name
from nrp_core.registry import Registry
from nrp_core.scene.devices import (
    GroupController,
    JointController,
    MountedDrive,
    PairController,
    Rename,
    TrajectoryController,
)
from nrp_core.scene.model import Joint, Link
from nrp_core.scene.reading.context import Element, Notes, Reading
from nrp_core.scene.rigid import Vector

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
    slip = hint_if_close(file.removeprefix("lib").removesuffix(".so"), files)
    return f"Gazebo has no file '{file}' for the plugin '{system}'{slip}" if slip else ""


def ros_namespace(plugin: Element) -> str:
    """Return the namespace of the topics of a plugin for ROS (1 or 2); empty for none."""
    namespace = plugin.find("ros", "namespace")
    return namespace.text if namespace else plugin.word("robotNamespace")


def ros_topic(plugin: Element, name: str, reading: Reading) -> str:
    """Return the topic of a plugin for ROS after the ``<remapping>`` rules of ROS 2."""
    return resolve_name(join(ros_namespace(plugin), remapped_topic(plugin, name)), reading.robot)


def remapped_topic(plugin: Element, name: str) -> str:
    """Return a name after the ``<remapping>`` rules of ROS 2, which have it as written or in full."""
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
        if (distribution := DRIVES.distribution_with(name)) and name not in DRIVES.names():
            message = f"the plugin '{name}' has no effect: it is in {distribution}, which is not installed"
        reading.notes.warn(plugin, Code.NRP260, message, subject=name)


_ALIKE: Final = 0.8
"""How alike a tag and a parameter are, from 0 to 1, if one is a misspelling of the other."""
_SAME: Final = 0.88
"""The same where the parameter itself is set too: two letters exchanged or one changed."""
_FLAG: Final = re.compile(
    r"(?!.*(?i:frame|joint|link|name|rate|topic)$)(always|broadcast|enable|initial|is|legacy|publish|use)"
    r"(_|(?=[A-Z]))\w+"
)
_NUMBER: Final = re.compile(r"\w*([a-z]Rate|_rate|Noise|_noise|Frequency|_frequency)")
_INERT: Final = re.compile(
    r"\w*([tT]opic|[nN]amespace|[sS]ervice|[fF]rame)\w*"
    r"|(\w*(_|[a-z](?=[A-Z])))?([nN]ames?|[iI]d|[lL]ink|[jJ]oint|[rR]ate|[fF]requency|HZ|[tT]f|TF)"
    r"|(always|publish|broadcast|enable|debug|verbose|is_?|legacy)(?![a-z])\w*"
    r"|robotBase|odom\w*|ros([A-Z]\w*)?|qos|argument|parameters?|plugin|actuator_number|autoDistortion"
    r"|borderCrop|dimensions|hackBaseline|pointCloudCutoff\w*|reduceNormals|maxEffort|hasPID|sensitiveness|torque"
)
"""Parameters of Gazebo's plugins that name something, or say what and how often they publish; and some that
files repeat without need, as for outputs that they do not use."""
_NEGLIGIBLE: Final = 1e-6
_TRUTH: Final = ("true", "false")
_FALSE_FRIENDS: Final = ("yes", "no", "on", "off")
_OTHERS: Final = frozenset(
    {
        "body_name", "child_frame_id", "depthImageInfoTopicName", "frameId", "frame_id", "frame_name",
        "max_range", "min_range", "odometryFrame", "publishOdomTF",
        "publish_odom_tf", "publish_tf", "rateGaussianNoise", "robot_namespace", "rpy_offset", "updateRateHZ",
        "velocityGain", "velocity_topic_name", "xyz_offset",
    }
)  # fmt: skip
"""Parameters of Gazebo's plugins that have no effect here and resemble one that has."""


def check_parameters(plugin: Element, notes: Notes) -> None:
    """Warn of parameters of a plugin, which has been read, that have no effect by mistake."""
    if notes.has(Code.NRP260, plugin_name(plugin)):  # no parameter of it has an effect
        return
    name = f"the plugin '{plugin_name(plugin)}'"
    problems = list(_problems(plugin, name))
    for child, problem in problems:
        notes.warn(child, Code.NRP383, problem, subject=child.tag)
    reported = [child for child, _ in problems]
    unused = [child for child in _unused(plugin) if not any(child is one for one in reported)]
    if unused:
        tags = [f"<{tag}>" for tag in dict.fromkeys(child.tag for child in unused)]
        message = f"{name} acts here without {' and '.join(filter(None, (', '.join(tags[:-1]), tags[-1])))}"
        notes.warn(unused[0], Code.NRP383, message, subject=plugin_name(plugin))


def _unused(holder: Element) -> Iterator[Element]:
    """Yield the parameters that no reader has read, but that have an effect in Gazebo."""
    for child in holder.children:
        if child.tag in holder.asked:
            yield from _unused(child)
        elif holder.asked and not _INERT.fullmatch(child.tag) and _sets_something(child, holder):
            yield child


def _sets_something(child: Element, holder: Element) -> bool:
    """Return whether a parameter is more than 0 or false, or the lower limit that is used without it."""
    if not child.text or child.text.lower() == _TRUTH[1]:
        return bool(child.children)
    if not _is_number(child.text, several=True):
        return True
    upper = child.tag.replace("min", "max")
    if upper in holder.asked and (limit := holder.word(upper)) and _is_number(limit, several=False):
        return [-float(limit)] != [float(word) for word in child.text.split()]
    return any(abs(float(word)) > _NEGLIGIBLE for word in child.text.split())


def _problems(holder: Element, plugin: str) -> Iterator[tuple[Element, str]]:
    """Yield the parameters in an element with a problem, and the problem."""
    first: dict[str, Element] = {}
    for child in holder.children:
        earlier = first.setdefault(child.tag, child)
        problem = (
            _misspelt(child, holder, plugin) or _no_value(child) or _repeated(child, earlier, holder, plugin)
        )
        if problem:
            yield child, problem
        elif child.tag in holder.asked or child.text:
            for inner in child.children:
                if inner.tag in holder.asked and inner.tag not in child.asked:
                    yield inner, f"<{inner.tag}> in <{child.tag}> is ignored; in {plugin} it stands beside it"
        if child.asked:
            yield from _problems(child, plugin)


def _misspelt(child: Element, holder: Element, plugin: str) -> str:
    if child.tag in holder.asked or child.tag in _OTHERS:
        return ""
    free = holder.asked.keys() - {each.tag for each in holder.children}
    near = [tag for tag in sorted(free) if sorted(tag) == sorted(child.tag)]  # letters exchanged
    near = near or get_close_matches(child.tag, free, n=1, cutoff=_ALIKE)
    near = near or get_close_matches(child.tag, holder.asked, n=1, cutoff=_SAME)
    return f"<{child.tag}> is not a parameter of {plugin}: ignored; did you mean <{near[0]}>?" if near else ""


def _no_value(child: Element) -> str:
    """Report flags and numbers with a misspelt value; no reader checks most of Gazebo's."""
    text = child.text.lower()
    if child.children or not text:
        return ""
    if _NUMBER.fullmatch(child.tag) and not _is_number(text, several="oise" in child.tag):
        return f"<{child.tag}> is '{child.text}', which is not a number: ignored"
    if text in _TRUTH or not _FLAG.fullmatch(child.tag):
        return ""
    slip = text in _FALSE_FRIENDS or get_close_matches(text, _TRUTH, n=1, cutoff=0.75)
    return without_truth_value(child) if slip else ""


def without_truth_value(flag: Element) -> str:
    """Return the message about a flag with another value."""
    return f"<{flag.tag}> is '{flag.text}', which is neither true nor false: ignored"


def _is_number(text: str, *, several: bool) -> bool:
    """Return whether a text is a number, or several numbers where several are permitted."""
    words = text.split()
    try:
        return all(isfinite(float(word)) for word in words) and (several or len(words) == 1)
    except ValueError:
        return False


def _repeated(child: Element, earlier: Element, holder: Element, plugin: str) -> str:
    """Report parameters that the reader takes once and that are given again with another value."""
    if earlier is child or holder.asked.get(child.tag, True) or child.text == earlier.text:
        return ""
    return f"a second <{child.tag}> in {plugin} is ignored: the one of line {earlier.line} is used"


Plugin = TypeVar("Plugin")
Part = TypeVar("Part", Link, Joint)


@dataclass(frozen=True, slots=True)
class ModelParts:
    """The links and joints of the model with a ``<plugin>``."""

    links: Sequence[Link]
    joints: Sequence[Joint]

    def link(self, named: Element) -> Link:
        """Return the link that an element names."""
        return part_named(named, named.text, self.links, "link")

    def joint(self, named: Element, name: str | None = None) -> Joint:
        """Return the joint that an element names, by its text or else by a name."""
        return part_named(named, named.text if name is None else name, self.joints, "joint")


def find_registered(registry: Registry[Plugin], name: str, element: Element) -> Plugin | None:
    """Return the plugin with a name, imported at its first use, or None.

    Raises:
        SceneError: it does not import, or two distributions provide it.
    """
    if name not in registry.names():
        return None
    try:
        found: Plugin = registry.load(name)
    except BackendError as error:
        raise element.error(str(error)) from error
    return found


def part_named(element: Element, name: str, parts: Sequence[Part], kind: str) -> Part:
    """Return the link or joint with a name; an error at the element if the model does not have it."""
    for part in parts:
        if part.name == name:
            return part
    hint = did_you_mean(name, [part.name for part in parts])
    raise element.error(f"the model has no {kind} '{name}'{hint}")


class Actuators(NamedTuple):
    """The drives and controllers that a ``<plugin>`` of a model declares."""

    drives: tuple[MountedDrive, ...] = ()
    controllers: tuple[JointController, ...] = ()
    trajectory_controllers: tuple[TrajectoryController, ...] = ()
    pair_controllers: tuple[PairController, ...] = ()
    group_controllers: tuple[GroupController, ...] = ()

    def with_others(self, others: Actuators) -> Actuators:
        """Return these and others; equal controllers of a joint are merged into the first one."""
        both: list[Any] = [(*mine, *added) for mine, added in zip(self, others, strict=True)]
        joined = Actuators(*both)
        return joined._replace(controllers=_once(joined.controllers))

    def renamed(self, named: Rename) -> Actuators:
        """Return the same actuators for a model whose parts are renamed."""
        renamed: list[Any] = [tuple(each.renamed(named) for each in alike) for alike in self]
        return Actuators(*renamed)


def _once(controllers: Sequence[JointController]) -> tuple[JointController, ...]:
    """Return controllers without duplicates, which have the same joint, kind and topic."""
    found: dict[tuple[str, str, str], JointController] = {}
    for each in controllers:
        first = found.setdefault((each.joint, each.kind, each.topic), each)
        if first.initial is None and each.initial is not None:
            found[each.joint, each.kind, each.topic] = replace(first, initial=each.initial)
    return tuple(found.values())


class DriveReader(Protocol):
    """The class of a drive for readers, a :class:`nrp_core.world.drives.drive.Drive`."""

    of_world: bool

    def read_plugin(self, plugin: Element, model: ModelParts, reading: Reading) -> MountedDrive:
        """Read a ``<plugin>`` of a model."""


ControllerReader = Callable[[Element, ModelParts, Reading], Actuators | None]
"""Reads a ``<plugin>`` of a model; None if the plugin does nothing."""

DRIVES: Registry[DriveReader] = Registry("nrp_core.drives", "drive")
"""Drives by the names of the plugins that they read."""
CONTROLLERS: Registry[ControllerReader] = Registry("nrp_core.controllers", "reader of controllers")
"""Readers of controllers by the names of plugins."""


def read_actuators(plugin: Element, model: ModelParts, reading: Reading) -> Actuators | None:
    """Return the drives and controllers that a ``<plugin>`` declares; None if it declares neither."""
    drive = find_registered(DRIVES, plugin_name(plugin), plugin)
    if drive is not None:
        return Actuators((drive.read_plugin(plugin, model, reading),))
    controllers = find_registered(CONTROLLERS, plugin_name(plugin), plugin)
    return None if controllers is None else controllers(plugin, model, reading)


def read_world_drives(plugins: Iterable[Element], reading: Reading) -> tuple[MountedDrive, ...]:
    """Return the drives that the plugins of a ``<world>`` declare; others cause a warning."""
    drives = []
    for plugin in plugins:
        drive = find_registered(DRIVES, plugin_name(plugin), plugin)
        if drive is not None and drive.of_world:
            drives.append(drive.read_plugin(plugin, ModelParts((), ()), reading))
            check_parameters(plugin, reading.notes)
        else:
            warn_of_plugin(plugin, reading)
    return tuple(drives)


LABEL = "Label"
"""The plugin, of a visual or of a whole model."""
_HIGHEST = 255
"""The labels of an image have 8 bits."""


def label_in(plugin: Element) -> int:
    """Return the label that a plugin gives.

    Raises:
        SceneError: it is not a whole number from 0 to 255.
    """
    given = plugin.require("label")
    (label,) = given.numbers(1)
    if label != int(label) or not 0 <= label <= _HIGHEST:
        raise given.error(f"a <label> is a whole number from 0 to {_HIGHEST}, not {given.text}")
    return int(label)


def label_of(visual: Element) -> int:
    """Return the label of a ``<visual>``, 0 for none."""
    plugins = [each for each in visual.all("plugin") if plugin_name(each) == LABEL]
    return label_in(plugins[0]) if plugins else 0


def with_label(links: Iterable[Link], label: int) -> list[Link]:
    """Return links, with a label added to visuals without one."""
    return [
        replace(
            link,
            visuals=tuple(replace(each, label=each.label or label) for each in link.visuals),
        )
        for link in links
    ]
