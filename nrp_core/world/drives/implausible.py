"""Drives with wheels that are valid, but that do not fit the robot that they move."""

from __future__ import annotations

from collections.abc import Iterator
from math import dist, inf, tau
from typing import Final, Protocol, runtime_checkable

import numpy as np

from nrp_core.errors import SceneError
from nrp_core.world.rigid import Vector, matrix_of
from nrp_core.world.scene.devices import MountedDrive
from nrp_core.world.scene.implausible_shapes import box_around
from nrp_core.world.scene.merged_bodies import bodies_of
from nrp_core.world.scene.model import Box, Collision, Cylinder, Joint, Link, Model, Sphere

_WHEEL_TIMES: Final = 1.5
"""How much larger a wheel may be than its shape; a radius in place of a diameter is off by 2."""
_TRACK_TIMES: Final = 3.0
"""How much larger the track may be than the distance of the wheels: wheels that skid need up to twice."""
_NARROW: Final = 1.5
"""How much smaller it may be: no wheel turns a robot as one that is nearer to the middle."""
_EASIER: Final = 0.8
"""How much smaller a moment of inertia is than another one beyond doubt."""
_UPRIGHT: Final = 0.7
"""The cosine of 45 degrees."""
_ALONG: Final = 0.9
"""The cosine of 25 degrees; wheels may be turned a little to each other."""
_ACROSS: Final = 0.5
"""The cosine of 60 degrees."""
_LIFTED: Final = 0.25
"""How much lower than its wheels a robot may reach, in radii of a wheel; casters give way a little."""
_RESTING: Final = 0.05
"""The same for a box that does not slide, which no caster is."""
_ELSEWHERE: Final = 2.0
"""How much lower it does not reach: then a shape is in another unit, which is reported."""
_WEAKEST_M_S2: Final = 0.02
"""An acceleration with which a robot takes 50 s to reach 1 m/s."""


@runtime_checkable
class _Wheeled(Protocol):
    name: str
    left: tuple[str, ...]
    right: tuple[str, ...]
    separation: float
    wheel_diameter: float
    torque: float


def implausible_drives(model: Model, timestep_s: float) -> Iterator[str]:
    """Yield a sentence for each value of a drive that does not fit the robot or the loop.

    Args:
        model: a robot at its start pose.
        timestep_s: how often the loop can command it.
    """
    for drive in model.drives:
        owner = f"the drive '{drive.name}' of '{model.name}'"
        yield from _too_short(owner, drive, timestep_s)
        yield from _of_controllers(owner, drive, model)
        if isinstance(drive, _Wheeled):
            yield from _of_wheels(owner, drive, model)


def weightless_wheels(model: Model, gravity: Vector) -> Iterator[str]:
    """Yield a sentence for each drive with wheels that no weight presses on the ground.

    Args:
        model: a robot.
        gravity: the acceleration of the scene, m/s^2.
    """
    pulls = [link.gravity for link in model.links if link.inertial is not None]
    for drive in model.drives:
        if isinstance(drive, _Wheeled) and (not any(gravity) or not any(pulls)):
            yield (
                f"the drive '{drive.name}' of '{model.name}' has wheels that nothing presses on the ground: "
                + ("gravity is 0" if not any(gravity) else "gravity pulls no link of it")
            )


def _too_short(owner: str, drive: MountedDrive, timestep_s: float) -> Iterator[str]:
    timeout_s = getattr(drive, "timeout", None)
    if timeout_s is not None and timeout_s < timestep_s:
        yield (
            f"{owner} stops {timeout_s:g} s after a command, and the loop commands it only "
            f"every {timestep_s:g} s"
        )


def _of_controllers(owner: str, drive: MountedDrive, model: Model) -> Iterator[str]:
    """Yield that a joint of a drive has a controller too."""
    both: list[tuple[str, str, str]] = [
        (one.joint, one.kind, one.topic) for one in model.controllers if one.joint in drive.joints
    ]
    both += [
        (joint, "trajectory", leader.command_topic)
        for leader in model.trajectory_controllers
        for joint in leader.joints
        if joint in drive.joints
    ]
    if both:
        joint, kind, topic = both[0]
        more = f" (and {len(both) - 1} more of its joints)" if len(both) > 1 else ""
        yield (
            f"{owner} moves the joint '{joint}'{more}, and so does a {kind} controller on '{topic}': one "
            "works against the other, also without a command"
        )


