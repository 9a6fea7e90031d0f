"""The domain of ROS 2 of this process, and the networks from which it can be reached: by default none.

The variables are those of ROS 2. Only a default differs: without ``ROS_AUTOMATIC_DISCOVERY_RANGE`` a node of
ROS searches the whole subnet. A node of this package searches in the same way, so that it meets those with
the defaults of ROS, but its multicasts do not leave this machine, and it receives nothing from others.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from typing import Any
from weakref import WeakValueDictionary
from xml.sax.saxutils import quoteattr

from nrp_core.errors import BackendLoadError, did_you_mean
from nrp_core.world.messages.cdr import Codec

from nrp_world_ros.options import LAST_DOMAIN
from nrp_world_ros.ros2.fence import addresses_here, fence, open_sockets
from nrp_world_ros.ros2.rtps.sockets import Sockets
from nrp_world_ros.ros2.topics import DomainTopics

_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_MACHINE, _SUBNET = "LOCALHOST", "SUBNET"
_RANGES = (_MACHINE, _SUBNET, "SYSTEM_DEFAULT")
_CONFIG = "CYCLONEDDS_URI"
_LO = '<NetworkInterface name="lo" multicast="false"/>'
_NEAR = (  # nodes with the defaults of ROS announce themselves on a network, others on loopback
    f'<Interfaces><NetworkInterface autodetermine="true" priority="1"/>{_LO}</Interfaces>'
    "<AllowMulticast>spdp</AllowMulticast><MulticastTimeToLive>0</MulticastTimeToLive>"
)
# nodes without a network hear no multicast: they learn of this one when it writes to each possible port
_NEAR_PAUSE = "<SPDPInterval>1 s</SPDPInterval>"
_LOOPBACK = (
    '<Interfaces><NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces>'
    "<AllowMulticast>false</AllowMulticast>"
)
_domains: WeakValueDictionary[int, DomainTopics] = WeakValueDictionary()


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


def reach(number: int, environ: Mapping[str, str] = os.environ) -> str:
    """Return which nodes are found, for a report that there are none."""
    if on_this_machine_only(environ):
        near = f"on this machine; to find those of others, set {_RANGE}={_SUBNET} for all"
    elif _CONFIG in environ:
        near = f"on the networks of {_CONFIG}"
    else:
        near = "on this subnet, if it carries multicast; else set ROS_STATIC_PEERS"
    return (
        f"domain {number}, {near}. Others have the same ROS_DOMAIN_ID, and a DDS as RMW_IMPLEMENTATION, "
        "which Zenoh is not"
    )


def configuration(environ: Mapping[str, str] = os.environ) -> str:
    """Return the network configuration for Cyclone DDS; its own ``CYCLONEDDS_URI`` takes precedence."""
    peers = _static_peers(environ)
    general = pause = ""
    if on_this_machine_only(environ):
        near = _NEAR if addresses_here() else _LOOPBACK
        general, peers, pause = f"<General>{near}</General>", ["127.0.0.1"], _NEAR_PAUSE
    listed = "".join(f"<Peer address={quoteattr(peer)}/>" for peer in peers)
    return (
        f'<CycloneDDS><Domain Id="any">{general}<Discovery><ParticipantIndex>auto</ParticipantIndex>'
        "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
        f"{pause}<Peers>{listed}</Peers></Discovery></Domain></CycloneDDS>,{environ.get(_CONFIG, '')}"
    ).rstrip(",")


def _static_peers(environ: Mapping[str, str]) -> list[str]:
    return [peer for peer in environ.get("ROS_STATIC_PEERS", "").split(";") if peer]


def service_sockets(number: int, environ: Mapping[str, str] = os.environ) -> Sockets:
    """Return the ports for services, which follow the variables of ROS alone.

    Raises:
        BackendLoadError: DDS cannot use the network.
    """
    near = environ.get(_RANGE, _MACHINE) == _MACHINE
    try:
        return Sockets(number, near=near, peers=() if near else _static_peers(environ))
    except OSError as error:
        raise (
            _unfenced(error) if near else BackendLoadError(f"DDS cannot use the network: {error}")
        ) from error


def participate(number: int, codec: Codec) -> tuple[DomainTopics, Any]:
    """Return the topics of the domain with a number, shared in this process, and a new participant of it.

    Args:
        number: the number.
        codec: knows the types of topics.

    Raises:
        BackendLoadError: DDS cannot use the network.
    """
    from cyclonedds.core import DDSException
    from cyclonedds.domain import Domain, DomainParticipant

    others = open_sockets()
    try:
        topics = _domains.get(number)
        if topics is None:
            topics = DomainTopics(Domain(number, configuration()), number)
            topics.describe(codec)
        participant = DomainParticipant(number)
    except DDSException as error:
        given = f"; {_CONFIG} is '{os.environ[_CONFIG]}'" if _CONFIG in os.environ else ""
        raise BackendLoadError(f"DDS cannot join domain {number}: {error}{given}") from error
    _domains[number] = topics
    if on_this_machine_only() and sys.platform == "linux":
        try:  # Cyclone DDS always listens on all devices, see its issue 1923
            fence(open_sockets() - others)
        except OSError as error:
            raise _unfenced(error) from error
    return topics, participant


def _unfenced(error: OSError) -> BackendLoadError:
    return BackendLoadError(
        f"this system cannot keep ROS 2 to this machine ({error}); to allow remote access, set "
        f"{_RANGE}={_SUBNET}"
    )
