"""Services of ROS 2, in the two ways in which its transports tie an answer to its call.

Cyclone DDS puts the writer of the call and a number in front of the data, in both directions. All others put
the writer and the sequence number of the call beside the data of the answer, as OMG DDS-RPC 1.0 says.
"""

from __future__ import annotations

import struct
from concurrent.futures import Future

from nrp_core.world import Closing

from nrp_world_ros.node import Answer
from nrp_world_ros.ros2.rtps.packets import PREFIX, Data
from nrp_world_ros.ros2.rtps.parameters import P
from nrp_world_ros.ros2.rtps.participant import RtpsParticipant
from nrp_world_ros.ros2.types import dds_name

_CYCLONE = b"\x01\x10"
_HEAD, _CALL = 4, 16
"""Lengths of the head of encoded data, and of what Cyclone DDS puts between it and the request."""

_GUID = 16


class Services(Closing):
    """Answers calls of services.

    Args:
        participant: in DDS.
    """

    def __init__(self, participant: RtpsParticipant) -> None:
        self._participant = participant

    def serve(self, service: str, request: str, response: str, answer: Answer) -> None:
        """Offer a service; see :meth:`~nrp_world_ros.node.Node.serve`."""
        writer = self._participant.writer(f"rr{service}Reply", _dds_name(response))

        def call(data: Data, payload: bytes) -> None:
            start = _HEAD + _CALL * (data.vendor == _CYCLONE)
            coming = answer(payload[:_HEAD] + payload[start:])
            coming.add_done_callback(lambda done: reply(data, payload, start, done))

        def reply(data: Data, payload: bytes, start: int, done: Future[memoryview]) -> None:
            if done.exception() is not None:  # ROS 2 has no place for the reason; the loop has reported it
                return
            found = bytes(done.result())
            inline: dict[int, bytes] = {}
            if start > _HEAD:
                found = found[:_HEAD] + payload[_HEAD:start] + found[_HEAD:]
            else:
                inline = dict.fromkeys((P.RELATED_SAMPLE, P.FAST_RELATED_SAMPLE), _identity(data))
            self._participant.write(writer, found, inline, data.writer[:PREFIX])

        self._participant.reader(f"rq{service}Request", _dds_name(request), call)

    def close(self) -> None:
        """Leave ROS; waiting calls get no answer."""
        self._participant.close()


def _dds_name(name: str) -> str:
    """Return the DDS name of ``package/msg/NameRequest`` or ``package/msg/NameResponse``."""
    for part in ("Request", "Response"):
        if name.endswith(part):
            package, _, short = name.split("/")
            return dds_name(f"{package}/srv/{short.removesuffix(part)}_{part}")
    raise ValueError(name)


def _identity(data: Data) -> bytes:
    """Return the identity of a call: the reader of its answer if given, else its writer, and its number."""
    given = [*data.inline.get(P.FAST_RELATED_SAMPLE, []), *data.inline.get(P.RELATED_SAMPLE, [])]
    known = [each[:_GUID] for each in given if any(each[:_GUID])]
    return (known or [data.writer])[0] + struct.pack("<iI", data.number >> 32, data.number & 0xFFFFFFFF)
