"""Commands that act some time after they were published, as over a network or in a slow actuator."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from copy import deepcopy
from typing import Any, NamedTuple

from nrp_core.clock import from_seconds
from nrp_core.world.part import Part, PartProxy


class _Pending(NamedTuple):
    due_ns: int
    topic: str
    message: Any


class DelayedPart(PartProxy):
    """A part that gets its commands late, at the first physics step after their delay.

    Args:
        inner: the part.
        delays: the delay of each delayed topic, s; messages on others arrive at once.
    """

    has_deadlines = True

    def __init__(self, inner: Part, delays: Mapping[str, float]) -> None:
        super().__init__(inner)
        self._delays_ns = {topic: from_seconds(delay) for topic, delay in delays.items()}
        self._pending: dict[str, deque[_Pending]] = {topic: deque() for topic in delays}

    @property
    def deadline_ns(self) -> int | None:  # type: ignore[override]
        waiting = [queue[0].due_ns for queue in self._pending.values() if queue]
        own_ns = self._inner_deadline_ns
        return min(waiting if own_ns is None else (*waiting, own_ns), default=None)

    @property
    def _inner_deadline_ns(self) -> int | None:
        return self.inner.deadline_ns if self.inner.has_deadlines else None

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        if topic not in self._delays_ns:
            self.inner.write(topic, message, now_ns)
            return
        due_ns = now_ns + self._delays_ns[topic]
        self._pending[topic].append(_Pending(due_ns, topic, deepcopy(message)))  # the sender may reuse it

    def at_deadline(self, now_ns: int) -> None:
        due = [
            queue.popleft()
            for queue in self._pending.values()
            for _ in range(sum(one.due_ns <= now_ns for one in queue))
        ]
        for one in sorted(due, key=lambda one: one.due_ns):
            self.inner.write(one.topic, one.message, now_ns)
        inner_ns = self._inner_deadline_ns
        if inner_ns is not None and inner_ns <= now_ns:
            self.inner.at_deadline(now_ns)

    def reset(self) -> None:
        for queue in self._pending.values():
            queue.clear()
        self.inner.reset()

    def save(self) -> object:
        return [one for queue in self._pending.values() for one in queue], self.inner.save()

    def restore(self, saved: Any) -> None:
        pending, inner = saved
        for queue in self._pending.values():
            queue.clear()
        for one in pending:
            self._pending[one.topic].append(one)
        self.inner.restore(inner)


def with_delays(part: Part, delays: Mapping[str, float]) -> Part:
    """Return a part with the delays of its topics, s, among those of a scene."""
    own = {topic.name: delays[topic.name] for topic in part.topics if topic.name in delays}
    return DelayedPart(part, own) if own else part
