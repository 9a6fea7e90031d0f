"""Times and durations of ROS 1, which are messages as well, and the topic ``/clock``."""

from __future__ import annotations

from functools import total_ordering
from typing import Any, Final

from nrp_core.cle.loop import ClosedLoop
from nrp_core.clock import NS_PER_S, from_seconds
from nrp_core.dsl import message_type
from nrp_core.experiment import Run
from nrp_core.messages import base
from nrp_core.world import World

CLOCK: Final = "/clock"
_TYPE: Any = message_type("rosgraph_msgs/Clock")


def declare_clock(world: World) -> None:
    """Add the topic to a world, unless it has it."""
    if CLOCK not in world.topics:
        world.declare(CLOCK, _TYPE)


def publish_clock(run: Run) -> None:
    """Publish the simulated time before the functions of each step, if it has subscribers."""
    if CLOCK not in run.world.topics:
        return
    publication = run.world.advertise(CLOCK)

    def tick(loop: ClosedLoop) -> None:
        publication.publish(_TYPE(base.Time(*divmod(loop.now_ns, NS_PER_S))))

    run.loop.hooks.before_functions.insert(0, tick)


@total_ordering
class Span:
    """The common part of times and durations; both can be compared with numbers of seconds."""

    sec: int
    nanosec: int

    def __init__(self, secs: float = 0, nsecs: int = 0) -> None:
        """Create it from seconds, possibly fractional, and additional nanoseconds."""
        self.sec, self.nanosec = divmod(from_seconds(secs) + nsecs, NS_PER_S)

    @classmethod
    def from_sec(cls, seconds: float) -> Any:
        """Return one from seconds."""
        return cls(seconds)

    @property
    def ns(self) -> int:
        """The total in nanoseconds."""
        return self.sec * NS_PER_S + self.nanosec

    def to_sec(self) -> float:
        """Return seconds."""
        return self.ns / NS_PER_S

    def to_nsec(self) -> int:
        """Return nanoseconds."""
        return self.ns

    def is_zero(self) -> bool:
        """Return whether it is 0."""
        return self.ns == 0

    def __float__(self) -> float:
        return self.to_sec()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, int | float | Span) and self.ns == _ns(other)

    def __lt__(self, other: Any) -> bool:
        return self.ns < _ns(other)

    def __hash__(self) -> int:
        return hash(self.ns)

    def __add__(self, other: Any) -> Any:
        kind = type(other) if isinstance(other, Span) and not isinstance(self, Time) else type(self)
        return kind(0, self.ns + _ns(other))

    def __sub__(self, other: Any) -> Any:
        both_times = isinstance(self, Time) and isinstance(other, Time)
        return (Duration if both_times else type(self))(0, self.ns - _ns(other))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.to_sec():g} s)"


class Duration(Span, base.Duration):
    """A duration."""


class Time(Span, base.Time):
    """A simulated time."""


def _ns(value: Any) -> int:
    return value.ns if isinstance(value, Span) else from_seconds(float(value))
