"""The frames of sensors' messages, as files name them.

A name is that of a link if the sensor measures in the frame of that link, else of a frame of its own. A link
that is elsewhere cannot be the frame: whoever transforms its measurements would misplace them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import dist, hypot

from nrp_core.world.rigid.pose import Pose, rotation_vector
from nrp_core.world.scene.checks import rigid_groups
from nrp_core.world.scene.model import Joint, Link
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sensing import MountedSensor

_OF_SENSORS = ("gz_frame_id", "ignition_frame_id", "frame_id")
_OF_PLUGINS = ("frameName", "frame_name")
_NEAR_M, _NEAR_RAD = 1e-3, 2e-3  # files round right angles to 1.57


def frame_named(sensor: Element, reading: Reading) -> str:
    """Return the frame that a ``<sensor>`` or its plugin names, without the name of its robot; else ""."""
    names = [sensor.section("camera").word("optical_frame_id"), *map(sensor.word, _OF_SENSORS)]
    names += [plugin.word(tag) for plugin in sensor.all("plugin") for tag in _OF_PLUGINS]
    name = next(filter(None, names), "").strip("/")
    return name.removeprefix(f"{reading.robot}/")


@dataclass(frozen=True, slots=True)
class Misplaced:
    """A sensor whose frame is named like one that is elsewhere.

    Args:
        link: the link that holds it.
        sensor: its name.
        named: the frame that it names.
        why: how the two differ.
    """

    link: str
    sensor: str
    named: str
    why: str

    @property
    def message(self) -> str:
        """The message of a finding."""
        return f"the sensor '{self.sensor}' names the frame '{self.named}', {self.why}: it has its own frame"


def with_frames(links: Sequence[Link], joints: Iterable[Joint]) -> tuple[list[Link], list[Misplaced]]:
    """Return links whose sensors are in the frames that they name, as far as these are where they measure.

    Args:
        links: the links of a model.
        joints: its joints.
    """
    fixed = [(joint.parent, joint.child) for joint in joints if joint.kind == "fixed"]
    rigid = rigid_groups([link.name for link in links], fixed)
    frames = {link.name: (link.name, link.pose) for link in links}
    misplaced: list[Misplaced] = []

    def settled(link: Link) -> Iterator[MountedSensor]:
        for sensor in link.sensors:
            if not sensor.frame_name or sensor.offset is None:
                yield sensor
                continue
            place = link.pose @ sensor.offset
            holder, there = frames.setdefault(sensor.frame_name, (link.name, place))
            why = _difference(place, there) if holder in rigid[link.name] else "which moves against it"
            if why:
                misplaced.append(Misplaced(link.name, sensor.name, sensor.frame_name, why))
            yield replace(sensor, frame_name="") if why else sensor

    return [replace(link, sensors=tuple(settled(link))) for link in links], misplaced


def _difference(place: Pose, other: Pose) -> str:
    """Return how another pose differs from that of a sensor's frame, empty if it does not."""
    away = dist(place.position, other.position)
    turned = hypot(*rotation_vector((place.inverse() @ other).orientation))
    parts = [f"{away:.3g} m away"] if away > _NEAR_M else []
    parts += [f"turned by {turned:.3g} rad"] if turned > _NEAR_RAD else []
    return f"which is {' and '.join(parts)}" if parts else ""
