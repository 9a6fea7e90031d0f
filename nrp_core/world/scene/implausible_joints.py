"""Implausible values of joints and controllers: joints that never move, or that move by themselves."""

from __future__ import annotations

from collections.abc import Iterator
from math import dist, inf, isfinite, pi, sqrt
from typing import Final

import numpy as np

from nrp_core.world.rigid import matrix_of
from nrp_core.world.scene.devices import ControllerKind, JointController, Pid
from nrp_core.world.scene.model import Joint, Model
from nrp_core.world.scene.posture import Posture, start_positions

_TURNS_RAD: Final = 4 * pi
"""Two turns: joints of robots with limits turn less."""
_DEGREES: Final = 720.0
"""More than two turns in degrees; larger limits mean "unlimited"."""
_LONGEST_M: Final = 7.0
"""A travel beyond the limits of a revolute joint, which many files have at a prismatic one, and:"""
_ENDLESS_M: Final = 100.0
"""one that means "unlimited", as do limits on both sides of 0."""
_SIZES: Final = 20.0
"""How many times longer than the largest link a travel is that is not meant in metres."""
_SLOWEST_RAD_S: Final = 0.02
"""One degree a second: a fifth of the speed of the second hand of a clock, 0.1 rad/s."""
_SLOWEST_M_S: Final = 1e-3
_SMALLEST: Final = 1e-4
"""An error, rad or m, that no encoder of a robot resolves."""
_LONGEST_S: Final = 20.0
"""A time constant with which no joint of a robot approaches its target."""
_FIRM: Final = 100.0
"""How many times stiffer than its controller a spring is that no command moves by more than a hundredth."""
_WEAKEST: Final = 1e-3
"""The least effort of a joint as a share of the one that carries its link."""
_WEAKEST_GAIN: Final = 1e-2
"""The same share for the effort of a gain, which is chosen and not a motor's."""
_SAGGING: Final = 0.5
"""The effort of a joint, as a share of what holds it, with which it falls beyond doubt."""
_GRAVITY: Final = 9.81
_UPRIGHT: Final = 0.7
"""The cosine of 45 degrees: gravity does not load an axis that is steeper."""


def of_joints(model: Model) -> Iterator[str]:
    """Yield each implausible value of the joints of a robot as a sentence."""
    joints = {joint.name: joint for joint in model.joints if joint.kind != "fixed"}
    for joint in joints.values():
        owner = f"the joint '{joint.name}' of '{model.name}'"
        yield from _of_limits(owner, joint)
        led = joint.mimic
        if led is not None and led.multiplier == 0:
            yield f"{owner} mimics '{led.leader}' by a factor of 0: it stays at {led.offset:g}"
        if joint.kind != "prismatic" and joint.stiffness > 0 and abs(joint.rest) > _TURNS_RAD:
            yield f"the spring of {owner} rests at {joint.rest:g} rad, more than two turns; is it in degrees?"
        for value, what in ((joint.damping, "damping"), (joint.friction, "friction")):
            if value < 0:
                yield f"{owner} has a {what} of {value:g}, which speeds it up instead of slowing it down"
    for controller in model.controllers:
        if controller.joint in joints:
            owner, joint = f"the joint '{controller.joint}' of '{model.name}'", joints[controller.joint]
            yield from _of_controller(owner, joint, controller)
            yield from _of_strength(owner, joint, controller, model)
    yield from _of_double_control(model)


def of_slides(model: Model, size_m: float) -> Iterator[str]:
    """Yield that a joint slides much farther than its robot, whose largest link has a size, is long."""
    for joint in model.joints:
        is_slide = joint.kind == "prismatic" and joint.lower >= 0
        if is_slide and max(_LONGEST_M, _SIZES * size_m) < joint.upper < _ENDLESS_M:
            yield (
                f"the joint '{joint.name}' of '{model.name}' slides from {joint.lower:g} to {joint.upper:g} "
                f"m, and the largest link is {size_m:.2g} m large; is that meant in mm?"
            )


def _of_limits(owner: str, joint: Joint) -> Iterator[str]:
    limits = [limit for limit in (joint.lower, joint.upper) if isfinite(limit)]
    widest = max(map(abs, limits), default=0.0)
    if joint.kind == "revolute" and _TURNS_RAD < widest <= _DEGREES:
        shown = " to ".join(f"{limit:g}" for limit in limits)
        yield f"{owner} has limits of {shown} rad, more than two turns; are they meant in degrees?"


def _of_controller(owner: str, joint: Joint, controller: JointController) -> Iterator[str]:
    zero = [what for what, limit in (("effort", joint.effort), ("velocity", joint.velocity)) if limit == 0]
    if zero:
        yield f"{owner} has a controller, and its limit of {' and '.join(zero)} is 0: it never moves"
    pace, unit = (_SLOWEST_M_S, "m/s") if joint.kind == "prismatic" else (_SLOWEST_RAD_S, "rad/s")
    if 0 < joint.velocity < pace:
        yield f"{owner} has a controller and moves at most {joint.velocity:g} {unit}: is that meant?"
    gains = controller.gains
    if controller.kind != "effort" and gains is not None:
        yield from _of_gains(owner, joint, controller.kind, gains)
    if joint.friction > 0 and joint.friction >= _strongest(joint, controller):
        yield (
            f"{owner} has a friction of {joint.friction:g}, and its controller exerts at most "
            f"{_strongest(joint, controller):g}: no command moves it"
        )
    if controller.kind == "position" and gains is not None and 0 < _FIRM * gains.p < joint.stiffness:
        yield (
            f"the spring of {owner} has a stiffness of {joint.stiffness:g}, and its controller a gain of "
            f"{gains.p:g}: commands hardly move it"
        )
    start = controller.initial
    if controller.kind == "position" and start is not None and not joint.lower <= start <= joint.upper:
        yield (
            f"the controller of {owner} starts with {start:g}, outside the limits of the joint of "
            f"{joint.lower:g} to {joint.upper:g}"
        )


