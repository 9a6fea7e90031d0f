"""Joints of SDF."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import hypot, inf

from nrp_core.errors import did_you_mean
from nrp_core.world.scene.checks import MODEL, WORLD
from nrp_core.world.scene.model import Joint, Mimic
from nrp_core.world.scene.pose import Vector
from nrp_core.world.scene.reading import Reading
from nrp_core.world.scene.sdf.frames import Frames
from nrp_core.world.scene.xml_tree import Element

_KINDS = ("fixed", "revolute", "continuous", "prismatic")
_NOT_SIMULATED = ("ball", "planar", "revolute2", "screw", "universal")
_UNLIMITED = 1e16  # how SDF wrote "no limit" before it had inf
_Z: Vector = (0.0, 0.0, 1.0)
_ROUNDING = 1e-12


def read_joints(
    model: Element, frames: Frames, version: tuple[int, int], reading: Reading
) -> Iterator[Joint]:
    """Read the joints of a model that hold links; a gearbox holds none, it couples two other joints."""
    for joint in model.all("joint"):
        if joint.attribute("type") == "gearbox":
            reading.notes.warn(joint, "joints of type 'gearbox' are not simulated: left out")
        else:
            yield read_joint(joint, frames, version, reading)


def without_loops(joints: Iterable[Joint], model: Element, reading: Reading) -> tuple[Joint, ...]:
    """Return joints without those that connect what earlier ones connect already."""
    connected: dict[str, set[str]] = {}
    kept = []
    for joint in joints:
        one, other = (connected.setdefault(end, {end}) for end in (joint.parent, joint.child))
        if one is other:
            named = (each for each in model.all("joint") if each.attribute("name") == joint.name)
            message = f"the joint '{joint.name}' closes a loop of joints, which is not simulated: left out"
            reading.notes.warn(next(named, model), message)
            continue
        one |= other
        connected.update(dict.fromkeys(other, one))
        kept.append(joint)
    return tuple(kept)


def read_joint(joint: Element, frames: Frames, version: tuple[int, int], reading: Reading) -> Joint:
    """Read a ``<joint>``.

    Args:
        joint: the element.
        frames: of its model.
        version: of the file; up to SDF 1.4 the axis is given in the frame of the model.
        reading: what is carried along.

    Raises:
        SceneError: it has no such type, or its links or frames are not there.
    """
    name = joint.attribute("name")
    parent, child = _ends(joint, frames)
    axis = joint.section("axis")
    limit = axis.section("limit")
    lower, upper = _range(limit)
    kind = _kind(joint, lower, upper, reading)
    pose = frames.pose(name, joint)
    if kind == "fixed":
        return Joint(name, kind, parent, child, pose)
    return Joint(
        name,
        kind,
        parent,
        child,
        pose,
        _unit(pose.inverse().rotate(_axis(joint, axis, frames, version))),
        *((-inf, inf) if kind == "continuous" else (lower, upper)),
        effort=_maximum(limit, "effort"),
        velocity=_maximum(limit, "velocity"),
        damping=axis.section("dynamics").number("damping", 0.0),
        friction=max(0.0, axis.section("dynamics").number("friction", 0.0)),
        mimic=_mimic(axis, name),
    )


def _mimic(axis: Element, name: str) -> Mimic | None:
    """Return which joint this one follows; its ``<reference>`` is where the leader is at 0 of that."""
    mimic = axis.find("mimic")
    if mimic is None:
        return None
    leader, multiplier = mimic.attribute("joint"), mimic.number("multiplier", 1.0)
    if leader == name:
        raise mimic.error(f"the joint '{name}' mimics itself")
    offset = mimic.number("offset", 0.0) - multiplier * mimic.number("reference", 0.0)
    return Mimic(leader, multiplier, offset)


def with_leaders(joints: Iterable[Joint], model: Element, reading: Reading) -> Iterator[Joint]:
    """Yield joints, those free that would mimic one that does not move.

    Raises:
        SceneError: one mimics a joint that is not there.
    """
    joints = tuple(joints)
    kinds = {joint.name: joint.kind for joint in joints}
    for joint in joints:
        if joint.mimic is not None:
            leader = joint.mimic.leader
            named = (each for each in model.all("joint") if each.attribute("name") == joint.name)
            element = next(named, model)
            if leader not in kinds:
                hint = did_you_mean(leader, kinds)
                raise element.error(f"the joint '{joint.name}' mimics '{leader}', which is not there{hint}")
            if kinds[leader] == "fixed":
                message = f"the joint '{joint.name}' mimics '{leader}', which is fixed: it moves freely"
                reading.notes.warn(element, message)
                joint = replace(joint, mimic=None)
        yield joint


def _ends(joint: Element, frames: Frames) -> tuple[str, str]:
    """Return parent and child."""
    name = joint.attribute("name")
    parent, child = (_link(joint.require(tag), frames) for tag in ("parent", "child"))
    if child == WORLD:
        raise joint.error(f"the world cannot be the child of the joint '{name}'; it can be the parent")
    if parent == child:
        raise joint.error(f"the joint '{name}' connects the link '{child}' with itself")
    return parent, child


def _kind(joint: Element, lower: float, upper: float, reading: Reading) -> str:
    """Return what a joint amounts to: without limits it goes round, with both at 0 it is fixed."""
    kind = joint.attribute("type")
    if kind in _NOT_SIMULATED:
        reading.notes.warn(joint, f"joints of type '{kind}' are not simulated: the links are taken as fixed")
        return "fixed"
    if kind not in _KINDS:
        raise joint.error(f"there are no joints of type '{kind}'{did_you_mean(kind, _KINDS)}")
    if kind == "revolute" and lower == upper == 0:
        return "fixed"
    return "continuous" if kind == "revolute" and (lower, upper) == (-inf, inf) else kind


def _link(element: Element, frames: Frames) -> str:
    if not element.text:
        raise element.error(f"<{element.tag}> must name a link")
    return WORLD if element.text == WORLD else frames.body(element.text, element)


def _axis(joint: Element, axis: Element, frames: Frames, version: tuple[int, int]) -> Vector:
    """Return the axis in the frame of the model."""
    in_model = axis.flag("use_parent_model_frame", version <= (1, 4))
    default = MODEL if in_model else joint.attribute("name")
    xyz = axis.section("xyz")
    frame = xyz.attributes.get("expressed_in") or default
    return frames.pose(frame, xyz).rotate(axis.direction("xyz", _Z))


def _unit(axis: Vector) -> Vector:
    """Return an axis that was turned there and back without the rounding of that; engines test its length."""
    x, y, z = (0.0 if abs(part) < _ROUNDING else part for part in axis)
    length = hypot(x, y, z)
    return x / length, y / length, z / length


def _range(limit: Element) -> tuple[float, float]:
    lower, upper = limit.number("lower", -inf, finite=False), limit.number("upper", inf, finite=False)
    if lower > upper:
        raise limit.error(f"the lower limit ({lower:g}) is above the upper one ({upper:g})")
    return (lower if lower > -_UNLIMITED else -inf), (upper if upper < _UNLIMITED else inf)


def _maximum(limit: Element, tag: str) -> float:
    """Return a limit that is not enforced where it is negative."""
    value = limit.number(tag, inf, finite=False)
    return value if 0 <= value < _UNLIMITED else inf
