"""Models and lights in a file, written in place or by ``<include>``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count

from nrp_core.findings import Code
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.reading.context import Reading
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sdf.frames import Frames, read_pose
from nrp_core.world.scene.sdf.source import Source


@dataclass(frozen=True, slots=True)
class Placed:
    """A ``<model>`` or ``<light>`` and its use.

    Args:
        element: the model or light.
        source: the file that contains it.
        user: the element that places it: itself or an ``<include>``.
        merged: whether its parts become parts of the model around it.
        other_name: its new name if its own name is taken.
    """

    element: Element
    source: Source
    user: Element
    merged: bool = False
    other_name: str = ""

    @property
    def name(self) -> str:
        """Its name; an ``<include>`` may give it another one than its file."""
        if self.other_name:
            return self.other_name
        included = self.user is not self.element
        return (self.user.word("name") if included else "") or self.element.attribute("name")

    @property
    def static(self) -> bool:
        """Whether it never moves."""
        return self.user.flag("static", self.element.flag("static", False))

    @property
    def plugins(self) -> list[Element]:
        """Its plugins, including those of the ``<include>``."""
        return list(dict.fromkeys([*self.element.all("plugin"), *self.user.all("plugin")]))

    def pose(self, default: str, own: Frames | None = None) -> tuple[Pose, str]:
        """Return its pose, and the frame that the pose is relative to.

        Args:
            default: the frame that the pose is relative to by default.
            own: the frames of the model, one of which may be the placement frame.
        """
        placing = self.user if self.user.find("pose") else self.element
        pose, relative_to = read_pose(placing, default)
        anchor = self.user.word("placement_frame") or self.element.attributes.get("placement_frame")
        if anchor and own:
            pose = pose @ own.pose(anchor, placing).inverse()
        return pose, relative_to


def read_placed(parent: Element, source: Source, reading: Reading, *tags: str) -> list[Placed]:
    """Return the models and lights in an element, in the order of the file.

    Args:
        parent: a world, a model or a whole file.
        source: the file that contains it.
        reading: the context of the reading.
        tags: the kinds, ``model`` and ``light``; other contents of included files are left out.
    """
    placed: list[Placed] = []
    for child in parent.all("include", *tags):
        if child.tag == "include":
            included = source.include(child, reading)
            if included is None:
                continue
            holder = included.root.find("world") or included.root
            found = [Placed(each, included, child, child.is_set("merge")) for each in holder.all(*tags)]
            if not found:
                what = f"'{child.require('uri').text}' holds no {' or '.join(tags)}: nothing is included"
                reading.notes.warn(child, Code.NRP260, what)
            placed += found if holder is included.root else without_surroundings(found, reading)
        else:
            placed.append(Placed(child, source, child))
    return _told_apart(placed, reading)


def without_surroundings(placed: Sequence[Placed], reading: Reading) -> Sequence[Placed]:
    """Return the only model that moves, if all others are static: files of robots often bring a floor."""
    moving = [thing for thing in placed if thing.element.tag == "model" and not thing.static]
    if len(moving) != 1:
        return placed
    for thing in placed:
        if thing is not moving[0]:
            name, tag = thing.element.attribute("name"), thing.element.tag
            what = f"the static '{name}'" if tag == "model" else f"the light '{name}'"
            message = f"{what} in the file of a robot is left out: the room is another file"
            reading.notes.warn(thing.element, Code.NRP260, message, subject=name)
    return moving


def _told_apart(placed: list[Placed], reading: Reading) -> list[Placed]:
    """Return models or lights with unique names: includes are numbered as in Gazebo.

    Elements written in place keep their names: duplicates among them are mistakes of the file.
    """
    names = {(thing.element.tag, thing.name) for thing in placed}
    seen: set[tuple[str, str]] = set()
    result: list[Placed] = []
    for thing in placed:
        tag, name = thing.element.tag, thing.name
        included = thing.user is not thing.element and not thing.user.word("name")
        if included and not thing.merged and (tag, name) in seen:
            free = next(f"{name}_{n}" for n in count() if (tag, f"{name}_{n}") not in names)
            reading.notes.warn(
                thing.user,
                Code.NRP266,
                f"another {tag} is named '{name}': this one is renamed '{free}'",
                subject=name,
            )
            thing = replace(thing, other_name=free)
            names.add((tag, free))
        seen.add((tag, name))
        result.append(thing)
    return result
