"""The part that answers the services of a world, such as Gazebo's ``/gazebo/...``.

:meth:`nrp_core.world.world.World.call` returns the answer. A request that is published on the topic of the
same name is answered as well, so that events and recordings can call services, too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from nrp_core.errors import NrpError, TopicError, did_you_mean
from nrp_core.world.live import LiveScene
from nrp_core.world.messages.base import type_name
from nrp_core.world.part import Part
from nrp_core.world.services.service import SERVICES, Service, response_of
from nrp_core.world.topics import Direction, TopicInfo


class Services(Part):
    """All services of a world.

    Args:
        live: the scene of now.

    Raises:
        BackendError: a provider of services cannot be used.
        TopicError: two providers have a service of the same name.
    """

    def __init__(self, live: LiveScene) -> None:
        self._live = live
        self._table: dict[str, Service] = {}
        for provider, services in SERVICES.load_all().items():
            for service in services(live):
                if service.name in self._table:
                    raise TopicError(
                        f"'{provider}' provides the service '{service.name}', which exists already"
                    )
                self._table[service.name] = service
        self.topics = tuple(
            TopicInfo(name, service.request, Direction.IN, what=f"service: {service.request.__doc__}")
            for name, service in self._table.items()
        )

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        answer = self.answer(topic, message)
        if not getattr(answer, "success", True):
            self._live.warnings.append(f"{topic}: {answer.status_message}")

    def request(self, name: str, values: tuple[Any, ...], named: Mapping[str, Any]) -> Any:
        """Return the request made of values and named fields.

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
            return service.answer(request)
        except NrpError as error:
            response = response_of(service.request)
            if not fields(response):
                raise  # the answer has no field for a reason
            return response(success=False, status_message=getattr(error, "message", str(error)))
