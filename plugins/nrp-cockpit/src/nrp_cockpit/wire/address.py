"""The address of the page: permitted host names, the printed address, and the browser's token."""

from __future__ import annotations

import html
import socket
import tempfile
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from ipaddress import ip_address
from pathlib import Path
from typing import Final

LOOPBACK: Final = ("127.0.0.1", "localhost", "[::1]")
EVERY: Final = ("0.0.0.0", "::")
"""The addresses of servers that listen on all addresses of a machine."""
_ELSEWHERE: Final = ("192.0.2.1", 9)
"""An address for documentation (RFC 5737), to which nothing is sent."""


def is_private(host: str) -> bool:
    """Return whether a server on an address can be reached from this machine only."""
    return in_url(host) in LOOPBACK


def in_url(host: str) -> str:
    """Return an address as URLs and the header ``Host`` write it."""
    return f"[{host}]" if ":" in host else host.lower()


def names_of(host: str) -> tuple[str, ...]:
    """Return the names under which a server on an address may be called."""
    if is_private(host):
        return LOOPBACK
    own = socket.gethostname().lower()
    return (*LOOPBACK, own, f"{own}.local") if host in EVERY else (in_url(host),)


def is_number(name: str) -> bool:
    """Return whether the name in a header ``Host`` is an IP address, which no site has as its name."""
    try:
        ip_address(name.strip("[]"))
    except ValueError:
        return False
    return True


def shown_host(host: str) -> str:
    """Return the host of the printed address; if a server listens on all addresses, one in the network."""
    if host not in EVERY:
        return "127.0.0.1" if host == "localhost" else in_url(host)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(_ELSEWHERE)
            return str(probe.getsockname()[0])
        except OSError:  # without a network
            return "127.0.0.1"


@contextmanager
def opened_in_browser(address: str) -> Iterator[Path]:
    """Open an address in the browser through a file that only the user can read, and that the block keeps.

    The command line of a browser, which all users of a machine can read, would reveal the token.
    """
    with tempfile.TemporaryDirectory(prefix="nrp-cockpit-") as folder:  # 0700
        file, link = Path(folder) / "open.html", html.escape(address)
        file.touch(mode=0o600)
        file.write_text(
            f'<!doctype html><meta charset="utf-8"><meta http-equiv="refresh" content="0;url={link}">'
            f'<title>Cockpit</title><a href="{link}">Open the cockpit</a>\n',
            encoding="utf-8",
        )
        webbrowser.open(file.as_uri())
        yield file
