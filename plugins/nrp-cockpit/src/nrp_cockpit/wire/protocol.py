"""The messages of the Foxglove WebSocket protocol, version 1.

https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md: control messages are JSON texts; data are
binary, little-endian, with an operation code in the first byte. The control of playback came later; its
messages are those of the Foxglove SDK 0.30.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

SUBPROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
"""Two names of the same protocol: that of the current SDK, and that of the specification."""

CAPABILITIES = ("clientPublish", "services", "time", "playbackControl")
ENCODINGS = ("json",)
"""The encodings of requests and of messages from clients."""

_MESSAGE, _TIME, _RESPONSE, _PLAYBACK = 1, 2, 3, 5
_CLIENT_MESSAGE, _CLIENT_REQUEST, _CLIENT_PLAYBACK = 1, 2, 3
_DATA = struct.Struct("<BIQ")
_CLOCK = struct.Struct("<BQ")
_CALL = struct.Struct("<BIII")
_PUBLISHED = struct.Struct("<BI")
_PLAYBACK_STATE = struct.Struct("<BBQf?I")
_PLAYBACK_REQUEST = struct.Struct("<BBf?QI")


class ProtocolError(ValueError):
    """A client violated the protocol."""


@dataclass(frozen=True, slots=True)
class ServiceRequest:
    """A call of a service by a client."""

    service_id: int
    call_id: int
    encoding: str
    payload: bytes


@dataclass(frozen=True, slots=True)
class ClientMessage:
    """A message that a client publishes on its own channel."""

    channel_id: int
    payload: bytes


class PlaybackStatus(IntEnum):
    """The mode of a playback."""

    PLAYING = 0
    PAUSED = 1
    BUFFERING = 2
    ENDED = 3


@dataclass(frozen=True, slots=True)
class PlaybackRequest:
    """A request to play, pause, seek or change the speed.

    Args:
        play: whether to play.
        speed: simulated seconds per wall second.
        seek_ns: the time to seek; None: the present time.
        request_id: an id that the answer repeats.
    """

    play: bool
    speed: float
    seek_ns: int | None
    request_id: str


def server_info(name: str, session_id: str, end_ns: int) -> str:
    """Return the first message of a server; the time goes from 0 to ``end_ns``."""
    sec, nsec = divmod(end_ns, 1_000_000_000)
    return _text(
        "serverInfo", name=name, sessionId=session_id,
        capabilities=CAPABILITIES, supportedEncodings=ENCODINGS,
        dataStartTime={"sec": 0, "nsec": 0}, dataEndTime={"sec": sec, "nsec": nsec},
    )  # fmt: skip


def status(message: str) -> str:
    """Return a warning for the user of the client."""
    return _text("status", level=1, message=message)


def advertise(channels: Iterable[dict[str, Any]]) -> str:
    """Return the announcement of channels."""
    return _text("advertise", channels=list(channels))


def unadvertise(channel_ids: Iterable[int]) -> str:
    """Return the end of channels."""
    return _text("unadvertise", channelIds=list(channel_ids))


def advertise_services(names: Iterable[tuple[int, str]]) -> str:
    """Return the announcement of services, all of which take and return JSON."""
    schema = {"encoding": "json", "schemaName": "", "schemaEncoding": "jsonschema", "schema": "{}"}
    services = [
        {"id": number, "name": name, "type": "json", "request": schema, "response": schema}
        for number, name in names
    ]
    return _text("advertiseServices", services=services)


def failure(request: ServiceRequest, message: str) -> str:
    """Return the answer to a call that failed."""
    return _text("serviceCallFailure", serviceId=request.service_id, callId=request.call_id, message=message)


def answer(request: ServiceRequest, payload: bytes) -> bytes:
    """Return the answer to a call."""
    return _CALL.pack(_RESPONSE, request.service_id, request.call_id, 4) + b"json" + payload


def data_head(subscription_id: int, t_ns: int) -> bytes:
    """Return the beginning of a message on a channel; its payload follows."""
    return _DATA.pack(_MESSAGE, subscription_id, t_ns)


def clock(t_ns: int) -> bytes:
    """Return the simulated time."""
    return _CLOCK.pack(_TIME, t_ns)


def playback_state(
    status: PlaybackStatus, t_ns: int, speed: float, *, did_seek: bool, request_id: str
) -> bytes:
    """Return the answer to a :class:`PlaybackRequest`."""
    name = request_id.encode()
    return _PLAYBACK_STATE.pack(_PLAYBACK, status, t_ns, speed, did_seek, len(name)) + name


def is_id(number: object) -> bool:
    """Return whether a number is valid as an id in the protocol: unsigned, 32 bits."""
    return isinstance(number, int) and not isinstance(number, bool) and 0 <= number < 1 << 32


def read_binary(frame: bytes) -> ServiceRequest | ClientMessage | PlaybackRequest:
    """Decode a binary message of a client.

    Raises:
        ProtocolError: the frame is truncated, or its operation is unknown.
    """
    try:
        if frame[0] == _CLIENT_MESSAGE:
            _, channel = _PUBLISHED.unpack_from(frame)
            return ClientMessage(channel, frame[_PUBLISHED.size :])
        if frame[0] == _CLIENT_REQUEST:
            _, service, call, length = _CALL.unpack_from(frame)
            end = _CALL.size + length
            if end > len(frame):
                raise ProtocolError(f"a binary message is cut off: {len(frame)} of {end} bytes")
            return ServiceRequest(service, call, frame[_CALL.size : end].decode(), frame[end:])
        if frame[0] == _CLIENT_PLAYBACK:
            _, command, speed, has_seek, seek_ns, length = _PLAYBACK_REQUEST.unpack_from(frame)
            name = frame[_PLAYBACK_REQUEST.size :]
            if command > 1 or length != len(name):
                raise ProtocolError("a request for playback is neither 0 (play) nor 1 (pause), or is cut off")
            return PlaybackRequest(command == 0, speed, seek_ns if has_seek else None, name.decode())
    except (IndexError, struct.error, UnicodeDecodeError) as error:
        raise ProtocolError(f"a binary message is cut off: {error}") from None
    raise ProtocolError(f"unknown binary operation {frame[0]}")


def read_text(text: str) -> dict[str, Any]:
    """Return the JSON object that a client sent.

    Raises:
        ProtocolError: it is not an object, or has no operation.
    """
    try:
        message = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ProtocolError(f"a text message is not JSON: {error}") from None
    if not isinstance(message, dict) or not isinstance(message.get("op"), str):
        raise ProtocolError("a text message must be a JSON object with an 'op'")
    return message


def _text(operation: str, **fields: Any) -> str:
    return json.dumps({"op": operation, **fields})
