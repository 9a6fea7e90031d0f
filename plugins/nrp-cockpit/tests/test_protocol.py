"""The frames of the protocol, written by one side and read by the other."""

from __future__ import annotations

import json
import struct
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from nrp_cockpit.wire import protocol
from nrp_cockpit.wire.frames import frame
from nrp_cockpit.wire.protocol import ClientMessage, ProtocolError, ServiceRequest
from requests_of_clients import client_message, service_request
from websockets.frames import Frame, Opcode
from websockets.streams import StreamReader

ids = st.integers(0, (1 << 32) - 1)
times_ns = st.integers(0, (1 << 64) - 1)
values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=10,
)


@given(ids, ids, st.text(max_size=20), st.binary(max_size=200))
def test_a_request_is_read_as_it_was_written(service: int, call: int, encoding: str, payload: bytes) -> None:
    frame = service_request(service, call, payload, encoding)
    assert protocol.read_binary(frame) == ServiceRequest(service, call, encoding, payload)


@given(ids, st.binary(max_size=200))
def test_a_message_of_a_client_is_read_as_it_was_written(channel: int, payload: bytes) -> None:
    assert protocol.read_binary(client_message(channel, payload)) == ClientMessage(channel, payload)


@given(st.text("abcdefghij", min_size=1), st.dictionaries(st.text(), values, max_size=4))
def test_a_text_is_read_as_it_was_written(operation: str, fields: dict[str, Any]) -> None:
    message = {**fields, "op": operation}
    assert protocol.read_text(json.dumps(message)) == message


@given(ids, times_ns, st.binary(max_size=200))
def test_data_are_read_as_they_were_written(subscription: int, t_ns: int, payload: bytes) -> None:
    frame = protocol.data_head(subscription, t_ns) + payload
    assert struct.unpack_from("<BIQ", frame) == (1, subscription, t_ns)
    assert frame[13:] == payload


@given(st.one_of(st.text(max_size=200), st.lists(st.binary(max_size=200), max_size=3)))
@example("")
@example([bytes(125)])
@example([bytes(60), bytes(66)])
@example([bytes((1 << 16) - 1)])
@example([b"head", bytes(1 << 16)])
def test_a_message_in_its_frame_is_read_by_another_program_as_it_was_written(
    message: str | list[bytes],
) -> None:
    reader = StreamReader()
    for piece in frame(message):
        reader.feed_data(piece)
    reader.feed_eof()
    reading = Frame.parse(reader.read_exact, mask=False)
    with pytest.raises(StopIteration) as found:
        next(reading)
    is_text = isinstance(message, str)
    expected = message.encode() if isinstance(message, str) else b"".join(message)
    assert found.value.value == Frame(Opcode.TEXT if is_text else Opcode.BINARY, expected)
    with pytest.raises(StopIteration):
        next(reader.read_to_eof(0))


@given(ids, ids, st.binary(max_size=200))
def test_an_answer_is_read_as_it_was_written(service: int, call: int, payload: bytes) -> None:
    frame = protocol.answer(ServiceRequest(service, call, "json", b""), payload)
    operation, of_service, of_call, length = struct.unpack_from("<BIII", frame)
    assert (operation, of_service, of_call) == (3, service, call)
    assert (frame[13 : 13 + length], frame[13 + length :]) == (b"json", payload)


@given(ids, ids, st.text(max_size=20), st.data())
def test_a_request_that_is_cut_before_its_payload_is_refused(
    service: int, call: int, encoding: str, data: st.DataObject
) -> None:
    frame = service_request(service, call, b"", encoding)
    length = data.draw(st.integers(0, len(frame) - 1))
    with pytest.raises(ProtocolError):
        protocol.read_binary(frame[:length])


@given(ids, st.integers(0, 4))
def test_a_message_that_is_cut_before_its_payload_is_refused(channel: int, length: int) -> None:
    with pytest.raises(ProtocolError):
        protocol.read_binary(client_message(channel, b"")[:length])


@given(st.binary(max_size=40))
def test_any_bytes_are_read_or_refused(frame: bytes) -> None:
    with suppress(ProtocolError):
        assert isinstance(protocol.read_binary(frame), ServiceRequest | ClientMessage)


@given(st.text(max_size=40) | values.map(json.dumps))
def test_any_text_is_read_or_refused(text: str) -> None:
    with suppress(ProtocolError):
        assert isinstance(protocol.read_text(text)["op"], str)


@pytest.mark.parametrize("text", ["[" * 100_000, '{"op": 3}', '{"channels": []}', "[]", ""])
def test_a_text_without_an_operation_is_refused(text: str) -> None:
    with pytest.raises(ProtocolError):
        protocol.read_text(text)


@pytest.mark.parametrize(
    ("number", "fits"),
    [(0, True), ((1 << 32) - 1, True), (1 << 32, False), (-1, False), (True, False), ("1", False)],
)
def test_an_id_has_32_bits(number: object, fits: bool) -> None:
    assert protocol.is_id(number) is fits
