"""The path of a joint through points in time, interpolated as ROS's trajectory controllers do."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace

from nrp_core.clock import seconds


@dataclass(frozen=True, slots=True)
class Knot:
    """Position of a joint at a time; velocity and acceleration if they are given.

    Args:
        t_ns: the time.
        position: rad or m.
        velocity: rad/s or m/s.
        acceleration: rad/s^2 or m/s^2.
    """

    t_ns: int
    position: float
    velocity: float | None = None
    acceleration: float | None = None


@dataclass(frozen=True, slots=True)
class JointPath:
    """A path from its first knot to its last, where the joint stays.

    Between two knots it is a line; a cubic if both have velocities; a quintic if both also have
    accelerations. See http://wiki.ros.org/joint_trajectory_controller/UnderstandingTrajectoryReplacement.

    Args:
        knots: the knots in order of time, at least one.
        before: the path until the first knot; None: undefined until then.
    """

    knots: tuple[Knot, ...]
    before: JointPath | None = None

    def at(self, t_ns: int) -> Knot | None:
        """Return position, velocity and acceleration at a time; None before the path begins."""
        following = bisect_right(self.knots, t_ns, key=lambda knot: knot.t_ns)
        if not following:
            return None if self.before is None else self.before.at(t_ns)
        if following == len(self.knots):
            return Knot(t_ns, self.knots[-1].position, 0.0, 0.0)
        start, end = self.knots[following - 1 : following + 1]
        elapsed_s = seconds(t_ns - start.t_ns)
        position = velocity = acceleration = 0.0
        for coefficient in reversed(_coefficients(start, end)):  # Horner's scheme, for the derivatives, too
            acceleration = acceleration * elapsed_s + 2 * velocity
            velocity = velocity * elapsed_s + position
            position = position * elapsed_s + coefficient
        return Knot(t_ns, position, velocity, acceleration)

    def is_over(self, t_ns: int) -> bool:
        """Whether its last knot is reached."""
        return t_ns >= self.knots[-1].t_ns

    def since(self, t_ns: int) -> JointPath:
        """Return the path without earlier paths, if it has begun."""
        if self.before is None:
            return self
        return replace(self, before=None if t_ns >= self.knots[0].t_ns else self.before.since(t_ns))

    def until(self, t_ns: int) -> JointPath | None:
        """Return the path without the paths that would begin at a time or later."""
        if self.knots[0].t_ns < t_ns:
            return self
        return None if self.before is None else self.before.until(t_ns)


def _coefficients(start: Knot, end: Knot) -> Sequence[float]:
    """Return the coefficients of the polynomial in the seconds after ``start`` that leads to ``end``."""
    t = seconds(end.t_ns - start.t_ns)
    x, v0, v1 = end.position - start.position, start.velocity, end.velocity
    if v0 is None or v1 is None:
        return start.position, x / t
    a0, a1 = start.acceleration, end.acceleration
    if a0 is None or a1 is None:
        return start.position, v0, (3 * x / t - 2 * v0 - v1) / t, (v0 + v1 - 2 * x / t) / t**2
    return (
        start.position,
        v0,
        a0 / 2,
        (20 * x - (8 * v1 + 12 * v0) * t - (3 * a0 - a1) * t**2) / (2 * t**3),
        (-30 * x + (14 * v1 + 16 * v0) * t + (3 * a0 - 2 * a1) * t**2) / (2 * t**4),
        (12 * x - 6 * (v1 + v0) * t - (a0 - a1) * t**2) / (2 * t**5),
    )
