"""Serve a session to browsers until it ends."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass

import typer

from nrp_cockpit.start.session import Served
from nrp_cockpit.wire.address import EVERY, is_private, names_of, opened_in_browser, shown_host
from nrp_cockpit.wire.guard import Guard
from nrp_cockpit.wire.hub import Hub
from nrp_cockpit.wire.server import Server
from nrp_core.cli.output import warn


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
        guard, hub = Guard(names_of(self.host), self.host in EVERY, self.origins), Hub()
        with ExitStack() as stack:
            session = opened(hub, stack)
            server = Server(hub, host=self.host, port=self.port, guard=guard)
            stack.callback(server.close)
            address = f"http://{shown_host(self.host)}:{server.port}/?token="
            view = f"#/{self.view}" if self.view else ""
            typer.echo(f"{address}{guard.token}{view}")
            typer.echo(f"to watch only: {address}{guard.watch_token}{view}", err=True)
            if not is_private(self.host):
                warn("everybody who has the first address can run programs here, and it is sent unencrypted")
            sys.stdout.flush()
            if self.browser:
                stack.enter_context(opened_in_browser(f"{address}{guard.token}{view}"))
            if self.play:
                session.play()
            try:
                session.serve()
            except KeyboardInterrupt:
                session.close()
