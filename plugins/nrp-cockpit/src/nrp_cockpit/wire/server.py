"""The server: one port for the page and for the protocol, in a thread of its own."""

from __future__ import annotations

import asyncio
import logging
import secrets
import socket
import threading
from http import HTTPStatus
from urllib.parse import parse_qs, urlsplit

from websockets.asyncio.server import Server as Listening
from websockets.asyncio.server import ServerConnection, serve
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

from nrp_cockpit.wire.client import Client
from nrp_cockpit.wire.files import file_response, plain
from nrp_cockpit.wire.guard import Guard
from nrp_cockpit.wire.hub import Hub
from nrp_cockpit.wire.protocol import SUBPROTOCOLS
from nrp_core.errors import ExperimentError

LARGEST_REQUEST = 8 << 20
"""Bytes of a message from a client: sources of transfer functions."""


class Server:
    """Serves a hub until it is closed.

    Args:
        hub: the run's side.
        host: the address to listen on.
        port: the port; 0: any free one.
        guard: who may come in.

    Attributes:
        port: the port that it listens on.

    Raises:
        ExperimentError: it cannot listen there.
    """

    def __init__(self, hub: Hub, *, host: str = "127.0.0.1", port: int = 0, guard: Guard) -> None:
        self._hub, self._guard = hub, guard
        self._session_id = secrets.token_hex(8)
        self._loop = asyncio.new_event_loop()
        try:
            self._socket = socket.create_server(
                (host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET
            )
        except OSError as error:
            raise ExperimentError(f"cannot listen on {host}:{port}: {error.strerror or error}") from error
        self.port: int = self._socket.getsockname()[1]
        self._listening: Listening | None = None
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._run, name="nrp-cockpit", daemon=True)
        self._thread.start()
        self._ready.wait()

    def close(self) -> None:
        """Say goodbye to all clients and stop; calling it again does nothing."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._stop)
            self._thread.join()

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._listening = self._loop.run_until_complete(self._listen())
        self._hub.attach(self._loop)
        self._ready.set()
        self._loop.run_until_complete(self._listening.wait_closed())
        self._hub.attach(None)
        self._loop.run_until_complete(self._loop.shutdown_default_executor())
        self._loop.close()

    def _stop(self) -> None:
        assert self._listening is not None
        self._listening.close()

    async def _listen(self) -> Listening:
        quiet = logging.getLogger("nrp_cockpit.wire")
        quiet.setLevel(logging.CRITICAL)  # a visitor that hangs up is no news
        return await serve(
            self._serve, sock=self._socket, process_request=self._enter, compression=None, logger=quiet,
            subprotocols=[Subprotocol(name) for name in SUBPROTOCOLS], select_subprotocol=_chosen,
            max_size=LARGEST_REQUEST, write_limit=1 << 20, close_timeout=1,
        )  # fmt: skip

    def _enter(self, _connection: ServerConnection, request: Request) -> Response | None:
        """Answer requests for files, and those that may not come in; let the others open a connection."""
        refusal = self._guard.refusal(request.headers)
        if refusal is not None:
            return plain(HTTPStatus.FORBIDDEN, refusal)
        if request.headers.get("Upgrade", "").lower() != "websocket":
            return file_response(urlsplit(request.path).path)
        if not self._guard.may_watch(_token(request)):
            return plain(HTTPStatus.UNAUTHORIZED, "the token is missing or wrong; use the printed address")
        return None

    async def _serve(self, connection: ServerConnection) -> None:
        assert connection.request is not None
        may_steer = self._guard.may_steer(_token(connection.request))
        await Client(connection, self._hub, may_steer=may_steer).serve(self._session_id)


def _token(request: Request) -> str:
    return str(parse_qs(urlsplit(request.path).query).get("token", [""])[0])


def _chosen(_connection: ServerConnection, offered: object) -> Subprotocol | None:
    """Return the first of our names that a client offers; one that offers none is served all the same."""
    names = list(offered) if isinstance(offered, (list, tuple)) else []
    return next((Subprotocol(name) for name in SUBPROTOCOLS if name in names), None)
