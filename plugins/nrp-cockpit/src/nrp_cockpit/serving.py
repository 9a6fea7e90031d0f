"""Serve a session to browsers until it ends."""

from __future__ import annotations

import sys
import webbrowser
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass

import typer

from nrp_cockpit.start.session import Served
from nrp_cockpit.wire.guard import LOOPBACK, Guard
from nrp_cockpit.wire.hub import Hub
from nrp_cockpit.wire.server import Server


@dataclass(frozen=True, slots=True)
class Serving:
    """The settings of the server.

    Args:
        host: the address to listen on.
        port: the port; 0: any free port.
        origins: origins of other pages that may connect.
        browser: whether to open a browser.
        play: whether the session starts playing immediately.
        view: the initial view of the page; empty: the default one.
    """

    host: str = "127.0.0.1"
    port: int = 0
    origins: tuple[str, ...] = ()
    browser: bool = True
    play: bool = False
    view: str = ""

    def serve(self, opened: Callable[[Hub, ExitStack], Served]) -> None:
        """Open a session, print the address of its page, and serve it until Ctrl-C.

        Args:
            opened: makes the session of a hub and adds its services.
        """
        hosts = LOOPBACK if self.host in ("127.0.0.1", "localhost", "::1") else ()
        guard, hub = Guard(hosts, self.origins), Hub()
        with ExitStack() as stack:
            session = opened(hub, stack)
            server = Server(hub, host=self.host, port=self.port, guard=guard)
            stack.callback(server.close)
            address = f"http://{self._shown_host()}:{server.port}/?token="
            view = f"#/{self.view}" if self.view else ""
            typer.echo(f"{address}{guard.token}{view}")
            typer.echo(f"to watch only: {address}{guard.watch_token}{view}", err=True)
            sys.stdout.flush()
            if self.browser:
                webbrowser.open(f"{address}{guard.token}{view}")
            if self.play:
                session.play()
            try:
                session.serve()
            except KeyboardInterrupt:
                session.close()

    def _shown_host(self) -> str:
        if self.host in ("0.0.0.0", "localhost"):
            return "127.0.0.1"
        return f"[{self.host}]" if ":" in self.host else self.host
