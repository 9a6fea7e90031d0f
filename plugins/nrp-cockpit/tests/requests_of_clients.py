"""The binary frames that clients send; the server only reads them."""

from __future__ import annotations

import struct


def service_request(service_id: int, call_id: int, payload: bytes, encoding: str = "json") -> bytes:
    """Return a call of a service."""
    name = encoding.encode()
    return struct.pack("<BIII", 2, service_id, call_id, len(name)) + name + payload


def client_message(channel_id: int, payload: bytes) -> bytes:
    """Return a message on a channel of the client."""
    return struct.pack("<BI", 1, channel_id) + payload
