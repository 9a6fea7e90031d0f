"""The services of a world in ROS, such as ``/gazebo/set_model_state``, with the names of Gazebo.

ROS calls in its own threads; requests wait until the world is between two steps, and are then answered in its
thread.
"""

from __future__ import annotations

import time
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from queue import Empty, Full, Queue
from typing import Any

from nrp_core.errors import NrpError, TopicError
from nrp_core.world import Code, Findings, World

from nrp_world_ros.node import PATIENCE_S, Node

MOST = 256
"""Maximum number of calls that wait for the world."""


@dataclass(frozen=True, slots=True)
class _Call:
    """A request from ROS, and the place for its answer."""

    service: str
    kind: str
    request: bytes
    answer: Future[memoryview] = field(default_factory=Future)
    asked_s: float = field(default_factory=time.monotonic)


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
        self._waiting: Queue[_Call] = Queue(MOST)
        self._refused, self._closed = 0, False
        self.services: list[str] = []

    def offer(self) -> None:
        """Offer all services of the world in ROS."""
        for info in self._world.topics.values():
            if info.response is not None:
                request, response = map(self._codec.name, (info.type, info.response))
                self._node.serve(info.name, request, response, partial(self._ask, info.name, request))
                self.services.append(info.name)

    def _ask(self, service: str, kind: str, request: bytes) -> Future[memoryview]:
        """Take a call, in a thread of ROS."""
        call = _Call(service, kind, request)
        try:
            self._waiting.put_nowait(call)
        except Full:
            self._refused += 1
            call.answer.set_exception(TopicError(f"{service}: {MOST} calls wait already"))
        if self._closed:
            self._refuse()
        return call.answer

    def close(self) -> None:
        """Refuse the calls that wait, and all later ones."""
        self._closed = True
        self._refuse()

    def _refuse(self) -> None:
        while (call := self._next()) is not None:
            with suppress(InvalidStateError):  # nobody waits any more
                call.answer.set_exception(TopicError(f"{call.service}: this world has been closed"))

    def answer(self) -> None:
        """Answer all waiting calls; those that timed out are not executed."""
        if self._refused:
            message = f"{self._refused} calls were refused, because {MOST} waited already"
            self._warnings.add(Code.NRP282, message, subject="services")
            self._refused = 0
        while (call := self._next()) is not None:
            late = time.monotonic() > call.asked_s + PATIENCE_S
            if late or not call.answer.set_running_or_notify_cancel():
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
