"""A way to a server that can be cut, as when a machine sleeps or a cable is pulled."""

from __future__ import annotations

import socket
import threading
from contextlib import suppress
from urllib.parse import urlsplit, urlunsplit


class Way:
    """Passes bytes between whoever connects to it and a server, until it is cut.

    Args:
        address: of the page on the server.

    Attributes:
        address: of the same page over this way.
    """

    def __init__(self, address: str) -> None:
        parts = urlsplit(address)
        assert parts.port is not None
        self._server = (parts.hostname, parts.port)
        self._open: list[socket.socket] = []
        self._passing: list[threading.Thread] = []
        self._is_cut = False
        self._entry = socket.create_server(("127.0.0.1", 0))
        self.address = urlunsplit(parts._replace(netloc=f"127.0.0.1:{self._entry.getsockname()[1]}"))
        threading.Thread(target=self._accept, daemon=True).start()

    def cut(self) -> None:
        """End all connections, and those to come at once."""
        self._is_cut = True
        for each in self._open:
            with suppress(OSError):  # it has ended by itself
                each.shutdown(socket.SHUT_RDWR)

    def mend(self) -> None:
        """Let connections through again."""
        self._is_cut = False

    def close(self) -> None:
        """Cut it for good."""
        self._entry.close()
        self.cut()
        for thread in self._passing:
            thread.join(10)
        for each in self._open:
            each.close()

    def _accept(self) -> None:
        while True:
            try:
                near, _ = self._entry.accept()
            except OSError:
                return
            if self._is_cut:
                near.close()
                continue
            far = socket.create_connection(self._server)
            self._open += [near, far]
            for one, other in ((near, far), (far, near)):
                self._passing.append(threading.Thread(target=self._pass, args=(one, other), daemon=True))
                self._passing[-1].start()

    @staticmethod
    def _pass(source: socket.socket, target: socket.socket) -> None:
        try:
            while data := source.recv(1 << 16):
                target.sendall(data)
            target.shutdown(socket.SHUT_WR)
        except OSError:
            pass
