"""The domain of ROS 2 of this process, and the networks from which it can be reached: by default none.

The variables are those of ROS 2. Only a default differs: without ``ROS_AUTOMATIC_DISCOVERY_RANGE`` a node of
ROS searches the whole subnet, a node of this package only this machine.
"""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary
from xml.sax.saxutils import quoteattr

from nrp_core.errors import BackendLoadError, did_you_mean

from nrp_world_ros.options import LAST_DOMAIN

_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_MACHINE, _SUBNET = "LOCALHOST", "SUBNET"
_RANGES = (_MACHINE, _SUBNET, "SYSTEM_DEFAULT")
_CONFIG = "CYCLONEDDS_URI"
_SOCKETS = Path("/proc/self/fd")
_domains: WeakValueDictionary[int, Any] = WeakValueDictionary()


def domain_number(chosen: int | None, environ: Mapping[str, str] = os.environ) -> int:
    """Return the number of the domain.

    Args:
        chosen: the user's choice; None: ``ROS_DOMAIN_ID``, else 0.
        environ: the environment variables.

    Raises:
        BackendLoadError: there is no such domain.
    """
    text = environ.get("ROS_DOMAIN_ID", "") if chosen is None else str(chosen)
    if text and not (text.isdecimal() and int(text) <= LAST_DOMAIN):
        raise BackendLoadError(f"ROS_DOMAIN_ID is a number from 0 to {LAST_DOMAIN}, not '{text}'")
    return int(text or 0)


def on_this_machine_only(environ: Mapping[str, str] = os.environ) -> bool:
    """Return whether other machines cannot reach this process, which is the default.

    Raises:
        BackendLoadError: ROS 2 does not have such a range.
    """
    wanted = environ.get(_RANGE, _MACHINE)
    if wanted not in _RANGES:
        hint = did_you_mean(wanted, _RANGES)
        raise BackendLoadError(f"{_RANGE} is one of {', '.join(_RANGES)}, not '{wanted}'{hint}")
    return wanted == _MACHINE and _CONFIG not in environ


def configuration(environ: Mapping[str, str] = os.environ) -> str:
    """Return the network configuration for Cyclone DDS; its own ``CYCLONEDDS_URI`` takes precedence."""
    peers = [peer for peer in environ.get("ROS_STATIC_PEERS", "").split(";") if peer]
    general = ""
    if on_this_machine_only(environ):
        general = (
            '<General><Interfaces><NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces>'
            "<AllowMulticast>false</AllowMulticast></General>"
        )
        peers = ["127.0.0.1"]
    listed = "".join(f"<Peer address={quoteattr(peer)}/>" for peer in peers)
    return (
        f'<CycloneDDS><Domain Id="any">{general}<Discovery><ParticipantIndex>auto</ParticipantIndex>'
        "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
        f"<Peers>{listed}</Peers></Discovery></Domain></CycloneDDS>,{environ.get(_CONFIG, '')}"
    ).rstrip(",")


def participate(number: int) -> tuple[Any, Any]:
    """Return the domain with a number, shared in this process, and a new participant of it.

    Raises:
        BackendLoadError: DDS cannot use the network.
    """
    from cyclonedds.core import DDSException
    from cyclonedds.domain import Domain, DomainParticipant

    others = _open_sockets()
    try:
        domain = _domains.get(number) or Domain(number, configuration())
        participant = DomainParticipant(number)
    except DDSException as error:
        given = f"; {_CONFIG} is '{os.environ[_CONFIG]}'" if _CONFIG in os.environ else ""
        raise BackendLoadError(f"DDS cannot join domain {number}: {error}{given}") from error
    _domains[number] = domain
    if on_this_machine_only():
        _fence(_open_sockets() - others)
    return domain, participant


def _open_sockets() -> set[int]:
    """Return the sockets of this process; empty if the system does not list them."""
    found = set()
    for link in _SOCKETS.iterdir() if _SOCKETS.exists() else ():
        with suppress(OSError):  # the descriptor used for the list
            if link.readlink().name.startswith("socket:"):
                found.add(int(link.name))
    return found


def _fence(sockets: set[int]) -> None:
    """Bind sockets to the loopback device; Cyclone DDS always listens on all devices.

    See https://github.com/eclipse-cyclonedds/cyclonedds/issues/1923. This needs Linux; since 5.7 without
    privileges.
    """
    if sys.platform != "linux":
        return
    for number in sockets:
        with socket.socket(fileno=os.dup(number)) as each:
            try:
                each.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, b"lo\0")
            except OSError as error:
                raise BackendLoadError(
                    f"this system cannot keep ROS 2 to this machine ({error}); to allow remote access, set "
                    f"{_RANGE}={_SUBNET}"
                ) from error
