"""Joints of SDF with several degrees of freedom, read as simple joints in series.

=============  ==================================================================================
a joint ``j``  becomes
=============  ==================================================================================
universal      ``j``, which turns about ``<axis>``, and ``j_axis2``, which turns about ``<axis2>``
revolute2      the same
screw          ``j``, which turns, and ``j_travel``, which slides as far as the thread takes it
planar         ``j_x`` and ``j_y``, which slide across ``<axis>``, and ``j``, which turns about it
=============  ==================================================================================

Gazebo's plugins and messages that name such a joint mean its first axis; the same holds here. Between the
joints are links with almost no mass. Engines in joint coordinates can handle these, because a joint moves
everything that follows it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from math import hypot, inf, pi
from typing import TypeAlias

import numpy as np

from nrp_core.findings import Code
from nrp_core.scene.consistency import MODEL, SECOND_AXIS
from nrp_core.scene.model import Inertial, Joint, Link, Mimic
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.rigid import Pose, Vector
from nrp_core.scene.sdf.frames import Frames

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
        element.pass_over(tag)
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
    return with_dynamics(joint if kind == "continuous" else replace(joint, lower=lower, upper=upper), axis)


def with_dynamics(joint: Joint, axis: Element) -> Joint:
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


Row: TypeAlias = tuple[Joint, ...]
"""The joints from one link to another, each as if it were the only one between them."""

CARRIER = Inertial(1e-9, inertia=(1e-12, 1e-12, 1e-12, 0.0, 0.0, 0.0))
"""Mass of a link between two joints, kg: accepted by engines and negligible."""
_PARALLEL = 1e-6
_RIGHT_HANDED_TURN = 1.0  # SDF's default pitch of a thread, m


def in_a_row(row: Sequence[Joint]) -> tuple[list[Joint], list[Link]]:
    """Return joints in series, and the links between them."""
    carriers = [Link(f"{joint.name}_carrier", joint.pose, CARRIER) for joint in row[:-1]]
    stops = [row[0].parent, *(carrier.name for carrier in carriers), row[-1].child]
    joints = [
        replace(joint, parent=parent, child=child)
        for joint, (parent, child) in zip(row, pairwise(stops), strict=True)
    ]
    return joints, carriers


def ball(joint: Joint, element: Element, _: Frames, __: tuple[int, int], reading: Reading) -> Row:
    """Read a ``ball`` joint; its damping and friction act about every axis."""
    axis = element.section("axis")
    axis.pass_over("xyz", "limit")
    axis.section("dynamics").pass_over("spring_reference")
    if axis.section("dynamics").number("spring_stiffness", 0.0):
        reading.notes.warn(axis, Code.NRP383, "a <spring_stiffness> of a ball joint is not simulated")
    return (with_dynamics(replace(joint, kind="ball"), axis),)


def two_axes(
    joint: Joint, element: Element, frames: Frames, version: tuple[int, int], reading: Reading
) -> Row:
    """Read a ``universal`` or ``revolute2`` joint: the first axis is the parent's, the second the child's."""
    turning = replace(joint, kind="revolute")
    first = with_axis(turning, element, "axis", frames, version)
    other = with_axis(replace(turning, name=second(joint.name)), element, "axis2", frames, version)
    if hypot(*np.cross(first.axis, other.axis)) < _PARALLEL:
        what = f"both axes of the joint '{joint.name}' are the same: it turns about the first one only"
        reading.notes.warn(element, Code.NRP264, what, subject=joint.name)
        return (first,)
    return first, other


def screw(joint: Joint, element: Element, frames: Frames, version: tuple[int, int], _: Reading) -> Row:
    """Read a ``screw`` joint: its limits, effort and damping are those of its rotation."""
    turn = with_axis(replace(joint, kind="revolute"), element, "axis", frames, version)
    if turn.kind == "fixed":
        return (turn,)
    follows = Mimic(joint.name, _pitch(element) / (2 * pi))
    travel = Joint(
        f"{joint.name}_travel", "prismatic", joint.parent, joint.child, joint.pose, turn.axis, mimic=follows
    )
    return turn, travel


def _pitch(screw: Element) -> float:
    """Return the pitch of the thread, m per turn; negative for a left-handed one.

    The older ``<thread_pitch>`` is in radians per metre, of a left-handed thread.
    """
    old = screw.find("thread_pitch")
    if old is None or screw.find("screw_thread_pitch"):
        return screw.number("screw_thread_pitch", _RIGHT_HANDED_TURN)
    (turns_left,) = old.numbers(1)
    if not turns_left:
        raise old.error("<thread_pitch> is 0: a screw that slides without turning is a prismatic joint")
    return -2 * pi / turns_left


def planar(joint: Joint, element: Element, frames: Frames, version: tuple[int, int], _: Reading) -> Row:
    """Read a ``planar`` joint of URDF: its axis is the normal of the plane, and it has no limits."""
    turn = with_axis(replace(joint, kind="continuous"), element, "axis", frames, version)
    across = Pose.pointing(turn.axis)
    slides = [
        replace(
            turn,
            name=f"{joint.name}_{name}",
            kind="prismatic",
            axis=across.rotate(axis),
            mimic=None,
            stiffness=0.0,
        )
        for name, axis in (("x", (1.0, 0.0, 0.0)), ("y", (0.0, 1.0, 0.0)))
    ]
    return *slides, replace(turn, lower=-inf, upper=inf)


COMPOUND: dict[str, Callable[[Joint, Element, Frames, tuple[int, int], Reading], Row]] = {
    "ball": ball,
    "planar": planar,
    "revolute2": two_axes,
    "screw": screw,
    "universal": two_axes,
}
"""Readers of the joint types with more than one axis."""
