"""Access control: the token, and the Host and Origin of a request.

A page of another site can open a connection to this machine from the visitor's browser. It does not know the
token and cannot forge ``Origin``. A host name of that site that points at this machine (DNS rebinding)
appears in ``Host``.
"""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field

from websockets.datastructures import Headers

from nrp_cockpit.wire.address import LOOPBACK, is_number

CONTENT_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' blob: data:; "
    "connect-src 'self'; font-src 'self'; worker-src 'self' blob:; base-uri 'none'; form-action 'none'; "
    "frame-src 'self'; frame-ancestors 'self'"
)
"""Nothing is loaded from other servers; inline styles are allowed because the editor needs them."""


@dataclass(frozen=True)
class Guard:
    """Decides about requests.

    Args:
        hosts: the names under which the server may be called, without a port.
        takes_numbers: whether it may also be called by any IP address.
        origins: further origins whose pages may connect.
        token: lets its owner control the run.
        watch_token: lets its owner watch.
    """

    hosts: tuple[str, ...] = LOOPBACK
    takes_numbers: bool = False
    origins: tuple[str, ...] = ()
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))
    watch_token: str = field(default_factory=lambda: secrets.token_urlsafe(24))

    def refusal(self, headers: Headers) -> str | None:
        """Return the reason to refuse a request, by its Host and Origin; None to accept it."""
        hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
        if len(hosts) != 1 or len(origins) > 1:
            return "a request must have one Host and at most one Origin"
        host = hosts[0].lower()
        name = _name(host)
        if name not in self.hosts and not (self.takes_numbers and is_number(name)):
            return f"this server is not '{name}'; to call it so, start it with --host {name}"
        if origins and origins[0].lower() not in (
            f"http://{host}",
            f"https://{host}",
            *map(str.lower, self.origins),
        ):
            return f"pages of {origins[0]} may not use this server"
        return None

    def may_watch(self, token: str) -> bool:
        """Return whether a token lets its owner watch."""
        return _same(token, self.watch_token) or self.may_steer(token)

    def may_steer(self, token: str) -> bool:
        """Return whether a token lets its owner control the run."""
        return _same(token, self.token)


def _same(given: str, token: str) -> bool:
    return secrets.compare_digest(given.encode(), token.encode())


def _name(host: str) -> str:
    """Return a host without its port."""
    name, colon, port = host.rpartition(":")
    return name if colon and port.isdigit() else host
