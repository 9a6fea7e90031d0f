"""Who may come in: the token, and the Host and Origin of a request.

A page of another site can open a connection to this machine from the visitor's browser. It cannot know the
token, and neither can it forge ``Origin``; a name of its own that it points at this machine (DNS rebinding)
shows in ``Host``.
"""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from urllib.parse import urlsplit

from websockets.datastructures import Headers

CONTENT_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' blob: data:; "
    "connect-src 'self'; font-src 'self'; worker-src 'self' blob:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
"""Nothing comes from outside; styles may be made by the editor, which needs them in the page."""

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")


@dataclass(frozen=True)
class Guard:
    """Decides about requests.

    Args:
        hosts: the names under which the server may be called, without a port; empty: any.
        token: lets its owner steer.
        watch_token: lets its owner watch.
    """

    hosts: tuple[str, ...] = LOOPBACK
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))
    watch_token: str = field(default_factory=lambda: secrets.token_urlsafe(24))

    def refusal(self, headers: Headers) -> str | None:
        """Return why a request is refused, by its Host and Origin; None if it is not."""
        host = headers.get("Host", "")
        if self.hosts and _name(host) not in self.hosts:
            return f"this server is not '{_name(host)}'"
        origin = headers.get("Origin")
        if origin is not None and urlsplit(origin).netloc != host:
            return f"pages of {origin} may not use this server"
        return None

    def may_watch(self, token: str) -> bool:
        """Return whether a token lets its owner watch."""
        return any(secrets.compare_digest(token.encode(), known.encode()) for known in self._known())

    def may_steer(self, token: str) -> bool:
        """Return whether a token lets its owner steer."""
        return secrets.compare_digest(token.encode(), self.token.encode())

    def _known(self) -> tuple[str, str]:
        return self.token, self.watch_token


def _name(host: str) -> str:
    """Return a host without its port."""
    name, colon, port = host.rpartition(":")
    return name if colon and port.isdigit() else host
