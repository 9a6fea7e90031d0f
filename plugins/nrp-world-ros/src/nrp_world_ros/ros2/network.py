"""Which domain of ROS 2 this process is in, and which networks it can be reached from: by default none.

The variables are ROS 2's own. Only a default differs: without ``ROS_AUTOMATIC_DISCOVERY_RANGE`` a node of ROS
looks for others on the whole subnet, and one of ours on this machine.
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

from nrp_world_ros.backend import LAST_DOMAIN

_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_MACHINE, _SUBNET = "LOCALHOST", "SUBNET"
_RANGES = (_MACHINE, _SUBNET, "SYSTEM_DEFAULT")
_CONFIG = "CYCLONEDDS_URI"
_SOCKETS = Path("/proc/self/fd")
_domains: WeakValueDictionary[int, Any] = WeakValueDictionary()


def domain_number(chosen: int | None, environ: Mapping[str, str] = os.environ) -> int:
    """Return the number of the domain.

    Args:
        chosen: by the user; None: ``ROS_DOMAIN_ID`` says, else it is 0.
        environ: the variables.

    Raises:
        BackendLoadError: there is no such domain.
    """
    text = environ.get("ROS_DOMAIN_ID", "") if chosen is None else str(chosen)
    if text and not (text.isdecimal() and int(text) <= LAST_DOMAIN):
        raise BackendLoadError(f"ROS_DOMAIN_ID is a number from 0 to {LAST_DOMAIN}, not '{text}'")
    return int(text or 0)


def on_this_machine_only(environ: Mapping[str, str] = os.environ) -> bool:
    """Whether no other machine can reach this process, as it is unless the user asks for it.

    Raises:
        BackendLoadError: the range is none that ROS 2 has.
    """
    wanted = environ.get(_RANGE, _MACHINE)
    if wanted not in _RANGES:
        hint = did_you_mean(wanted, _RANGES)
        raise BackendLoadError(f"{_RANGE} is one of {', '.join(_RANGES)}, not '{wanted}'{hint}")
    return wanted == _MACHINE and _CONFIG not in environ


def configuration(environ: Mapping[str, str] = os.environ) -> str:
    """Return what Cyclone DDS is told of the network, its own ``CYCLONEDDS_URI`` having the last word."""
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
    """Return the domain of a number, shared by all in this process, and a new participant of it.

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
    """Return the sockets of this process; none where the system does not tell."""
    found = set()
    for link in _SOCKETS.iterdir() if _SOCKETS.exists() else ():
        with suppress(OSError):  # the one by which they are listed
            if link.readlink().name.startswith("socket:"):
                found.add(int(link.name))
    return found


def _fence(sockets: set[int]) -> None:
    """Let nothing but the loopback device into sockets; Cyclone DDS would always listen on all devices.

    See https://github.com/eclipse-cyclonedds/cyclonedds/issues/1923. Only Linux can; there since 5.7 without
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
                    f"this system cannot keep ROS 2 to this machine ({error}); to let the network in, set "
                    f"{_RANGE}={_SUBNET}"
                ) from error
