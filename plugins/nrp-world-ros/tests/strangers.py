"""A participant of DDS whose topics come and go, of types of its own: python strangers.py DOMAIN."""

import os
import sys
import time
from typing import Any

from cyclonedds.idl import make_idl_struct
from cyclonedds.idl.types import float64, int32, sequence
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic

from ros2_peer import Peer


def kind(number: int) -> Any:
    """Return a type of six types, each of two more."""

    def struct(name: str, **fields: Any) -> Any:
        return make_idl_struct(name, f"{name}_{number}_{os.getpid()}", fields)

    inner = [struct(f"Inner{i}", x=int32, y=float64) for i in range(6)]
    middle = [struct(f"Middle{i}", one=inner[i], more=sequence[inner[i - 1]]) for i in range(6)]
    return struct("Outer", **{f"part{i}": part for i, part in enumerate(middle)})


def main() -> None:
    """Open and close twenty topics until the process is ended."""
    number = int(sys.argv[1])
    peer = Peer(number)
    topics = [Topic(peer.participant, f"stranger_{os.getpid()}_{i}", kind(i)) for i in range(20)]
    peer.begin()
    print("ready", flush=True)
    while True:
        writers = [DataWriter(peer.participant, topic) for topic in topics]
        time.sleep(0.02)
        del writers
        time.sleep(0.005)


if __name__ == "__main__":
    main()
