"""The ports of a participant of RTPS; DDSI-RTPS 2.3, section 9.6.1."""

from __future__ import annotations

import select
import socket
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress

from nrp_core.errors import BackendLoadError
from nrp_core.world import Closing

from nrp_world_ros.ros2.fence import addresses_here, fence
from nrp_world_ros.ros2.rtps.parameters import Address

_GROUP = "239.255.0.1"
_BASE, _PER_DOMAIN, _PER_PARTICIPANT, _UNICAST = 7400, 250, 2, 10
_MOST_PARTICIPANTS = 119
_SEARCHED = 33
"""Number of participants of another machine, or of loopback, that are searched."""

_LARGEST = 1 << 16
_LOOPBACK = "127.0.0.1"


class Sockets(Closing):
    """Sends and receives packets.

    Args:
        domain: number of the domain.
        near: whether only this machine is reached.
        peers: other machines to be searched.

    Attributes:
        addresses: where others can send.

    Raises:
        BackendLoadError: no port is free, or the system cannot keep others out.
    """

    def __init__(self, domain: int, *, near: bool, peers: Sequence[str] = ()) -> None:
        self._near, self._base = near, _BASE + _PER_DOMAIN * domain
        self._here = addresses_here() or _address_of_route(near=near)
        self._unicast = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._multicast = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._host = "" if sys.platform == "linux" or not near else _LOOPBACK
        self._peers = [*dict.fromkeys([_LOOPBACK, *peers])]
        try:
            self.addresses = self._open()
        except BaseException:
            self.close()
            raise

    def _open(self) -> list[Address]:
        if self._near and sys.platform == "linux":
            fence([self._unicast.fileno(), self._multicast.fileno()])
        for option in (socket.SO_REUSEADDR, getattr(socket, "SO_REUSEPORT", None)):
            if option is not None:
                self._multicast.setsockopt(socket.SOL_SOCKET, option, 1)
        self._multicast.bind((self._host, self._base))
        for here in self._here:
            group = socket.inet_aton(_GROUP) + socket.inet_aton(here)
            with suppress(OSError):  # it has no multicast
                self._multicast.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
        self._unicast.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0 if self._near else 1)
        port = self._bound()
        there = self._here if not self._near else [*dict.fromkeys([*self._here, _LOOPBACK])]
        return [(address, port) for address in there]

    def _bound(self) -> int:
        for index in range(_MOST_PARTICIPANTS):
            port = self._base + _UNICAST + _PER_PARTICIPANT * index
            try:
                self._unicast.bind((self._host, port))
            except OSError:
                continue
            return port
        raise BackendLoadError(f"all ports of the domain are taken, from {self._base + _UNICAST} on")

    def everywhere(self) -> Iterator[Address]:
        """Yield the addresses at which unknown participants may be."""
        yield _GROUP, self._base
        for peer in self._peers:
            for index in range(_SEARCHED):
                yield peer, self._base + _UNICAST + _PER_PARTICIPANT * index

    def send(self, packet: bytes, addresses: Iterable[Address]) -> None:
        """Send a packet; what does not arrive is sent again when it is asked for."""
        for address in addresses:
            for here in self._here if address[0] == _GROUP else self._here[:1]:
                with suppress(OSError):  # nobody is there, or the network is down
                    own = socket.inet_aton(here)
                    self._unicast.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, own)
                    self._unicast.sendto(packet, address)

    def received(self, timeout_s: float) -> Iterator[bytes]:
        """Yield the packets that have come, after waiting for one."""
        ready, _, _ = select.select([self._unicast, self._multicast], [], [], timeout_s)
        for each in ready:
            with suppress(OSError):  # a damaged packet is announced but not there
                yield each.recv(_LARGEST, getattr(socket, "MSG_DONTWAIT", 0))

    def close(self) -> None:
        """Close the ports."""
        self._unicast.close()
        self._multicast.close()


def _address_of_route(*, near: bool) -> list[str]:
    """Return the address from which this machine sends multicasts."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((_LOOPBACK if near else _GROUP, _BASE))
        except OSError:  # there is no network
            return [_LOOPBACK]
        return [str(probe.getsockname()[0])]
