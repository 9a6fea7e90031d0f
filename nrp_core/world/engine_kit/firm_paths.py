"""The paths of firm joints, computed for all joints of a scene in one compiled call."""

from __future__ import annotations

from math import atan2, exp, pi, sqrt
from typing import Any

from nrp_core._support.arrays import FloatArray
from nrp_core._support.jit import inlined, jit
from nrp_core.world.engine_kit.firm_kinds import FREE, POSITION

_ARRIVED = 1e-9
"""Distance (rad, m) and speed at which a path ends."""


@inlined
def _clip(value: float, lowest: float, highest: float) -> float:
    return min(max(value, lowest), highest)


@jit
def turn_from(
    orientation: FloatArray, now: tuple[float, float, float, float], paths: Any, turn: FloatArray
) -> None:
    """Compute the rotation vector from an orientation to that of a ball joint, along the joint's axes.

    It is as short as possible, or the other way round if the paths come from there.

    Args:
        orientation: x, y, z, w.
        now: the orientation of the ball joint, x, y, z, w.
        paths: the paths of its coordinates, shape ``(3,)``.
        turn: the result, rad, shape ``(3,)``.
    """
    ax, ay, az, aw = -orientation[0], -orientation[1], -orientation[2], orientation[3]
    bx, by, bz, bw = now
    x, y = aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx
    z, w = aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz
    half = sqrt(x * x + y * y + z * z)
    angle = 2.0 * atan2(half, abs(w))
    sign = 1.0 if w >= 0 else -1.0
    ahead = paths[0].path * x + paths[1].path * y + paths[2].path * z
    if not paths[0].fresh and sign * ahead < 0.0 and angle > pi / 2:
        angle -= 2.0 * pi
    times = sign * angle / half if half > 0.0 else 0.0
    turn[0], turn[1], turn[2] = times * x, times * y, times * z


@jit
def advance(
    step_s: float, time_constant_s: float, positions: FloatArray, velocities: FloatArray, paths: Any
) -> bool:
    """Advance all paths by a step, and return whether any of them has not arrived.

    Args:
        step_s: the physics step.
        time_constant_s: of the approach to a target.
        positions: of the joints now, where fresh paths begin, shape ``(n,)``.
        velocities: of the joints now, shape ``(n,)``.
        paths: the paths, shape ``(n,)``; their positions and speeds become those at the end of the step.
    """
    decay = exp(-step_s / time_constant_s)
    moving = False
    for i in range(len(paths)):
        each = paths[i]
        x = positions[i] if each.fresh else each.path
        v = velocities[i] if each.fresh else each.speed
        each.fresh = False
        target, limit = each.target, each.limit
        if each.kind != POSITION:
            each.path = positions[i]
            each.speed = _clip(target + (v - target) * decay, -limit, limit)
            there = abs(each.speed - target) < _ARRIVED
            if there:
                each.speed = target
        else:
            # a critically damped path (exact), or one given by points
            gap = x - target
            slope = v + gap / time_constant_s
            ahead = target + (gap + slope * step_s) * decay if each.smooth else target
            rate = (v - slope * step_s / time_constant_s) * decay if each.smooth else each.rate
            away = _clip(ahead - x, -limit * step_s, limit * step_s)
            if away != ahead - x:
                ahead, rate = x + away, away / step_s
            each.speed = _clip(rate, -limit, limit)
            each.path = ahead
            rests = abs(each.speed - each.rate) < _ARRIVED
            there = rests and abs(ahead - target) < _ARRIVED and each.rate == 0
            if there:
                each.path, each.speed = target, 0.0
        if not there and each.kind != FREE:
            moving = True
    return moving


@jit
def velocities_to(step_s: float, return_s: float, positions: FloatArray, paths: Any) -> None:
    """Compute the velocities that take joints back to their paths.

    Args:
        step_s: the physics step.
        return_s: time constant of the return.
        positions: of the joints at the start of the step, shape ``(n,)``.
        paths: the paths, shape ``(n,)``; ``wanted`` is set.
    """
    for i in range(len(paths)):
        each = paths[i]
        speed = each.speed
        if each.kind == POSITION:
            gap = each.path - positions[i] - step_s * each.speed
            fastest = sqrt(2.0 * each.braking * max(abs(gap), _ARRIVED))
            speed = each.speed + _clip(gap / (return_s + step_s), -fastest, fastest)
        down = min((each.lowest - positions[i]) / step_s, 0.0)
        up = max((each.highest - positions[i]) / step_s, 0.0)
        each.wanted = _clip(speed, max(-each.limit, down), min(each.limit, up))