def _of_wheels(owner: str, drive: _Wheeled, model: Model) -> Iterator[str]:
    up = matrix_of(model.pose)[2, 2]
    if up < _UPRIGHT:
        tilt_deg = np.degrees(np.arccos(np.clip(up, -1.0, 1.0)))
        yield f"'{model.name}' starts tilted by {tilt_deg:.0f} degrees: it does not stand on its wheels"
    for name in sorted(set(drive.left) & set(drive.right)):
        yield f"{owner} has the joint '{name}' on both sides"
    joints = {joint.name: joint for joint in model.joints}
    wheels = [joints[name] for name in (*drive.left, *drive.right) if name in joints]
    yield from _of_shapes(owner, drive, wheels, model)
    yield from _of_grip(owner, wheels, model)
    if up >= _UPRIGHT:
        yield from _of_footing(owner, drive, wheels, model)
    yield from _of_torque(owner, drive, wheels, model)
    for joint in wheels:
        if joint.kind == "fixed":
            yield f"{owner} has a wheel that cannot turn: the joint '{joint.name}' is fixed"
        elif abs(_axis(joint)[2]) > _UPRIGHT:
            yield f"{owner} has a wheel that cannot roll: the joint '{joint.name}' turns about the vertical"
        elif abs(_axis(joint)[0]) > _ALONG:
            yield (
                f"{owner} has a wheel that cannot roll: the joint '{joint.name}' turns about the x axis, in "
                "which the robot drives"
            )
        elif joint.upper - joint.lower < tau:
            limits = f"limits of {joint.lower:g} to {joint.upper:g} rad"
            yield f"{owner} has a wheel that cannot roll: the joint '{joint.name}' has {limits}"
        else:
            yield from _of_lying(owner, joint, model)
    yield from _of_track(owner, drive, joints, model)


def _of_shapes(owner: str, drive: _Wheeled, wheels: list[Joint], model: Model) -> Iterator[str]:
    sizes_m: dict[str, float] = {}
    for joint in wheels:
        shapes = [one.geometry for one in model.link(joint.child).collisions]
        round_ones = [2 * shape.radius for shape in shapes if isinstance(shape, Cylinder | Sphere)]
        sizes_m |= {joint.child: max(round_ones)} if round_ones else {}
    for wheel, size_m in sizes_m.items():
        if not 1 / _WHEEL_TIMES <= drive.wheel_diameter / size_m <= _WHEEL_TIMES:
            yield (
                f"{owner} has wheels of {drive.wheel_diameter:.3g} m diameter, and "
                f"'{wheel}' is {size_m:.3g} m across"
            )
            return


def _of_grip(owner: str, wheels: list[Joint], model: Model) -> Iterator[str]:
    """Yield that a wheel touches nothing although others do, or that it has no friction."""
    touching = {
        link.name
        for body in bodies_of(model)
        if any(one.collisions for one in body.links)
        for link in body.links
    }
    bare = [joint.child for joint in wheels if joint.child not in touching]
    if bare and len(bare) < len(wheels):
        yield f"{owner} has a wheel that touches nothing: '{bare[0]}' has no collision shape, and others have"
    others = [shape for link in model.links for shape in link.collisions]
    if bare and len(bare) == len(wheels) and others and all(shape.friction for shape in others):
        yield f"{owner} has no wheel that touches anything: none of '{bare[0]}' and the others has a shape"
    for joint in wheels:
        shapes = model.link(joint.child).collisions
        if shapes and not any(one.friction for one in shapes):
            yield f"{owner} has a wheel without friction, '{joint.child}': it turns and does not push"
            return


def _of_footing(owner: str, drive: _Wheeled, wheels: list[Joint], model: Model) -> Iterator[str]:
    """Yield that a robot rests on another part than its wheels."""
    turning = {joint.child for joint in wheels}
    wheel_lows: dict[str, float] = {}
    others: list[tuple[float, float, str]] = []
    for link in model.links:
        for shape in link.collisions:
            try:
                box = box_around([(link.pose @ shape.pose, shape.geometry)])
            except SceneError:
                return  # a mesh cannot be read, which is reported where it is needed
            low = inf if box is None else float(box[0][2])
            if link.name in turning:
                wheel_lows[link.name] = min(wheel_lows.get(link.name, inf), low)
            else:
                others.append((low + _slack(shape) * drive.wheel_diameter / 2, low, link.name))
    if not others or not turning <= wheel_lows.keys():
        return
    ground = min(wheel_lows.values())
    limit, low, lowest = min(others)
    if limit < ground and ground - low < _ELSEWHERE * drive.wheel_diameter / 2:
        gap_m = ground - low
        yield f"{owner} has wheels that do not reach the ground: '{lowest}' reaches {gap_m:.2g} m lower"