def _of_gains(owner: str, joint: Joint, kind: ControllerKind, gains: Pid) -> Iterator[str]:
    if not any((gains.p, gains.i, gains.d)):
        yield f"the controller of {owner} has no gain: its commands move nothing"
    elif kind != "position":
        return
    elif not (gains.p or gains.i):
        yield f"the position controller of {owner} has the gains p 0 and i 0: it never nears its target"
    elif 0 < joint.effort < gains.p * _SMALLEST:
        yield (
            f"the controller of {owner} has a gain of {gains.p:g}: it exerts the largest effort, "
            f"{joint.effort:g}, at an error of {joint.effort / gains.p:.2g}"
        )
    elif gains.p > 0 and (time_s := (joint.damping + gains.d) / gains.p) > _LONGEST_S:
        yield (
            f"the controller of {owner} has a gain of {gains.p:g}, and the damping is "
            f"{joint.damping + gains.d:g}: it nears its target with a time constant of {time_s:.3g} s"
        )


def _strongest(joint: Joint, controller: JointController) -> float:
    """Return the largest force or torque that commands within a joint's limits lead to; inf if unknown."""
    gains, span = controller.gains, joint.upper - joint.lower
    is_spring = controller.kind == "position" and gains is not None and gains.i == 0
    return min(joint.effort, gains.p * span if is_spring and gains is not None else inf)


def _of_strength(owner: str, joint: Joint, controller: JointController, model: Model) -> Iterator[str]:
    """Yield that a joint, or the gain of its controller, is too weak for its own link."""
    inertial = model.link(joint.child).inertial
    upward = abs(float((matrix_of(joint.pose)[:, :3] @ np.array(joint.axis))[2]))
    if inertial is None or joint.kind != "revolute" or not joint.effort > 0 or upward > _UPRIGHT:
        return
    away_m = dist(joint.pose.position, (model.link(joint.child).pose @ inertial.pose).position)
    arm_m = max(away_m, sqrt(max(inertial.inertia[:3]) / inertial.mass))
    needed = inertial.mass * _GRAVITY * arm_m
    if joint.effort < _WEAKEST * needed:
        yield (
            f"{owner} has a controller and an effort of at most {joint.effort:g} N m: its link of "
            f"{inertial.mass:.3g} kg needs {needed:.2g} N m to be held; is that meant?"
        )
    elif (
        (strongest := _strongest(joint, controller)) < _WEAKEST_GAIN * needed
        and controller.gains
        and strongest > 0
    ):
        yield (
            f"the controller of {owner} has a gain of {controller.gains.p:g}: even at the largest error it "
            f"exerts {strongest:.2g} N m, and its link of {inertial.mass:.3g} kg needs {needed:.2g} N m to "
            "be held"
        )
    elif joint.effort < _SAGGING * (load := _load(joint, model)):
        yield (
            f"{owner} has a controller and an effort of at most {joint.effort:g} N m: what it carries needs "
            f"{load:.2g} N m to be held where it starts"
        )


def _load(joint: Joint, model: Model) -> float:
    """Return the torque about a joint that holds what is beyond it where it starts, N m.

    It is 0 where something else may hold it: a spring, or other joints of a loop.
    """
    beyond, count = {joint.child}, 0
    while count != len(beyond):
        count = len(beyond)
        beyond |= {one.child for one in model.joints if one.parent in beyond}
    if joint.stiffness or model.loops or joint.parent in beyond:
        return 0.0
    posture = Posture(model, start_positions(model))
    placed = [(posture.of(name) @ model.link(name).pose, model.link(name).inertial) for name in beyond]
    parts = [(one.mass, (pose @ one.pose).position) for pose, one in placed if one is not None]
    here = posture.of(joint.parent) @ joint.pose
    down = matrix_of(model.pose)[:, :3].T @ (0.0, 0.0, -_GRAVITY)
    axis = matrix_of(here)[:, :3] @ np.array(joint.axis)
    pull = sum((one * np.cross(np.subtract(place, here.position), down) for one, place in parts), np.zeros(3))
    return abs(float(axis @ pull))


def _of_double_control(model: Model) -> Iterator[str]:
    """Yield the joints with two controllers of one kind; the last command counts, whichever it comes from."""
    topics: dict[tuple[str, str], list[str]] = {}
    for controller in model.controllers:
        topics.setdefault((controller.joint, controller.kind), []).append(controller.topic)
    for (joint, kind), several in topics.items():
        if len(set(several)) > 1:
            yield (
                f"the joint '{joint}' of '{model.name}' has {len(several)} {kind} controllers, on "
                f"{' and '.join(several)}: is one of them for another joint?"
            )
