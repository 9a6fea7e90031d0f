"""Check the messages of a recording against the hashes of its steps, and these against their chain."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import xxhash
from mcap.records import Message

from nrp_core.clock import seconds
from nrp_core.recording.layout import STEPS, Role
from nrp_core.recording.reading.mcap_messages import RecordedTopic
from nrp_core.recording.writing.encoding import PACKED_BYTES
from nrp_core.recording.writing.hashes import BRAIN, GROUP_OF, GROUPS, VOLTAGES_EVERY, Chain, hash_of
from nrp_core.world.messages.cdr import Codec
from nrp_core.world.messages.nrp_msgs import StepHash

_IMAGE = "sensor_msgs/msg/Image"


@dataclass(frozen=True, slots=True)
class ChainCheck:
    """The valid part of the chain of hashes of a recording.

    Args:
        steps: the number of steps that match their hashes, without the initial state.
        until_ns: end of the last of them, ns; None if not even the initial state matches.
        problem: a description of the first mismatch; None if there is none.
    """

    steps: int = 0
    until_ns: int | None = None
    problem: str | None = None


def check_chain(messages: Iterable[tuple[RecordedTopic, Message | None]], begin: Chain | None) -> ChainCheck:
    """Follow the chain of hashes along all messages.

    In some steps the hash of the brain includes membrane voltages, which are not recorded; it is not checked.

    Args:
        messages: in the order of the file.
        begin: the chain before the first step; None if it is unknown.
    """
    codec, chain = Codec({}), begin
    found = ChainCheck()
    first: int | None = None
    counted = _nothing()
    for topic, message in messages:
        if message is None:
            continue
        if topic.name == STEPS:
            codec.define(topic.type_name, topic.definition)
            hashed: StepHash = codec.decode(message.data, topic.type_name)
            first = hashed.step if first is None else first
            expected = first if found.until_ns is None else first + found.steps + 1
            problem = next(_problems(hashed, counted, chain, expected), None)
            if problem is not None:
                at = f"step {hashed.step}, {seconds(message.log_time):g} s"
                return ChainCheck(found.steps, found.until_ns, f"{at}: {problem}")
            found = ChainCheck(hashed.step - first, message.log_time)
            chain, counted = Chain(hashed.chain), _nothing()
        elif (group := GROUP_OF.get(topic.role)) is not None:
            counted[group].append(topic.name.encode())
            counted[group] += _parts(codec, topic, message.data)
    return found


def _problems(hashed: StepHash, counted: list[list[Any]], chain: Chain | None, step: int) -> Iterator[str]:
    """Return the mismatches of a step with its hashes."""
    if hashed.step != step:
        yield f"step {step} is missing"
    hashes = [hashed.brain, hashed.world, hashed.inputs, hashed.outputs]
    for group, (name, parts) in enumerate(zip(GROUPS, counted, strict=True)):
        is_known = group != BRAIN or hashed.step % VOLTAGES_EVERY
        if is_known and hash_of(parts) != hashes[group]:
            yield f"the messages of the {name} do not match their hash"
    if chain is not None and chain.add(hashes) != hashed.chain:
        yield "the hash does not follow from the one before"


def _parts(codec: Codec, topic: RecordedTopic, data: bytes) -> tuple[bytes, ...]:
    """Return the hashed bytes of a message; for a large image, with the hash of its pixels."""
    if topic.role == Role.CAMERA and topic.type_name == _IMAGE:
        codec.define(topic.type_name, topic.definition)
        size = codec.decode(data, _IMAGE).data.nbytes
        if size >= PACKED_BYTES:
            return data[:-size], xxhash.xxh3_128_digest(data[-size:])
    return (data,)


def _nothing() -> list[list[Any]]:
    return [[] for _ in GROUPS]
