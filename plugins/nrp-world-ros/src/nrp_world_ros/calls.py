"""The services of a world in ROS, such as ``/gazebo/set_model_state``, with the names of Gazebo.

ROS calls in its own threads; requests wait until the world is between two steps.
"""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any

from nrp_core.errors import NrpError, TopicError
from nrp_core.world import Code, Findings, World

from nrp_world_ros.node import Node

PATIENCE_S = 30.0
"""Maximum waiting time of a caller, s."""


@dataclass(frozen=True, slots=True)
class _Call:
    """A request from ROS, and the place for its answer."""

    service: str
    kind: str
    request: bytes
    answer: Future[memoryview]


class Calls:
    """Answers calls from ROS on request.

    Args:
        world: the world that answers them.
        node: in ROS.
        warnings: are told of failed calls in a ROS that does not tell the caller.

    Attributes:
        services: their names.
    """

    def __init__(self, world: World, node: Node, warnings: Findings) -> None:
        self._world, self._node, self._codec = world, node, node.codec
        self._warnings = warnings
        self._waiting: SimpleQueue[_Call] = SimpleQueue()
        self.services: list[str] = []

    def offer(self) -> None:
        """Offer all services of the world in ROS."""
        for info in self._world.topics.values():
            if info.response is not None:
                request, response = map(self._codec.name, (info.type, info.response))
                self._node.serve(info.name, request, response, partial(self._ask, info.name, request))
                self.services.append(info.name)

    def _ask(self, service: str, kind: str, request: bytes) -> memoryview:
        """Wait, in a thread of ROS, for the answer."""
        call = _Call(service, kind, request, Future())
        self._waiting.put(call)
        try:
            return call.answer.result(PATIENCE_S)
        except TimeoutError:
            if not call.answer.cancel():  # it is being answered now
                return call.answer.result()
            raise TopicError(f"{service}: no answer within {PATIENCE_S:g} s; is it paused?") from None

    def answer(self) -> None:
        """Answer all waiting calls; those that timed out are not executed."""
        while (call := self._next()) is not None:
            if not call.answer.set_running_or_notify_cancel():
                continue
            try:
                call.answer.set_result(self._codec.encode(self._do(call)))
            except NrpError as error:
                call.answer.set_exception(error)
                if not self._node.returns_errors:
                    message = f"a call got no answer, because ROS 2 cannot carry its error: {error}"
                    self._warnings.add(Code.NRP282, message, subject=call.service)

    def _do(self, call: _Call) -> Any:
        return self._world.call(call.service, self._codec.decode(call.request, call.kind))

    def _next(self) -> _Call | None:
        try:
            return self._waiting.get_nowait()
        except Empty:
            return None
