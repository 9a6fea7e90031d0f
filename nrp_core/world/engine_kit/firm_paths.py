"""The paths of firm joints, computed for all joints of a scene in one compiled call."""

from __future__ import annotations

from math import exp, sqrt

from nrp_core._support.arrays import BoolArray, FloatArray, IntArray
from nrp_core._support.jit import inlined, jit
from nrp_core.world.engine_kit.firm_kinds import FREE, POSITION

_ARRIVED = 1e-9
"""Distance (rad, m) and speed at which a path ends."""


@inlined
def _clipped(value: float, lowest: float, highest: float) -> float:
    return min(max(value, lowest), highest)


@jit
def advance(
    step_s: float,
    time_constant_s: float,
    positions: FloatArray,
    velocities: FloatArray,
    limits: FloatArray,
    kinds: IntArray,
    targets: FloatArray,
    rates: FloatArray,
    smooth: BoolArray,
    fresh: BoolArray,
    paths: FloatArray,
    speeds: FloatArray,
) -> bool:
    """Advance all paths by a step, and return whether any of them has not arrived; shapes ``(n,)``.

    Args:
        step_s: the physics step.
        time_constant_s: of the approach to a target.
        positions: of the joints now, where fresh paths begin.
        velocities: of the joints now.
        limits: the largest speeds.
        kinds: what each joint follows.
        targets: the target of each joint.
        rates: the speed there if its path is given by points.
        smooth: whether its path is not given by points.
        fresh: whether its path begins now; all are reset.
        paths: the position of each path; it becomes that at the end of the step.
        speeds: the same of the velocity.
    """
    decay = exp(-step_s / time_constant_s)
    moving = False
    for i in range(len(kinds)):
        x = positions[i] if fresh[i] else paths[i]
        v = velocities[i] if fresh[i] else speeds[i]
        fresh[i] = False
        target, limit = targets[i], limits[i]
        if kinds[i] != POSITION:
            paths[i] = positions[i]
            speeds[i] = _clipped(target + (v - target) * decay, -limit, limit)
            there = abs(speeds[i] - target) < _ARRIVED
            if there:
                speeds[i] = target
        else:
            # a critically damped path (exact), or one given by points
            gap = x - target
            slope = v + gap / time_constant_s
            ahead = target + (gap + slope * step_s) * decay if smooth[i] else target
            rate = (v - slope * step_s / time_constant_s) * decay if smooth[i] else rates[i]
            away = _clipped(ahead - x, -limit * step_s, limit * step_s)
            if away != ahead - x:
                ahead, rate = x + away, away / step_s
            speeds[i] = _clipped(rate, -limit, limit)
            paths[i] = ahead
            rests = abs(speeds[i] - rates[i]) < _ARRIVED
            there = rests and abs(ahead - target) < _ARRIVED and rates[i] == 0
            if there:
                paths[i], speeds[i] = target, 0.0
        if not there and kinds[i] != FREE:
            moving = True
    return moving


@jit
def velocities_to(
    step_s: float,
    return_s: float,
    positions: FloatArray,
    braking: FloatArray,
    lowest: FloatArray,
    highest: FloatArray,
    limits: FloatArray,
    kinds: IntArray,
    paths: FloatArray,
    speeds: FloatArray,
    wanted: FloatArray,
) -> None:
    """Fill ``wanted`` with the velocities that take joints back to their paths; shapes ``(n,)``.

    Args:
        step_s: the physics step.
        return_s: time constant of the return.
        positions: of the joints at the start of the step.
        braking: the accelerations with which they can brake.
        lowest: the lower ends of their ranges.
        highest: the upper ones.
        limits: the largest speeds.
        kinds: what each joint follows.
        paths: the position of each path at the end of the step.
        speeds: the velocity of each path then.
        wanted: the result.
    """
    for i in range(len(kinds)):
        speed = speeds[i]
        if kinds[i] == POSITION:
            gap = paths[i] - positions[i] - step_s * speeds[i]
            fastest = sqrt(2.0 * braking[i] * max(abs(gap), _ARRIVED))
            speed = speeds[i] + _clipped(gap / (return_s + step_s), -fastest, fastest)
        down = min((lowest[i] - positions[i]) / step_s, 0.0)
        up = max((highest[i] - positions[i]) / step_s, 0.0)
        wanted[i] = _clipped(speed, max(-limits[i], down), min(limits[i], up))
