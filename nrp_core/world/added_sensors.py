"""Sensors that an experiment mounts on a robot: a ``<sensor>`` of SDF, written in YAML."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import Any

from nrp_core.errors import SceneError, did_you_mean
from nrp_core.findings import Code, Finding
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.bodies import free_name
from nrp_core.world.scene.model import Model
from nrp_core.world.scene.reading.context import Notes, Reading
from nrp_core.world.scene.reading.frame_names import with_frames
from nrp_core.world.scene.reading.resources import Resources
from nrp_core.world.scene.reading.sensors import SENSORS, Mount, joint_sensors, link_sensors, with_sensors
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sdf.vocabulary import check_vocabulary

_WITH_LENSES = ("depth", "dvs", "retina", "rgbd", "segmentation")
"""Sensors that need a ``<camera>``, besides cameras; without one it has the default optics."""


class _SensorError(SceneError):
    """An error in a sensor that is not in a file of its own."""

    def __init__(self, message: str, **_where: Any) -> None:
        super().__init__(message)


@dataclass(frozen=True, slots=True)
class AddedSensor:
    """A sensor on a link, or in a joint.

    Args:
        type: the type of the ``<sensor>``: ``camera``, ``lidar``, ``imu``, ``contact`` and so on.
        link: the link that holds it, or the joint that it measures.
        name: unique on its link; by default its type.
        pose: in the frame of its link.
        rate_hz: messages per second.
        settings: further elements of the ``<sensor>``; nested elements are nested mappings.
    """

    type: str
    link: str
    name: str = ""
    pose: Pose = Pose()
    rate_hz: float = 30.0
    settings: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))


def with_added_sensors(model: Model, sensors: Iterable[AddedSensor]) -> Model:
    """Return a robot with further sensors.

    Raises:
        SceneError: a link does not exist, a type or an element of a sensor is unknown, or a value is invalid.
    """
    links, notes = list(model.links), Notes()
    for sensor in sensors:
        holders = {link.name: link for link in links}
        joints = {joint.name: joint.child for joint in model.joints}
        if sensor.link not in holders.keys() | joints.keys():
            hint = did_you_mean(sensor.link, [*holders, *joints])
            what = f"no link or joint '{sensor.link}' for an added sensor"
            raise SceneError(f"'{model.name}' has {what}{hint}")
        taken = {each.name for link in links if link.name == sensor.link for each in link.sensors}
        if sensor.name in taken:
            raise SceneError(f"'{model.name}/{sensor.link}' has a sensor of the name '{sensor.name}' already")
        name = sensor.name or free_name(sensor.type, taken)
        element = _element_of(replace(sensor, name=name))
        if name not in (sensor.name, sensor.type):
            held = f"'{model.name}/{sensor.link}' has a sensor '{sensor.type}' already"
            message = f"{held}: a further one without a name is called '{name}'"
            notes.warn(element, Code.NRP266, message, subject=name)
        holder = sensor.link if sensor.link in holders else joints[sensor.link]
        mount = Mount(sensor.link, partial(_place, sensor.pose))
        reading = Reading(Resources(()), notes, robot=model.name)
        read = link_sensors if sensor.link in holders else joint_sensors
        found = list(read([element], mount, reading))
        if not found:
            where = "a joint" if sensor.link in holders else "a link"
            raise SceneError(f"a sensor of type '{sensor.type}' is on {where}, which '{sensor.link}' is not")
        links = with_sensors(links, holder, *found)
    links, misplaced = with_frames(links, model.joints)
    if misplaced:
        raise SceneError(f"'{model.name}/{misplaced[0].link}': {misplaced[0].message}")
    result = replace(model, links=tuple(links), warnings=(*model.warnings, *_unplaced(notes)))
    result.check()
    return result


def _place(pose: Pose, part: Element) -> Pose:
    """Return the pose of the sensor; its parts are where it is."""
    return pose if part.tag == "sensor" else Pose()


def _unplaced(notes: Notes) -> Iterator[Finding]:
    """Yield the warnings, which are about no file."""
    return (replace(each, path=None, line=None) for each in notes.findings)


def _element_of(sensor: AddedSensor) -> Element:
    """Return the ``<sensor>``, of which every element must exist."""
    if sensor.type not in SENSORS.names():
        types = [name for name in SENSORS.names() if not name.startswith("plugin.")]
        raise SceneError(f"'{sensor.type}' is not a type of sensors{did_you_mean(sensor.type, types)}")
    settings = {"update_rate": f"{sensor.rate_hz:.17g}", **sensor.settings}
    attributes = {"name": sensor.name, "type": sensor.type}
    (element,) = _elements("sensor", settings)
    element.attributes |= attributes
    if "camera" in sensor.type or sensor.type in _WITH_LENSES:
        element.children += [] if element.find("camera") else _elements("camera", {})
    notes = Notes()
    check_vocabulary(element, notes)
    if notes.findings:
        unknown = notes.findings[0].message.replace(": ignored", "")
        raise SceneError(f"the added sensor '{sensor.name}': {unknown}")
    return element


def _elements(tag: str, value: Any) -> list[Element]:
    """Return the elements of a value in YAML: one, or one for each mapping in a list."""
    if isinstance(value, list | tuple) and all(isinstance(each, Mapping) for each in value) and value:
        return list(chain.from_iterable(_elements(tag, each) for each in value))
    element = Element(tag, {}, Path(), 0, kind=_SensorError)
    if isinstance(value, Mapping):
        for name, inner in value.items():
            if name.startswith("@"):  # an attribute
                element.attributes[name[1:]] = _text(inner)
            else:
                element.children += _elements(name, inner)
    else:
        element.text = element.raw_text = _text(value)
    return [element]


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return " ".join(map(_text, value))
    return str(value)
