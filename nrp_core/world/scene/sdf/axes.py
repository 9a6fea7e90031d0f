"""An axis of a joint of SDF: direction, limits, damping and mimic."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, inf

from nrp_core.world.rigid.pose import Vector
from nrp_core.world.scene.checks import MODEL, SECOND_AXIS
from nrp_core.world.scene.model import Joint, Mimic
from nrp_core.world.scene.reading.xml import Element
from nrp_core.world.scene.sdf.frames import Frames

_UNLIMITED = 1e16  # how SDF wrote "no limit" before it had inf
_Z: Vector = (0.0, 0.0, 1.0)
_ROUNDING = 1e-12


def second(name: str) -> str:
    """Return the name of the joint for the second axis of a joint."""
    return name + SECOND_AXIS


def with_axis(joint: Joint, element: Element, tag: str, frames: Frames, version: tuple[int, int]) -> Joint:
    """Return a joint with the properties of an ``<axis>``.

    Args:
        joint: the joint without them.
        element: the ``<joint>``.
        tag: ``axis`` or ``axis2``.
        frames: the frames of its model.
        version: version of the file; up to SDF 1.4 the axis is given in the frame of the model.

    Returns:
        The joint; one that turns without limits is continuous, one that turns from 0 to 0 is fixed.

    Raises:
        SceneError: a number is invalid, or a frame does not exist.
    """
    axis = element.section(tag)
    limit = axis.section("limit")
    lower, upper = _range(limit)
    kind = joint.kind
    if kind == "revolute" and lower == upper == 0:
        return replace(joint, kind="fixed")
    if kind == "revolute" and (lower, upper) == (-inf, inf):
        kind = "continuous"
    joint = replace(
        joint,
        kind=kind,
        axis=_unit(joint.pose.rotate_back(direction(element, tag, frames, version))),
        effort=_maximum(limit, "effort"),
        velocity=_maximum(limit, "velocity"),
        mimic=_mimic(axis, joint.name),
    )
    dynamics = axis.section("dynamics")
    joint = replace(
        joint,
        stiffness=max(0.0, dynamics.number("spring_stiffness", 0.0)),
        rest=dynamics.number("spring_reference", 0.0),
    )
    return slowed(joint if kind == "continuous" else replace(joint, lower=lower, upper=upper), axis)


def slowed(joint: Joint, axis: Element) -> Joint:
    """Return a joint with the damping and the friction of its ``<axis>``."""
    dynamics = axis.section("dynamics")
    damping, friction = dynamics.number("damping", 0.0), max(0.0, dynamics.number("friction", 0.0))
    return replace(joint, damping=damping, friction=friction)


def direction(joint: Element, tag: str, frames: Frames, version: tuple[int, int]) -> Vector:
    """Return the direction of an axis of a ``<joint>`` in the frame of the model."""
    axis = joint.section(tag)
    in_model = axis.flag("use_parent_model_frame", version <= (1, 4))
    default = MODEL if in_model else frames.name_of(joint)
    xyz = axis.section("xyz")
    frame = xyz.attributes.get("expressed_in") or default
    return frames.pose(frame, xyz).rotate(axis.direction("xyz", _Z))


def _mimic(axis: Element, name: str) -> Mimic | None:
    """Return the joint that this one follows; ``<reference>`` is the leader's position at the offset."""
    mimic = axis.find("mimic")
    if mimic is None:
        return None
    leader, multiplier = mimic.attribute("joint"), mimic.number("multiplier", 1.0)
    if mimic.attributes.get("axis") == "axis2":
        leader = second(leader)
    if leader == name:
        raise mimic.error(f"the joint '{name}' mimics itself")
    offset = mimic.number("offset", 0.0) - multiplier * mimic.number("reference", 0.0)
    return Mimic(leader, multiplier, offset)


def _unit(axis: Vector) -> Vector:
    """Return an axis without rounding errors of rotations, because engines check its length."""
    x, y, z = (0.0 if abs(part) < _ROUNDING else part for part in axis)
    length = hypot(x, y, z)
    return x / length, y / length, z / length


def _range(limit: Element) -> tuple[float, float]:
    lower, upper = limit.number("lower", -inf, finite=False), limit.number("upper", inf, finite=False)
    if lower > upper:
        raise limit.error(f"the lower limit ({lower:g}) is above the upper one ({upper:g})")
    return (lower if lower > -_UNLIMITED else -inf), (upper if upper < _UNLIMITED else inf)


def _maximum(limit: Element, tag: str) -> float:
    """Return a limit; a negative one is not enforced."""
    value = limit.number(tag, inf, finite=False)
    return value if 0 <= value < _UNLIMITED else inf
