"""The services of a world in ROS: ``/gazebo/set_model_state`` and the others, as Gazebo has them.

ROS calls in threads of its own; what it asks waits until the world stands still between two steps.
"""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any

from nrp_core.errors import NrpError, TopicError
from nrp_core.world import Direction, World
from nrp_core.world.services.service import PREFIX, response_of

from nrp_world_ros.node import Node

PATIENCE_S = 30.0
"""How long a caller waits for the world."""


@dataclass(frozen=True, slots=True)
class _Call:
    """What somebody in ROS asks, and where the answer goes."""

    service: str
    kind: str
    request: bytes
    answer: Future[memoryview]


class Calls:
    """Answers calls of ROS, whenever it is told to.

    Args:
        world: answers them.
        node: in ROS.

    Attributes:
        services: their names.
    """

    def __init__(self, world: World, node: Node) -> None:
        self._world, self._codec = world, node.codec
        self._waiting: SimpleQueue[_Call] = SimpleQueue()
        self.services: list[str] = []
        if node.has_services:
            self._offer(node)

    def _offer(self, node: Node) -> None:
        for info in self._world.topics.values():
            if info.name.startswith(PREFIX) and info.direction is Direction.IN:
                request, response = map(self._codec.name, (info.type, response_of(info.type)))
                node.serve(info.name, request, response, partial(self._ask, info.name, request))
                self.services.append(info.name)

    def _ask(self, service: str, kind: str, request: bytes) -> memoryview:
        """Wait, in a thread of ROS, for the answer."""
        call = _Call(service, kind, request, Future())
        self._waiting.put(call)
        try:
            return call.answer.result(PATIENCE_S)
        except TimeoutError:
            if not call.answer.cancel():  # it is being answered this moment
                return call.answer.result()
            raise TopicError(f"{service}: no answer within {PATIENCE_S:g} s; does time pass?") from None

    def answer(self) -> None:
        """Answer all that wait; what somebody has given up waiting for is not done."""
        while (call := self._next()) is not None:
            if not call.answer.set_running_or_notify_cancel():
                continue
            try:
                call.answer.set_result(self._codec.encode(self._do(call)))
            except NrpError as error:
                call.answer.set_exception(error)

    def _do(self, call: _Call) -> Any:
        return self._world.call(call.service, self._codec.decode(call.request, call.kind))

    def _next(self) -> _Call | None:
        try:
            return self._waiting.get_nowait()
        except Empty:
            return None
