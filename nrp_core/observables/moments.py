"""The moments between two steps of the loop at which events and criteria can change."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from operator import itemgetter
from typing import Protocol

from nrp_core.observables.positions import GroundPositions, Poses
from nrp_core.world.topics import Direction, Stamped, Subscription
from nrp_core.world.world import World


class Watched(Protocol):
    """A condition of an event, or a criterion."""

    @property
    def hears(self) -> bool:
        """Whether messages change it."""

    def news(self) -> Iterable[int]:
        """Return the times of the messages that came since the last call, ns."""

    def unchanged_ns(self, now_ns: int) -> int | None:
        """Return the time for which it cannot change, ns; None: it changes only with messages or steps."""

    def look(self, now_ns: int) -> None:
        """Store the values read at a physics step between two steps of the loop, for that moment."""


class LastMessage:
    """The last message on a topic at a moment; messages that come later are not seen yet.

    Args:
        subscription: the subscription, without a depth.

    Attributes:
        unchanged_ns: for how long it surely stays, ns: 0 for a value that the world has at each physics step,
            else None.
        last: the message that was read last.
    """

    def __init__(self, subscription: Subscription) -> None:
        self._subscription, topic = subscription, subscription.topic
        at_each_step = topic.rate_hz is None and topic.direction is Direction.OUT
        self.unchanged_ns = 0 if at_each_step else None
        self._coming: deque[Stamped] = deque()
        self.last: Stamped | None = None

    @property
    def untaken_ns(self) -> Sequence[int]:
        """The times of the messages that were not received yet, ns."""
        return (
            [stamped.t_ns for stamped in self._subscription.messages] if self._subscription.has_news else ()
        )

    def news(self) -> Sequence[int]:
        """Receive the messages that came since the last call, and return their times, ns."""
        new = self._subscription.take()
        self._coming.extend(new)
        return [stamped.t_ns for stamped in new]

    def at(self, now_ns: int) -> Stamped | None:
        """Return the last message at a moment, which is not before the previous one; None: none came."""
        self.news()
        while self._coming and self._coming[0].t_ns <= now_ns:
            self.last = self._coming.popleft()
        return self.last

    def restore(self) -> None:
        """Return to the messages of the subscription, at time 0 or after it was restored."""
        self._coming.clear()
        self.last = None if self._subscription.has_news else self._subscription.latest


class BetweenSteps:
    """Finds the moments between two steps, and the positions of bodies at each.

    It looks at bodies at the physics steps at which a distance may pass its limit, and at no others; see
    :func:`~nrp_core.world.physics_observer.unchanged_ns`.

    Args:
        world: the world.
        where: the positions, which :meth:`moments` sets to those of each moment.

    Attributes:
        deadline_ns: when it looks next, ns.
    """

    def __init__(self, world: World, where: GroundPositions) -> None:
        self._where = where
        self._due_ns: list[tuple[int, Watched]] = []
        self._looks: list[tuple[int, Watched]] = []
        self._poses: list[tuple[int, Poses]] = []
        self.deadline_ns: int | None = None
        world.add_physics_observer(self)

    def plan(self, now_ns: int, watched: Iterable[Watched]) -> None:
        """Plan the looks after a step to ``now_ns``."""
        self._looks.clear()
        self._poses = [(now_ns, self._where.poses)]
        self._due_ns = []
        for each in watched:  # in each step: no comprehension, which is one more call
            stays_ns = each.unchanged_ns(now_ns)
            if stays_ns is not None:
                self._due_ns.append((now_ns + stays_ns, each))
        self.deadline_ns = min(map(itemgetter(0), self._due_ns), default=None)

    @property
    def has_looked(self) -> bool:
        """Whether it has looked since the last plan."""
        return bool(self._looks)

    def rest(self) -> None:
        """Plan no looks until the next step, because no condition can change before it."""
        self.deadline_ns = None

    def observe(self, now_ns: int) -> None:
        """Look at the bodies at a physics step."""
        self._where.refresh()
        self._poses.append((now_ns, self._where.poses))
        for i, (due_ns, each) in enumerate(self._due_ns):
            if due_ns <= now_ns:
                each.look(now_ns)
                self._looks += [(now_ns, each), *((t_ns, each) for t_ns in each.news())]
                self._due_ns[i] = now_ns + (each.unchanged_ns(now_ns) or 0), each
        self.deadline_ns = min(map(itemgetter(0), self._due_ns))

    def moments(self, now_ns: int, watched: Iterable[Watched]) -> Iterator[tuple[int, list[Watched]]]:
        """Yield the moments since the last step and before ``now_ns``, and what may change at each."""
        changes = self._looks
        for each in watched:
            if each.hears:
                changes = changes + [(t_ns, each) for t_ns in each.news()]
        if not changes:
            return  # as in most steps
        changes = [change for change in changes if change[0] < now_ns]
        present = self._where.poses
        for t_ns in sorted({t_ns for t_ns, _ in changes}):
            while len(self._poses) > 1 and self._poses[1][0] <= t_ns:
                del self._poses[0]
            self._where.poses = self._poses[0][1] if self._poses else present
            yield t_ns, [each for at_ns, each in changes if at_ns == t_ns]
        self._where.poses = present
