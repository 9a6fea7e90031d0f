"""States that wait: until a condition holds, and while one holds for the messages of a topic."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nrp_legacy.shims.graph import Graph, absolute
from nrp_legacy.shims.smach import State
from nrp_legacy.shims.steps import Task

MONITORED = ("valid", "invalid", "preempted")


class PollingState(State):
    """A state that checks once a step whether it may continue.

    Args:
        is_over: called with the user data.
        graph: the graph of the run.
    """

    def __init__(self, graph: Graph, is_over: Callable[[Any], bool]) -> None:
        super().__init__(MONITORED)
        self._graph, self._is_over = graph, is_over

    def execute(self, userdata: Any) -> str:
        self._entered()
        while not self._is_over(userdata):
            if self.preempt_requested():
                return "preempted"
            task = Task.here()
            if task is None:
                return "valid"
            task.wait_until(0)
        return "invalid"

    def _entered(self) -> None:
        """Begin to wait."""


class MonitorState(PollingState):
    """Waits while a condition holds for the messages of a topic.

    Args:
        topic: the topic.
        msg_type: its type.
        cond_cb: called with the user data and a message; True: keep waiting.
        max_checks: number of messages after which it stops waiting; the outcome is then ``valid``.
    """

    def __init__(
        self,
        graph: Graph,
        topic: str,
        msg_type: Any,
        cond_cb: Callable[..., bool],
        max_checks: int = -1,
        **_keys: Any,
    ) -> None:
        super().__init__(graph, lambda _userdata: False)
        self._topic, self._type, self._condition, self._checks = (
            absolute(topic),
            msg_type,
            cond_cb,
            max_checks,
        )
        graph.want(self._topic, msg_type)

    @property
    def is_limited(self) -> bool:
        """Whether it stops waiting after a number of messages."""
        return self._checks > 0

    def execute(self, userdata: Any) -> str:
        came: list[Any] = []
        listener = self._graph.listen(self._topic, self._type, came.append)
        self._left = self._checks
        self._is_over = lambda data: self._met(came, data)
        try:
            outcome = super().execute(userdata)
        finally:
            self._graph.forget(listener)
        return "valid" if outcome == "invalid" and self._left == 0 else outcome

    def _met(self, came: list[Any], userdata: Any) -> bool:
        messages, came[:] = list(came), []
        for message in messages:
            if not self._condition(userdata, message):
                return True
            self._left -= 1
            if self._left == 0:
                return True
        return False
