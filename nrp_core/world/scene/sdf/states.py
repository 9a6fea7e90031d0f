"""The ``<state>`` of a saved world: where its things were last."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import atan2, pi, radians, remainder

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_core.world.rigid.pose import Pose, Vector
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.model import Joint, Model
from nrp_core.world.scene.reading.context import Notes
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sdf.frames import read_pose

_ROUNDING = 1e-4
"""The largest position (rad, m) of a joint that the rounding of poses in a file explains."""
_AXES = {"axis_state": "", "axis2_state": "_axis2"}
"""The states of the axes of a joint from SDF 1.12, and what follows the name of the joint of each."""


@dataclass(slots=True)
class State:
    """The changes in the states of a world: poses, positions, and added and removed elements.

    Args:
        poses: the poses of models and lights, by kind and name.
        links: the poses of links in the world, by model and link.
        joints: the positions of joints (rad, m), by model and joint.
        inserted: elements whose children are added.
        deleted: the names of what is removed.
        named: the models and lights that have a state.
    """

    poses: dict[tuple[str, str], Pose] = field(default_factory=dict)
    links: dict[str, dict[str, Pose]] = field(default_factory=dict)
    joints: dict[str, dict[str, float]] = field(default_factory=dict)
    inserted: list[Element] = field(default_factory=list)
    deleted: set[str] = field(default_factory=set)
    named: dict[str, Element] = field(default_factory=dict)

    @classmethod
    def read(cls, states: Iterable[Element], notes: Notes) -> State:
        """Read the states of a world; SDF 1.12 has ``<model_state>`` where earlier versions have ``<model>``.

        Raises:
            SceneError: a pose or a position is not one.
        """
        result = cls()
        for state in states:
            for thing in _of(state, "model", "light"):
                kind, name = thing.tag.removesuffix("_state"), thing.attribute("name")
                if thing.find("pose") is not None:
                    result.poses[kind, name] = read_pose(thing, WORLD)[0]
                result.named[name] = thing
                _warn_of_scale(thing, kind, notes)
                result.links[name] = dict(_links(thing, ""))
                result.joints[name] = dict(_joints(thing, ""))
            result.inserted += state.all("insertions")
            result.deleted |= {
                name.text for deletions in state.all("deletions") for name in deletions.all("name")
            }
        return result

    def warn_of_misspelt(self, names: Iterable[str], notes: Notes) -> None:
        """Report each state of nothing in the world whose name is nearly that of a thing without a state."""
        others = [name for name in names if name not in self.named]
        for name in self.named.keys() - set(names) - self.deleted:
            hint = did_you_mean(name, others)
            if hint.instead is not None:
                message = f"the <state> of '{name}' has no effect: the world has no such model or light{hint}"
                notes.warn(self.named[name], Code.NRP263, message, subject=name)

    def of(self, model: Model) -> Model:
        """Return a model where it was last, with its joints where they were."""
        placed = replace(model, pose=self.poses.get(("model", model.name), model.pose))
        links, told = self.links.get(model.name, {}), self.joints.get(model.name, {})
        starts = dict(placed.starts)
        for joint in placed.joints:
            if not joint.takes_commands or joint.mimic is not None:
                continue
            position = told.get(joint.name)
            if position is None:
                position = _between(placed, joint, links)
            if position is not None:
                starts[joint.name] = min(max(position, joint.lower), joint.upper)
        return replace(placed, starts=tuple(starts.items()))


def _of(parent: Element, *kinds: str) -> Iterable[Element]:
    return parent.all(*kinds, *(f"{kind}_state" for kind in kinds))


def _warn_of_scale(thing: Element, kind: str, notes: Notes) -> None:
    scale = thing.section("scale")
    if scale.text and any(part != 1 for part in scale.numbers(3)):
        notes.warn(scale, Code.NRP263, f"the <scale> {scale.text} of a <{kind}> is not supported")


def _links(model: Element, prefix: str) -> Iterator[tuple[str, Pose]]:
    for link in _of(model, "link"):
        if link.find("pose") is not None:
            yield prefix + link.attribute("name"), read_pose(link, WORLD)[0]
    for inner in _of(model, "model"):
        yield from _links(inner, f"{prefix}{inner.attribute('name')}::")


def _joints(model: Element, prefix: str) -> Iterator[tuple[str, float]]:
    for joint in _of(model, "joint"):
        name = prefix + joint.attribute("name")
        for angle in joint.all("angle"):
            suffix = "_axis2" if angle.attributes.get("axis", "0") == "1" else ""
            yield name + suffix, angle.numbers(1)[0]
        for tag, suffix in _AXES.items():
            position = joint.find(tag, "position")
            if position is not None:
                (value,) = position.numbers(1)
                yield name + suffix, radians(value) if position.is_set("degrees") else value
    for inner in _of(model, "model"):
        yield from _joints(inner, f"{prefix}{inner.attribute('name')}::")


def _between(model: Model, joint: Joint, links: Mapping[str, Pose]) -> float | None:
    """Return the position of a joint that is between the poses of two links, None if it cannot be known."""
    at_0 = {link.name: link.pose for link in model.links}
    here, child = model.pose if joint.parent == WORLD else links.get(joint.parent), links.get(joint.child)
    if here is None or child is None:
        return None
    holder = here @ at_0.get(joint.parent, Pose()).inverse() @ joint.pose
    moved = holder.inverse() @ child @ at_0[joint.child].inverse() @ joint.pose
    if joint.kind == "prismatic":
        position = _along(moved.position, joint.axis)
    else:
        *turn, w = moved.orientation
        position = remainder(2 * atan2(_along(turn, joint.axis), w), 2 * pi)
    return position if abs(position) > _ROUNDING else 0.0


def _along(vector: Iterable[float], axis: Vector) -> float:
    return sum(part * share for part, share in zip(vector, axis, strict=True))
