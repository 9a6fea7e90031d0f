"""Writers and readers that lose nothing: numbers, acknowledgements, repeats; DDSI-RTPS 2.3, section 8.4."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from nrp_world_ros.ros2.rtps import packets
from nrp_world_ros.ros2.rtps.packets import PREFIX, Data, Gap, Heartbeat, Nack
from nrp_world_ros.ros2.rtps.parameters import Address

ANY = bytes(4)
_KEPT = 64
"""Maximum number of samples of a writer for those that have not acknowledged them."""

_AHEAD = 256
"""How far ahead of the first lacking sample others are taken; the writer sends the rest again."""

_LARGEST, _MOST_PARTS, _UNFINISHED = 1 << 24, 1 << 14, 4
"""Maximum length of a sample in fragments, number of fragments, and number of such samples at a time: their
memory is reserved when the first fragment comes."""

Send = Callable[[bytes, Iterable[Address], bytes], None]
"""Sends a submessage to a participant at its addresses."""


@dataclass(frozen=True, slots=True)
class Sample:
    """A sent sample; ``to`` is the participant that it is for, or empty: all."""

    payload: bytes
    inline: Mapping[int, bytes]
    to: bytes


@dataclass(slots=True)
class _Listener:
    """A reader elsewhere; it has all samples before ``base``."""

    addresses: tuple[Address, ...]
    base: int


class Writer:
    """Sends samples to readers, and again until they acknowledge them.

    Args:
        entity: the last part of its GUID.
        send: sends a submessage.
    """

    def __init__(self, entity: bytes, send: Send) -> None:
        self.entity, self._send = entity, send
        self._samples: dict[int, Sample] = {}
        self._listeners: dict[bytes, _Listener] = {}
        self._last = self._count = 0

    def match(self, reader: bytes, addresses: tuple[Address, ...], *, late: bool) -> None:
        """Begin to send to a reader: all samples if it may come late, else those for its participant."""
        if reader in self._listeners:
            self._listeners[reader].addresses = addresses
            return
        old = [number for number, sample in self._samples.items() if late or sample.to == reader[:PREFIX]]
        listener = self._listeners[reader] = _Listener(addresses, min(old, default=self._last + 1))
        self._pass_on(reader, listener, range(listener.base, self._last + 1))
        self._ask(reader, listener)

    def leave(self, guid: bytes) -> None:
        """Forget a reader, or all of a participant."""
        for reader in [each for each in self._listeners if each.startswith(guid)]:
            del self._listeners[reader]

    def write(self, payload: bytes, inline: Mapping[int, bytes] | None = None, to: bytes = b"") -> None:
        """Send a sample, to one participant or to all."""
        self._last += 1
        self._samples[self._last] = Sample(payload, inline or {}, to)
        if to:
            self._samples.pop(self._last - _KEPT, None)
        for reader, listener in self._listeners.items():
            self._pass_on(reader, listener, [self._last])
            self._ask(reader, listener)

    def acknowledged(self, nack: Nack) -> None:
        """Note what a reader has, and send what it lacks."""
        listener = self._listeners.get(nack.reader)
        if listener is not None:
            listener.base = max(listener.base, nack.base)
            self._pass_on(nack.reader, listener, sorted(nack.lacks))
            if not nack.final:
                self._ask(nack.reader, listener)

    def remind(self) -> None:
        """Ask those readers for an acknowledgement that owe one."""
        for reader, listener in self._listeners.items():
            if listener.base <= self._last:
                self._ask(reader, listener)

    def _pass_on(self, reader: bytes, listener: _Listener, numbers: Iterable[int]) -> None:
        to, entity = reader[:PREFIX], reader[PREFIX:]
        for number in numbers:
            sample = self._samples.get(number)
            if sample is None or sample.to not in (b"", to):
                self._send(to, listener.addresses, packets.gap(self.entity, entity, [number]))
                continue
            for part in packets.data(self.entity, entity, number, sample.payload, sample.inline):
                self._send(to, listener.addresses, part)

    def _ask(self, reader: bytes, listener: _Listener) -> None:
        self._count += 1
        first = min(self._samples, default=self._last + 1)
        what = packets.heartbeat(self.entity, reader[PREFIX:], first, self._last, self._count)
        self._send(reader[:PREFIX], listener.addresses, what)


@dataclass(slots=True)
class _Speaker:
    """A writer elsewhere; its samples before ``base`` have come, or will not."""

    addresses: tuple[Address, ...]
    base: int = 1
    come: set[int] = field(default_factory=set)
    parts: dict[int, tuple[bytearray, set[int]]] = field(default_factory=dict)
    """What is there of samples in fragments, and the numbers of the lacking ones."""
    count: int = 0

    def wants(self, number: int) -> bool:
        """Return whether a sample is new, and not so far ahead that keeping it could fill the memory."""
        return self.base <= number < self.base + _AHEAD and number not in self.come

    def start(self, base: int) -> None:
        """Wait no more for what is before a number."""
        if base > self.base:
            self.base = base
            self.come = {number for number in self.come if number >= base}
            self.note(())

    def note(self, numbers: Iterable[int]) -> None:
        """Wait for these no more."""
        self.come.update(filter(self.wants, numbers))
        while self.base in self.come:
            self.come.discard(self.base)
            self.base += 1
        self.parts = {number: parts for number, parts in self.parts.items() if self.wants(number)}

    def whole(self, data: Data) -> bytes | None:
        """Return the sample that these data complete, or None."""
        if data.part is None:
            return data.payload
        first, size, total = data.part.first, data.part.size, data.part.total
        start = (first - 1) * size
        if not 0 <= start < total <= min(_LARGEST, _MOST_PARTS * size):
            return None
        if data.number not in self.parts:
            if len(self.parts) >= _UNFINISHED:
                return None
            self.parts[data.number] = (bytearray(total), set(range(1, 1 + -(-total // size))))
        found, lacks = self.parts[data.number]
        if len(found) != total:
            return None
        found[start : start + len(data.payload)] = data.payload[: total - start]
        lacks.difference_update(range(first, first + -(-len(data.payload) // size)))
        if lacks:
            return None
        del self.parts[data.number]
        return bytes(found)


class Reader:
    """Takes each sample of its writers once, and asks for those that were lost.

    Args:
        entity: the last part of its GUID.
        send: sends a submessage.
        take: takes a sample and its data.
    """

    def __init__(self, entity: bytes, send: Send, take: Callable[[Data, bytes], None]) -> None:
        self.entity, self._send, self._take = entity, send, take
        self._speakers: dict[bytes, _Speaker] = {}

    def match(self, writer: bytes, addresses: tuple[Address, ...]) -> None:
        """Begin to take samples of a writer."""
        speaker = self._speakers.setdefault(writer, _Speaker(addresses))
        speaker.addresses = addresses
        self._acknowledge(writer, speaker, ())

    def leave(self, guid: bytes) -> None:
        """Forget a writer, or all of a participant."""
        for writer in [each for each in self._speakers if each.startswith(guid)]:
            del self._speakers[writer]

    def took(self, data: Data) -> None:
        """Take a sample, unless it has come before."""
        speaker = self._speakers.get(data.writer)
        if speaker is None or not speaker.wants(data.number):
            return
        payload = speaker.whole(data)
        if payload is not None:
            speaker.note([data.number])
            self._take(data, payload)

    def skipped(self, gap: Gap) -> None:
        """Note that samples will not come."""
        speaker = self._speakers.get(gap.writer)
        if speaker is not None:
            if gap.first <= speaker.base:
                speaker.start(gap.until)
            speaker.note([*range(gap.first, gap.until)[:_AHEAD], *gap.others])

    def asked(self, heartbeat: Heartbeat) -> None:
        """Tell a writer what lacks."""
        speaker = self._speakers.get(heartbeat.writer)
        if speaker is None:
            return
        speaker.start(heartbeat.first)
        span = range(speaker.base, heartbeat.last + 1)[:_KEPT]
        lacks = [number for number in span if number not in speaker.come]
        if lacks or not heartbeat.final:
            self._acknowledge(
                heartbeat.writer, speaker, [each for each in lacks if each not in speaker.parts]
            )
        for number in lacks:
            if number in speaker.parts:
                self._ask_for_parts(heartbeat.writer, speaker, number)

    def _acknowledge(self, writer: bytes, speaker: _Speaker, lacks: Iterable[int]) -> None:
        speaker.count += 1
        what = packets.acknack(self.entity, writer[PREFIX:], speaker.base, lacks, speaker.count)
        self._send(writer[:PREFIX], speaker.addresses, what)

    def _ask_for_parts(self, writer: bytes, speaker: _Speaker, number: int) -> None:
        speaker.count += 1
        _, lacks = speaker.parts[number]
        what = packets.nack_frag(self.entity, writer[PREFIX:], number, lacks, speaker.count)
        self._send(writer[:PREFIX], speaker.addresses, what)
