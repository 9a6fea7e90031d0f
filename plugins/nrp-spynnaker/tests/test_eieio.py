"""Packets of EIEIO, written out by hand from the layout of the protocol."""

from __future__ import annotations

import struct

import pytest
from golden import Golden
from nrp_spynnaker.live.packets import KEY_32_BIT, KEY_PAYLOAD_32_BIT, keys_of, packets


@pytest.mark.parametrize(
    ("packet", "keys"),
    [
        ("02 08  01 00 07 00  05 00 07 00", [0x70001, 0x70005]),  # keys of 32 bits
        ("01 0c  01 00 07 00  2a 00 00 00", [0x70001]),  # and a payload each
        ("01 38  2a 00 00 00  01 00 07 00", [0x70001]),  # and a time for all
        ("02 00  01 00  05 00", [0x90001, 0x90005]),  # 16 bits: the upper half is that of the receiver
        ("02 c0  07 00  01 00  05 00", [0x70001, 0x70005]),  # or a prefix
        ("01 80  04 00  01 00", [5]),  # of the lower half
        ("01 04  01 00  2a 00", [0x90001]),  # 16 bits and a payload each
        ("01 30  2a 00  01 00", [0x90001]),  # and a time for all
        ("00 08", []),
    ],
)
def test_keys_are_found_in_every_kind_of_packet(packet: str, keys: list[int]) -> None:
    assert keys_of(bytes.fromhex(packet), upper=9) == keys


@pytest.mark.parametrize(
    "packet",
    [
        "01",
        "01 40",
        "01 80 04",
        "02 08  01 00 07 00",
    ],
)
def test_a_packet_without_spikes_is_refused(packet: str, golden: Golden) -> None:
    with golden.raises(ValueError):
        keys_of(bytes.fromhex(packet))


def test_the_spikes_of_a_step_are_divided_among_packets_that_a_machine_takes() -> None:
    keys = list(range(0x10000, 0x10000 + 200))
    one = list(packets(keys[:2], 42))
    assert one == [bytes.fromhex("02 38  2a 00 00 00  00 00 01 00  01 00 01 00")]
    for kind in (KEY_32_BIT, KEY_PAYLOAD_32_BIT):
        many = list(packets(keys, 42, kind))
        assert all(len(packet) <= 256 for packet in many)
        assert [key for packet in many for key in keys_of(packet)] == keys
    assert struct.unpack("<BBII", next(packets(keys[:1], 42, KEY_PAYLOAD_32_BIT))) == (1, 0x1C, 0x10000, 42)
