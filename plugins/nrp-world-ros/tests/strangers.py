"""A participant of DDS whose topics come and go, of types of its own: python strangers.py DOMAIN."""

import ctypes
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import make_idl_struct
from cyclonedds.idl.types import float64, int32, sequence
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic

from ros2_peer import LOOPBACK


def kind(number: int) -> Any:
    """Return a type of six types, each of two more."""

    def struct(name: str, **fields: Any) -> Any:
        return make_idl_struct(name, f"{name}_{number}_{os.getpid()}", fields)

    inner = [struct(f"Inner{i}", x=int32, y=float64) for i in range(6)]
    middle = [struct(f"Middle{i}", one=inner[i], more=sequence[inner[i - 1]]) for i in range(6)]
    return struct("Outer", **{f"part{i}": part for i, part in enumerate(middle)})


@contextmanager
def deaf(domain: Domain) -> Iterator[None]:
    """Hear of no other participant: one that comes while types are described can end this process."""
    number, switch = ctypes.c_int32, ctypes.c_bool
    change = domain._dll_handle.dds_domain_set_deafmute
    change.argtypes = [number, switch, switch, ctypes.c_int64]
    change(domain._ref, True, False, (1 << 63) - 1)
    yield
    change(domain._ref, False, False, 0)


def main() -> None:
    """Open and close twenty topics until the process is ended."""
    number = int(sys.argv[1])
    domain = Domain(number, LOOPBACK)
    with deaf(domain):
        participant = DomainParticipant(number)
        topics = [Topic(participant, f"stranger_{os.getpid()}_{i}", kind(i)) for i in range(20)]
    print("ready", flush=True)
    while True:
        writers = [DataWriter(participant, topic) for topic in topics]
        time.sleep(0.02)
        del writers
        time.sleep(0.005)


if __name__ == "__main__":
    main()
