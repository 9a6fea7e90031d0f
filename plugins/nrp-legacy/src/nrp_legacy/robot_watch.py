"""Robots that fall over, fly away or are thrown at the start: a run in which one does is not complete.

Experiments of the platform have no criteria, so no other check reports that the robot failed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import acos, degrees, dist, hypot
from typing import Final

from nrp_core.clock import NS_PER_S, seconds
from nrp_core.experiment import Run, RunObserver
from nrp_core.findings import Code, Finding, Level
from nrp_core.world import Flight, Model, ModelMotion, Pose, Vector

FALLEN_DEG: Final = 60.0
"""A robot has fallen over if the axis that pointed up at the start is so far from it."""
FAR_M: Final = 2.0
"""A robot has fallen down or flown away if it is so far below or above its start."""
THROWN_M: Final = 0.5
"""A robot is thrown if it is so far above its start, or so far away without a drive, soon after it."""
_SOON_NS: Final = NS_PER_S // 2
_JUMP_M, _JUMP_DEG = 0.1, 30.0
"""A robot that moves so far in a step, and not with its velocity, was placed elsewhere."""
_UP: Final = (0.0, 0.0, 1.0)


@dataclass(slots=True)
class _Start:
    """Where a robot was placed, and its last motion."""

    pose: Pose
    t_ns: int
    last: ModelMotion


class RobotWatch(RunObserver[Run]):
    """Watches the robots of a run, and reports the first time that each is lost.

    A robot that is placed elsewhere, as by a service, starts anew.

    Args:
        run: a run that is about to start.
    """

    def __init__(self, run: Run) -> None:
        robots, scene, can = run.experiment.world.robots, run.plan.scene, run.world.capabilities
        falls = can.poses and can.dynamics and not can.own_scene and scene.gravity[2] < 0
        found = [model for model in scene.models if model.name in robots and _is_free(model)] if falls else []
        self._robots = {model.name: model for model in found}
        self._t_ns = 0
        self._starts: dict[str, _Start] = {}
        self._lost: dict[str, Finding] = {}
        self._restart(run)
        run.loop.hooks.after_reset.append(lambda _loop: self._restart(run))
        run.observers.append(self)
        run.reporters.append(self.findings)

    def findings(self) -> list[Finding]:
        """Return a finding for each robot that is lost."""
        return list(self._lost.values())

    def after_step(self, run: Run) -> None:
        now_ns = run.loop.now_ns
        if now_ns <= self._t_ns:  # an earlier state was restored
            self._restart(run)
            return
        step_s = seconds(now_ns - self._t_ns)
        for name, motion in self._motions(run):
            start = self._starts.get(name)
            if start is None or _is_placed(start.last, motion, step_s):
                self._starts[name] = _Start(motion.pose, now_ns, motion)
                continue
            start.last = motion
            what = self._what(name, start, motion.pose, now_ns - start.t_ns)
            if what and name not in self._lost:
                message = f"the robot '{name}' {what} at {seconds(now_ns):g} s"
                self._lost[name] = Finding(Code.NRP382, message, Level.WARNING, subject=name)
        self._t_ns = now_ns

    def _restart(self, run: Run) -> None:
        self._t_ns = run.loop.now_ns
        self._starts = {name: _Start(one.pose, self._t_ns, one) for name, one in self._motions(run)}
        self._lost = {}

    def _motions(self, run: Run) -> Iterator[tuple[str, ModelMotion]]:
        for model in run.world.scene.models:
            if model.name in self._robots:
                yield model.name, run.world.model_motion(model.name)

    def _what(self, name: str, start: _Start, pose: Pose, since_ns: int) -> str:
        """Return a description of a robot's failure; empty if its pose is normal."""
        (x0, y0, z0), (x, y, z) = start.pose.position, pose.position
        if since_ns <= _SOON_NS and z - z0 > THROWN_M:
            return f"was thrown {z - z0:.2f} m up"
        away = hypot(x - x0, y - y0)
        if since_ns <= _SOON_NS and away > THROWN_M and not self._robots[name].drives:
            return f"was thrown {away:.2f} m away"
        if abs(z - z0) > FAR_M:
            return f"flew {z - z0:.2f} m up" if z > z0 else f"fell {z0 - z:.2f} m down"
        tilt = _angle_deg(_UP, pose.rotate(start.pose.inverse().rotate(_UP)))
        return f"fell over, {tilt:.0f}° from its start," if tilt > FALLEN_DEG else ""


def _is_free(model: Model) -> bool:
    """Return whether a robot can fall: it is not fixed, and does not fly."""
    flies = any(isinstance(drive, Flight) for drive in model.drives)
    return not (model.static or flies or any(joint.parent == "world" for joint in model.joints))


def _is_placed(before: ModelMotion, now: ModelMotion, step_s: float) -> bool:
    """Return whether a model was placed elsewhere in a step, and did not move there."""
    speed = max(hypot(*before.linear), hypot(*now.linear))
    turning = max(hypot(*before.angular), hypot(*now.angular))
    moved = dist(before.pose.position, now.pose.position)
    turned = _angle_deg(before.pose.rotate(_UP), now.pose.rotate(_UP))
    return moved > _JUMP_M + 2 * speed * step_s or turned > _JUMP_DEG + 2 * degrees(turning) * step_s


def _angle_deg(a: Vector, b: Vector) -> float:
    return degrees(acos(max(-1.0, min(1.0, sum(p * q for p, q in zip(a, b, strict=True))))))
