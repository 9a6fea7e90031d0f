"""The part that answers the services of a world, such as Gazebo's ``/gazebo/...``.

:meth:`nrp_core.world.world.World.call` returns the answer. A request that is published on the topic of the
same name is answered as well, so that events and recordings can call services, too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any

from nrp_core.errors import NrpError, TopicError, did_you_mean
from nrp_core.findings import Code
from nrp_core.messages import base
from nrp_core.messages.base import type_name
from nrp_core.world.engine import Engine
from nrp_core.world.part import Part
from nrp_core.world.topics import Direction, TopicInfo

PREFIX = "/gazebo/"


@dataclass(frozen=True, slots=True)
class Service:
    """A service of a world.

    Args:
        name: its name, which is also the topic that takes its requests.
        request: the class of its requests; the class of its answers has the same name with ``Response``
            instead of ``Request``.
        answer: handles a request and returns the answer; an :class:`~nrp_core.errors.NrpError` becomes an
            answer without success if the answer has a field for the reason.
    """

    name: str
    request: type
    answer: Callable[[Any], Any]

    @property
    def response(self) -> type:
        """The class of its answers."""
        found = base.type_of(type_name(self.request).removesuffix("Request") + "Response")
        assert found is not None
        return found


@lru_cache(maxsize=4096)
def _topic_of(name: str, request: type, response: type | None) -> TopicInfo:
    """Return the topic of a service, which all copies of a scene share."""
    return TopicInfo(name, request, Direction.IN, what=f"service: {request.__doc__}", response=response)


class Services(Part):
    """All services of a world.

    Args:
        engine: the engine of the world, which may answer itself.
        provided: the services of each provider.

    Attributes:
        rejected: why the last request on the topic of a service was rejected, by topic.

    Raises:
        TopicError: two providers have a service of the same name.
    """

    def __init__(self, engine: Engine, provided: Mapping[str, Iterable[Service]]) -> None:
        self._engine = engine
        self.rejected: dict[str, str] = {}
        self._table: dict[str, Service] = {}
        for provider, services in provided.items():
            for service in services:
                if service.name in self._table:
                    raise TopicError(
                        f"'{provider}' provides the service '{service.name}', which exists already"
                    )
                self._table[service.name] = service
        self.topics = tuple(
            _topic_of(name, service.request, service.response) for name, service in self._table.items()
        )

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        answer = self.answer(topic, message)
        self.rejected.pop(topic, None)
        if not getattr(answer, "success", True):
            reason = reason_field(type(answer))
            self.rejected[topic] = why = f"{topic}: {getattr(answer, reason) if reason else 'failed'}"
            self._engine.warnings.add(Code.NRP280, why, subject=topic)

    def request(self, name: str, values: tuple[Any, ...], named: Mapping[str, Any]) -> Any:
        """Build a request from values and named fields.

        Raises:
            TopicError: the service does not exist, or its request has no such field.
        """
        if name not in self._table:
            raise TopicError(f"unknown service '{name}'{did_you_mean(name, self._table)}")
        kind = self._table[name].request
        if len(values) == 1 and not named and type_name(type(values[0])) == type_name(kind):
            return values[0]
        try:
            return kind(*values, **named)
        except TypeError as error:
            raise TopicError(f"{name}: {error}".replace("__init__() ", "")) from None

    def answer(self, name: str, request: Any) -> Any:
        """Handle a request and return the answer; a failure is reported in the answer."""
        service = self._table[name]
        try:
            remote = self._engine.answer(name, request, service.response)
            return service.answer(request) if remote is None else remote
        except NrpError as error:
            reason = reason_field(service.response)
            if reason is None:
                raise
            return service.response(success=False, **{reason: getattr(error, "message", str(error))})


def reason_field(response: type) -> str | None:
    """Return the field of an answer for the reason of a failure; None if it has no such field.

    Gazebo's services call it ``status_message``, those of ``std_srvs`` ``message``.
    """
    names = {field.name for field in fields(response)}
    if "success" not in names:
        return None
    return next((name for name in ("status_message", "message") if name in names), None)
