"""The protocol: what is sent is what arrives, and a broken answer is noticed."""

import socket
import struct
from pathlib import Path

import numpy as np
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st
from nrp_world_gazebo.wire import VERSION, Channel, EndedError, RefusedError, contacts, frame, operation

FLOATS = st.floats(allow_nan=False)
ROWS = st.lists(st.tuples(*[st.integers(0, 2**32 - 1)] * 2, *[FLOATS] * 10), max_size=4)
SOURCES = Path(__file__).parents[1] / "gazebo"


def pair() -> tuple[Channel, socket.socket]:
    here, there = socket.socketpair()
    here.settimeout(2.0)
    return Channel(here), there


@given(st.lists(st.integers(0, 2**32 - 1), max_size=3), st.lists(FLOATS, max_size=5))
def test_an_operation_holds_its_letter_and_numbers_in_order(numbers, values):
    letter, *read = struct.unpack(f"<c{len(numbers)}I{len(values)}d", operation("w", *numbers, values=values))
    assert (letter, read) == (b"w", [*numbers, *values])


@given(ROWS, st.binary(max_size=9))
@settings(max_examples=30)
def test_contacts_are_read_as_they_were_packed_and_the_rest_is_kept(rows, rest):
    packed = struct.pack("<I", len(rows)) + b"".join(struct.pack("<2I10d", *row) for row in rows)
    links, numbers, left = contacts(memoryview(packed + rest))
    assert links == [row[:2] for row in rows]
    assert np.array_equal(numbers, np.array([row[2:] for row in rows]).reshape(-1, 10))
    assert bytes(left) == rest


@given(st.binary(max_size=200), st.integers(1, 7))
def test_an_answer_that_arrives_in_pieces_is_put_together(content, size):
    channel, there = pair()
    sent = frame(b"\0" + content)
    there.sendall(sent[:size])
    there.sendall(sent[size:])
    assert bytes(channel.ask(b"x")) == content
    assert there.recv(9) == frame(b"x")
    channel.close()
    there.close()


def test_an_answer_with_an_error_is_refused_with_its_text(golden: Golden):
    channel, there = pair()
    there.sendall(frame(b"\1no such joint"))
    with golden.raises(RefusedError):
        channel.ask(b"x")
    channel.close()
    there.close()


def test_an_answer_that_is_cut_off_ends_the_connection():
    channel, there = pair()
    there.sendall(frame(b"\0" + b"12345678")[:-1])
    there.close()
    with pytest.raises(EndedError):
        channel.ask(b"x")
    channel.close()


def test_both_sides_have_the_same_version():
    assert f"kVersion = {VERSION};" in (SOURCES / "wire.hh").read_text()
