"""The calls of one client to the services."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from typing import Any

from nrp_cockpit.wire import protocol
from nrp_cockpit.wire.hub import Services, to_json
from nrp_cockpit.wire.protocol import ProtocolError, ServiceRequest
from nrp_core.errors import NrpError

PREFIX = "/cockpit/"
PUBLISH = "publish"
"""The service behind the messages that clients publish."""
WATCHER = "you may watch this run but not control it"


class Calls:
    """Calls services for one client, each in a thread, so that none delays another.

    Args:
        services: returns the services, whose names stay the same.
        may_steer: whether the client may change the run.
    """

    def __init__(self, services: Callable[[], Services], *, may_steer: bool) -> None:
        self._services, self._may_steer = services, may_steer
        self._publishing = asyncio.Lock()  # first come, first served, so that messages keep their order

    async def answer(self, request: ServiceRequest) -> bytes | str:
        """Return the frame that answers a request."""
        names = self._services().names
        try:
            if not 0 < request.service_id <= len(names):
                raise ProtocolError(f"there is no service {request.service_id}")
            arguments = _json(request.payload or b"{}")
            if not isinstance(arguments, dict):
                raise ProtocolError("a request is a JSON object, with the arguments by their names")
            found = await self._call(names[request.service_id - 1], arguments)
            return protocol.answer(request, to_json({} if found is None else found))
        except Exception as error:  # noqa: BLE001  whoever asked is told; the server goes on
            return protocol.failure(request, _sentence(error))

    async def publish(self, topic: str, payload: bytes) -> str | None:
        """Publish a message of the client; return the reason for a failure, else None."""
        try:
            arguments = {"topic": topic, "value": _json(payload)}
        except ProtocolError as error:
            return f"{topic}: {error}"
        async with self._publishing:
            failure = await self.make(PUBLISH, arguments)
        return None if failure is None else f"{topic}: {failure}"

    async def make(self, service: str, arguments: dict[str, Any]) -> str | None:
        """Call a service of the cockpit; return the reason for a failure, else None."""
        try:
            await self._call(PREFIX + service, arguments)
        except Exception as error:  # noqa: BLE001  likewise
            return _sentence(error)
        return None

    async def _call(self, name: str, arguments: dict[str, Any]) -> Any:
        services = self._services()
        if name in services.steering and not self._may_steer:
            raise ProtocolError(WATCHER)
        service = services.steering.get(name) or services.watching.get(name)
        if service is None:
            raise ProtocolError(f"there is no service '{name}'")
        return await asyncio.to_thread(service, **arguments)


def _json(payload: bytes) -> Any:
    def refuse(word: str) -> Any:
        raise ValueError(f"{word} is not a number in JSON")

    try:
        return json.loads(payload, parse_constant=refuse)
    except (ValueError, RecursionError) as error:
        raise ProtocolError(f"this is not JSON: {error}") from None


def _sentence(error: Exception) -> str:
    """Return the message of an error, with its class if it is not ours."""
    ours = isinstance(error, (NrpError, ProtocolError))
    return str(error) if ours else f"{type(error).__name__}: {error}"
