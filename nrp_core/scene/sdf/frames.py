"""Frames of SDF, to which poses are relative.

Every link, joint, nested model and ``<frame>`` of a model is a frame with its name; a pose is relative to its
element's default (the model for a link, the child for a joint, ...) unless ``relative_to`` (``frame`` before
SDF 1.7) names another one. See the specification's chapter on pose frame semantics.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from itertools import count
from math import radians, sqrt
from operator import matmul

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_core.scene.bodies import free_name
from nrp_core.scene.consistency import MODEL, WORLD
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.rigid import Pose
from nrp_core.scene.sdf.source import SdfFile

_FORMATS = {"euler_rpy": 6, "quat_xyzw": 7}


def read_pose(element: Element, default: str) -> tuple[Pose, str]:
    """Return the pose in an element's ``<pose>`` and the frame that it is relative to."""
    pose = element.find("pose")
    if pose is None:
        return Pose(), default
    relative_to = pose.attributes.get("relative_to") or pose.attributes.get("frame") or default
    return (_parse(pose) if pose.text else Pose()), relative_to


def _parse(pose: Element) -> Pose:
    kind = pose.attributes.get("rotation_format", "euler_rpy")
    if kind not in _FORMATS:
        raise pose.error(f"rotation_format is '{kind}'{did_you_mean(kind, _FORMATS)}")
    x, y, z, *turn = pose.numbers(_FORMATS[kind])
    if kind == "euler_rpy":
        if pose.is_set("degrees"):
            turn = [radians(angle) for angle in turn]
        return Pose.from_rpy((x, y, z), turn[0], turn[1], turn[2])
    norm = sqrt(sum(part * part for part in turn))
    if not norm:
        raise pose.error("the quaternion is 0 0 0 0, which is not a rotation")
    qx, qy, qz, qw = (part / norm for part in turn)
    return Pose((x, y, z), (qx, qy, qz, qw))


def model_scope(name: str, merged: bool) -> tuple[str, str]:
    """Return the prefix of a nested model's names, and the name of its own frame."""
    return ("", f"_merged__{name}") if merged else (f"{name}::", name)


@dataclass(frozen=True, slots=True)
class _Frame:
    pose: Pose
    relative_to: str
    attached_to: str
    element: Element


class Frames:
    """The frames of one model, or of the world.

    Args:
        scope: the element with the frames.
        root: the name of the frame that all poses are resolved to.
        base: the body that the root moves with: the canonical link.
        other_name: another name of the root; up to SDF 1.6 Gazebo ignores that a pose is in the frame of its
            own model, the default.
    """

    def __init__(self, scope: Element, root: str, base: str, other_name: str = "") -> None:
        self.base = base
        self._other_name = other_name
        self._root = root
        self._scope = scope
        self._frames: dict[str, _Frame] = {}
        self._renamed: dict[Element, str] = {}

    def add(self, element: Element, default: str, *, attached_to: str = "", shared: bool = False) -> None:
        """Add a named element with a pose.

        Args:
            element: the link, joint, frame or model.
            default: the frame that its pose is relative to by default.
            attached_to: the frame it moves with; empty if it is a separate body.
            shared: whether its name may be that of an element with another tag, as up to SDF 1.6; the tag is
                then appended to the name of its frame, as libsdformat does (``Joint with name [j] ... has a
                name collision, changing joint name to [j_joint]``).

        Raises:
            SceneError: the name is taken or reserved.
        """
        pose, relative_to = read_pose(element, default)
        name = element.attribute("name")
        other = self._frames.get(name)
        if shared and other is not None and other.element.tag != element.tag:
            name = self._renamed[element] = f"{name}_{element.tag}"
        self.put(name, pose, relative_to, attached_to, element)

    def name_of(self, element: Element) -> str:
        """Return the name of the frame of an element that was added."""
        return self._renamed.get(element) or element.attribute("name")

    def put(self, name: str, pose: Pose, relative_to: str, attached_to: str, element: Element) -> None:
        """Add a resolved frame."""
        if name in self._frames:
            other = self._frames[name].element
            raise element.error(
                f"the name '{name}' is used by the <{other.tag}> on line {other.line}; names in a "
                f"<{self._scope.tag}> must be unique"
            )
        if name == WORLD or (name.startswith("__") and name.endswith("__")):
            raise element.error(f"the name '{name}' is reserved")
        self._frames[name] = _Frame(pose, relative_to, attached_to, element)

    def add_model(
        self, name: str, placed: tuple[Pose, str], nested: Frames, element: Element, *, merged: bool = False
    ) -> None:
        """Add a nested model and its frames, as ``name::frame`` unless it is merged.

        Args:
            name: the name of the model.
            placed: its pose and the frame that the pose is relative to.
            nested: its frames.
            element: the element that places it.
            merged: whether its frames become frames of this scope.
        """
        prefix, frame = model_scope(name, merged)
        self.put(frame, *placed, prefix + nested.base, element)
        for inner in nested._frames:
            body = nested.body(inner, element)
            attached_to = "" if body == inner else prefix + body
            self.put(prefix + inner, nested.pose(inner, element), frame, attached_to, element)

    def pose(self, name: str, user: Element) -> Pose:
        """Return the pose of a frame in the root frame.

        Args:
            name: the name of the frame.
            user: the element that refers to it, for messages.
        """
        chain: dict[str, Pose] = {}
        while name != self._root:
            if name in chain:
                raise user.error(f"the frame '{name}' is relative to itself, through a cycle of frames")
            frame = self._frame(name, user)
            chain[name] = frame.pose
            name, user = frame.relative_to, frame.element
        return reduce(matmul, reversed(chain.values()), Pose())

    def require(self, element: Element) -> None:
        """Check that an added element has a pose and moves with a link, even if it is not used.

        Raises:
            SceneError: it is placed or attached in a cycle, or by a frame that does not exist.
        """
        name = self.name_of(element)
        self.body(name, element)
        self.pose(name, element)

    def place_in(self, element: Element, frame: str) -> Pose:
        """Return an element's ``<pose>`` in a frame, which is its default."""
        pose, relative_to = read_pose(element, frame)
        if relative_to == frame:
            return pose
        return self.pose(frame, element).inverse() @ self.pose(relative_to, element) @ pose

    def body(self, name: str, user: Element) -> str:
        """Return the link that a frame moves with."""
        seen: set[str] = set()
        while name != self._root:
            if name in seen:
                raise user.error(f"the frame '{name}' is attached to itself, through a cycle of frames")
            seen.add(name)
            attached_to = self._frame(name, user).attached_to
            if not attached_to:
                return name
            name = attached_to
        return self.base

    def _frame(self, name: str, user: Element) -> _Frame:
        name = name.removesuffix(f"::{MODEL}")  # the frame of a nested model, under its other name
        if name not in self._frames and name == self._other_name:
            return _Frame(Pose(), self._root, self._root, self._scope)
        if name not in self._frames:
            owner = self._scope.attributes.get("name", "")
            raise user.error(
                f"the {self._scope.tag} '{owner}' has no frame '{name}'{did_you_mean(name, self._frames)}"
            )
        return self._frames[name]


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
    source: SdfFile
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
        placed = [each for each in (self.user, self.element) if each.find("pose")]  # each is asked for it
        placing = placed[0] if placed else self.element
        pose, relative_to = read_pose(placing, default)
        anchor = self.user.word("placement_frame") or self.element.attributes.get("placement_frame")
        if anchor and own:
            pose = pose @ own.pose(anchor, placing).inverse()
        return pose, relative_to