def _slack(shape: Collision) -> float:
    """Return how much lower than its wheels a robot may reach with a shape, in radii of a wheel."""
    return _LIFTED if shape.friction == 0 or not isinstance(shape.geometry, Box) else _RESTING


def _of_torque(owner: str, drive: _Wheeled, wheels: list[Joint], model: Model) -> Iterator[str]:
    mass = sum(link.inertial.mass for link in model.links if link.inertial is not None)
    push = 2 * drive.torque * len(wheels) / drive.wheel_diameter
    if push < _WEAKEST_M_S2 * mass:
        yield (
            f"{owner} has a torque of at most {drive.torque:g} N m, which accelerates {mass:.3g} kg by "
            f"{push / mass:.2g} m/s^2: is that meant?"
        )


def _of_lying(owner: str, joint: Joint, model: Model) -> Iterator[str]:
    """Yield that the cylinder of a wheel lies across the axis about which it turns."""
    link = model.link(joint.child)
    if len(link.collisions) == 1 and isinstance(link.collisions[0].geometry, Cylinder):
        along = matrix_of(link.pose @ link.collisions[0].pose)[:, 2]
        if abs(float(along @ _axis(joint))) < _ACROSS:
            yield (
                f"{owner} has a wheel that cannot roll: the cylinder of '{joint.child}' lies across the axis "
                f"of the joint '{joint.name}'; should it be turned by 90 degrees (1.5708 rad)?"
            )
        elif link.inertial is not None and _is_hardest_across(link, joint, link.collisions[0].geometry):
            yield (
                f"{owner} has a wheel whose moment of inertia is smallest about the axis on which it turns, "
                f"'{joint.child}': a disc has its largest there; are the axes exchanged?"
            )


def _is_hardest_across(link: Link, joint: Joint, shape: Cylinder) -> bool:
    """Return whether a disc turns more easily about the axis of its joint than about any other."""
    assert link.inertial is not None
    ixx, iyy, izz, ixy, ixz, iyz = link.inertial.inertia
    moments, axes = np.linalg.eigh(np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]]))
    turned = matrix_of(link.pose @ link.inertial.pose)[:, :3] @ axes
    along = int(np.argmax(np.abs(_axis(joint) @ turned)))
    is_flat = 2 * shape.radius > _NARROW * shape.length
    return bool(is_flat and moments[along] == moments[0] and moments[0] < _EASIER * moments[2])


def _of_track(owner: str, drive: _Wheeled, joints: dict[str, Joint], model: Model) -> Iterator[str]:
    pairs = [(joints[one], joints[two]) for one, two in zip(drive.left, drive.right, strict=False)]
    between = [dist(left.pose.position, right.pose.position) for left, right in pairs]
    if between and max(between) == 0 and len(set(drive.left) | set(drive.right)) > 1:
        left, right = (
            {one.pose.position for one in model.link(joint.child).collisions} for joint in pairs[0]
        )
        if left == right:
            yield f"{owner} has its left and right wheels in one place, that of '{pairs[0][0].child}'"
    if between and min(between) > 0 and not 1 / _NARROW <= drive.separation / min(between) <= _TRACK_TIMES:
        yield (
            f"{owner} has a wheel separation of {drive.separation:.3g} m, and its wheels are "
            f"{min(between):.3g} m apart"
        )
    aside = [left.pose.position[1] - right.pose.position[1] for left, right in pairs]
    if aside and all(offset < -apart / 2 for offset, apart in zip(aside, between, strict=True)):
        yield f"{owner} has its left wheels on the right, and its right ones on the left"
    sides = [[joints[name] for name in side if name in joints] for side in (drive.left, drive.right)]
    lowest = [min(side, key=_height) for side in sides if side]
    if len(lowest) == 2 and abs(_height(lowest[0]) - _height(lowest[1])) > drive.wheel_diameter / 2:
        heights = " and ".join(f"'{one.name}' at z {_height(one):.3g} m" for one in lowest)
        yield f"{owner} cannot stand on both sides: its lowest wheels are {heights}"


def _height(joint: Joint) -> float:
    return joint.pose.position[2]


def _axis(joint: Joint) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the axis of a joint in the frame of its model."""
    return np.asarray(matrix_of(joint.pose)[:, :3] @ np.array(joint.axis))
