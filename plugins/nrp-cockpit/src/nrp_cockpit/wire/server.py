"""The server: one port for the page and for the protocol, in a thread of its own."""

from __future__ import annotations

import asyncio
import logging
import secrets
import socket
import threading
from concurrent.futures import Future
from http import HTTPStatus
from pathlib import Path
from urllib.parse import parse_qs

from websockets.asyncio.server import Server as Listening
from websockets.asyncio.server import ServerConnection, serve
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

from nrp_cockpit.wire.client import Client
from nrp_cockpit.wire.files import STATIC, file_response, plain
from nrp_cockpit.wire.guard import Guard
from nrp_cockpit.wire.hub import Hub
from nrp_cockpit.wire.protocol import SUBPROTOCOLS
from nrp_core.errors import ExperimentError

LARGEST_REQUEST = 8 << 20
"""Maximum size of a message from a client, bytes; the largest are sources of transfer functions."""
WRONG_S = 0.5
"""Wrong tokens are refused one after another, each after this time, so that guessing is slow."""
ANOTHER_RUN = 1012
"""The code with which connections are closed whose clients have to connect anew: the service restarts."""


class Server:
    """Serves a hub until it is closed.

    Args:
        hub: the run's side.
        host: the address to listen on.
        port: the port; 0: any free one.
        guard: the access control.
        static: the folder of the page.

    Attributes:
        port: the port that it listens on.

    Raises:
        ExperimentError: it cannot listen on this address.
    """

    def __init__(
        self, hub: Hub, *, host: str = "127.0.0.1", port: int = 0, guard: Guard, static: Path = STATIC
    ) -> None:
        self._hub, self._guard, self._static = hub, guard, static
        self._session_id = secrets.token_hex(8)
        self._socket = _listening(host, port)
        self.port: int = self._socket.getsockname()[1]
        started: Future[None] = Future()
        self._thread = threading.Thread(
            target=lambda: asyncio.run(self._run(started)), name="nrp-cockpit", daemon=True
        )
        self._thread.start()
        started.result()

    def show(self, hub: Hub) -> None:
        """Serve another hub, and have all clients connect anew."""
        asyncio.run_coroutine_threadsafe(self._show(hub), self._loop).result()

    def close(self) -> None:
        """Disconnect all clients and stop; calling it again does nothing."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._closing.set)
            self._thread.join()

    async def _run(self, started: Future[None]) -> None:
        self._loop, self._closing = asyncio.get_running_loop(), asyncio.Event()
        self._refusing = asyncio.Lock()
        try:
            self._listening = listening = await self._listen()
        except BaseException as error:
            started.set_exception(error)
            raise
        self._attach(self._hub)
        started.set_result(None)
        await self._closing.wait()
        listening.close()
        await listening.wait_closed()
        self._hub.attach(None)

    def _attach(self, hub: Hub) -> None:
        hub.attach(self._loop)
        hub.hand_over = self.show

    async def _show(self, hub: Hub) -> None:
        before, self._hub = self._hub, hub
        self._attach(hub)
        leaving = (one.close(ANOTHER_RUN, "something else was opened") for one in self._listening.connections)
        await asyncio.gather(*leaving)
        before.attach(None)

    async def _listen(self) -> Listening:
        quiet = logging.getLogger("nrp_cockpit.wire")
        quiet.setLevel(logging.CRITICAL)  # a client that disconnects is not an error
        return await serve(
            self._serve, sock=self._socket, process_request=self._enter, compression=None, logger=quiet,
            subprotocols=[Subprotocol(name) for name in SUBPROTOCOLS], select_subprotocol=_chosen,
            max_size=LARGEST_REQUEST, write_limit=1 << 20, close_timeout=1,
        )  # fmt: skip

    async def _enter(self, _connection: ServerConnection, request: Request) -> Response | None:
        """Answer requests for files and refused ones; let the others open a connection."""
        refusal = self._guard.refusal(request.headers)
        if refusal is not None:
            return plain(HTTPStatus.FORBIDDEN, refusal)
        path, is_file = request.path.partition("?")[0], not _is_upgrade(request)
        if is_file and path != "/ws":
            return file_response(path, self._static, request.headers.get_all("Accept-Encoding"))
        if not self._guard.may_watch(_token(request)):
            async with self._refusing:
                await asyncio.sleep(WRONG_S)
            return plain(HTTPStatus.UNAUTHORIZED, "the token is missing or wrong; use the printed address")
        return plain(HTTPStatus.UPGRADE_REQUIRED, "connect with a websocket") if is_file else None

    async def _serve(self, connection: ServerConnection) -> None:
        assert connection.request is not None
        may_steer = self._guard.may_steer(_token(connection.request))
        hub = self._hub.beside if _of(connection.request, "run") == "beside" else self._hub
        if hub is None:
            await connection.close(1013, "there is no second run")
            return
        is_embedded = _of(connection.request, "embedded") == "true"
        await Client(connection, hub, may_steer=may_steer, is_embedded=is_embedded).serve(self._session_id)


def _listening(host: str, port: int) -> socket.socket:
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        return socket.create_server((host, port), family=family)
    except OSError as error:
        reason = (error.strerror or str(error)).partition(" (while")[0]  # the address is named already
        raise ExperimentError(f"cannot listen on {host}:{port}: {reason}") from error


def _is_upgrade(request: Request) -> bool:
    return "websocket" in (kind.lower() for kind in request.headers.get_all("Upgrade"))


def _token(request: Request) -> str:
    return _of(request, "token")


def _of(request: Request, name: str) -> str:
    return str(parse_qs(request.path.partition("?")[2]).get(name, [""])[0])


def _chosen(_connection: ServerConnection, offered: object) -> Subprotocol | None:
    """Return the first of our protocol names that a client offers; one that offers none is served too."""
    names = list(offered) if isinstance(offered, (list, tuple)) else []
    return next((Subprotocol(name) for name in SUBPROTOCOLS if name in names), None)