def read_placed(parent: Element, source: SdfFile, reading: Reading, *tags: str) -> list[Placed]:
    """Return the models and lights in an element, in the order of the file.

    Args:
        parent: a world, a model or a whole file.
        source: the file that contains it.
        reading: the context of the reading.
        tags: the kinds, ``model`` and ``light``; other contents of included files are ignored.
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
            pass_over_room(included.root)
            placed += found if holder is included.root else without_surroundings(found, reading)
        else:
            placed.append(Placed(child, source, child))
    return _with_unique_names(placed, reading)


def pass_over_room(root: Element) -> None:
    """Mark everything but the models in a robot's file as not needed."""
    for holder in (root, *root.all("world")):
        holder.pass_over(*{child.tag for child in holder.children} - {"model", "world", "include"})


def without_surroundings(placed: Sequence[Placed], reading: Reading) -> Sequence[Placed]:
    """Return the only model that moves, if all others are static: files of robots often contain a floor."""
    moving = [thing for thing in placed if thing.element.tag == "model" and not thing.static]
    if len(moving) != 1:
        return placed
    for thing in placed:
        if thing is not moving[0]:
            name, tag = thing.element.attribute("name"), thing.element.tag
            thing.element.passed_over = True
            what = f"the static '{name}'" if tag == "model" else f"the light '{name}'"
            message = f"{what} in the file of a robot is left out: the room is another file"
            reading.notes.warn(thing.element, Code.NRP260, message, subject=name)
    return moving


def with_unique_links(model: Element, reading: Reading) -> Element:
    """Return a static model, to whose links no joint refers, with unique names of links."""
    links = model.all("link")
    names = [link.attributes.get("name", "") for link in links]
    renamed: dict[Element, Element] = {}
    for number, (link, name) in enumerate(zip(links, names, strict=True)):
        if name and name in names[:number]:
            names[number] = free = free_name(name, names)
            message = f"another link is named '{name}': this one is renamed '{free}'"
            reading.notes.warn(link, Code.NRP266, message, subject=name)
            renamed[link] = replace(link, attributes={**link.attributes, "name": free})
    return replace(model, children=[renamed.get(each, each) for each in model.children]) if renamed else model


def _with_unique_names(placed: list[Placed], reading: Reading) -> list[Placed]:
    """Return models and included lights with unique names, numbered as in Gazebo."""
    names = {(thing.element.tag, thing.name) for thing in placed}
    seen: set[tuple[str, str]] = set()
    result: list[Placed] = []
    for thing in placed:
        tag, name = thing.element.tag, thing.name
        named = tag == "model" or thing.user is not thing.element
        if named and not thing.merged and (tag, name) in seen:
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
