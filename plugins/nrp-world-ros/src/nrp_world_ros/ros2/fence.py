"""The network interfaces of Linux, and sockets that are kept to the programs of this machine.

A socket filter of the kernel passes packets from the loopback device, through which all come that this
machine sends to an address of its own, and the local copies of its multicasts. The sender's address is not
compared, because another machine could forge it. See socket(7), and filter.txt in the documentation of Linux.
"""

from __future__ import annotations

import ctypes
import os
import socket
import struct
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

_SOCKETS = Path("/proc/self/fd")

# of linux/filter.h, linux/if_packet.h and asm-generic/socket.h, which Python does not have
_LOAD, _EQUAL, _RETURN = 0x20, 0x15, 0x06
_PACKET_TYPE, _DEVICE = 0xFFFFF004, 0xFFFFF008
_LOCAL_COPY = 5
_ALL = 0xFFFFFFFF
_SO_ATTACH_FILTER = 26
_ADDRESS_OF = 0x8915


def open_sockets() -> set[int]:
    """Return the sockets of this process; empty if the system does not list them."""
    found = set()
    for link in _SOCKETS.iterdir() if _SOCKETS.exists() else ():
        with suppress(OSError):  # the descriptor used for the list
            if link.readlink().name.startswith("socket:"):
                found.add(int(link.name))
    return found


def addresses_here() -> list[str]:
    """Return the addresses of the interfaces besides loopback; none on systems other than Linux."""
    if sys.platform != "linux":
        return []
    import fcntl

    found = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        for _, name in socket.if_nameindex():
            with suppress(OSError):  # it has none
                told = fcntl.ioctl(any_socket, _ADDRESS_OF, struct.pack("16s24x", name.encode()))
                found += [socket.inet_ntoa(told[20:24])] if name != "lo" else []
    return found


def fence(sockets: Iterable[int]) -> None:
    """Let these sockets receive nothing from other machines.

    Raises:
        OSError: the system does not filter.
    """
    code = (
        (_LOAD, 0, 0, _DEVICE),
        (_EQUAL, 2, 0, socket.if_nametoindex("lo")),
        (_LOAD, 0, 0, _PACKET_TYPE),
        (_EQUAL, 0, 1, _LOCAL_COPY),
        (_RETURN, 0, 0, _ALL),
        (_RETURN, 0, 0, 0),
    )
    program = ctypes.create_string_buffer(b"".join(struct.pack("=HBBI", *each) for each in code))
    option = struct.pack("@HP", len(code), ctypes.addressof(program))
    for number in sockets:
        with socket.socket(fileno=os.dup(number)) as each:
            each.setsockopt(socket.SOL_SOCKET, _SO_ATTACH_FILTER, option)
