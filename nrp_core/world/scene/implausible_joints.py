"""Implausible values of joints and controllers: joints that never move, or that move by themselves."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite, pi
from typing import Final

from nrp_core.world.scene.acting import JointController
from nrp_core.world.scene.model import Joint, Model

_TURNS_RAD: Final = 4 * pi
"""Two turns: joints of robots with limits turn less."""
_DEGREES: Final = 720.0
"""More than two turns in degrees; larger limits mean "unlimited"."""
_SLOWEST_RAD_S: Final = 0.02
"""One degree a second: a fifth of the speed of the second hand of a clock, 0.1 rad/s."""
_SLOWEST_M_S: Final = 1e-3
_SMALLEST: Final = 1e-4
"""An error, rad or m, that no encoder of a robot resolves."""


def of_joints(model: Model) -> Iterator[str]:
    """Yield each implausible value of the joints of a robot as a sentence."""
    joints = {joint.name: joint for joint in model.joints if joint.kind != "fixed"}
    for joint in joints.values():
        owner = f"the joint '{joint.name}' of '{model.name}'"
        yield from _of_limits(owner, joint)
        if joint.kind != "prismatic" and joint.stiffness > 0 and abs(joint.rest) > _TURNS_RAD:
            yield f"the spring of {owner} rests at {joint.rest:g} rad, more than two turns; is it in degrees?"
        for value, what in ((joint.damping, "damping"), (joint.friction, "friction")):
            if value < 0:
                yield f"{owner} has a {what} of {value:g}, which speeds it up instead of slowing it down"
    for controller in model.controllers:
        if controller.joint in joints:
            owner = f"the joint '{controller.joint}' of '{model.name}'"
            yield from _of_controller(owner, joints[controller.joint], controller)


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
    if controller.kind != "effort" and gains is not None and not any((gains.p, gains.i, gains.d)):
        yield f"the controller of {owner} has no gain: its commands move nothing"
    elif controller.kind == "position" and gains is not None and 0 < joint.effort < gains.p * _SMALLEST:
        yield (
            f"the controller of {owner} has a gain of {gains.p:g}: it exerts the largest effort, "
            f"{joint.effort:g}, at an error of {joint.effort / gains.p:.2g}"
        )
    start = controller.initial
    if controller.kind == "position" and start is not None and not joint.lower <= start <= joint.upper:
        yield (
            f"the controller of {owner} starts with {start:g}, outside the limits of the joint of "
            f"{joint.lower:g} to {joint.upper:g}"
        )
