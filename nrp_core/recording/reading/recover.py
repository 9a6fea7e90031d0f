"""Write the intact part of an incomplete or damaged file to a proper file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from nrp_core._support.files import replacing, writing
from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError
from nrp_core.messages.cdr import Codec
from nrp_core.recording.reading.mcap_messages import McapMessages
from nrp_core.recording.reading.reader import RecordingReader
from nrp_core.recording.writing.writer import McapFile

DAMAGED = "damaged"


@dataclass(frozen=True, slots=True)
class Recovered:
    """The result of a recovery.

    Args:
        file: the intact file.
        messages: number of its messages.
        until_s: simulated time of the last one, s.
        kept: the new path of the damaged file; None if it was intact.
        lost: number of messages that the damaged file had and this one lacks; None if unknown.
    """

    file: Path
    messages: int
    until_s: float
    kept: Path | None
    lost: int | None = 0


def recover(recording: RecordingReader, target: Path | None = None) -> Recovered:
    """Write all intact messages to a proper file, also those after damage.

    Args:
        recording: a truncated or damaged recording; a complete one is not changed.
        target: the new file, or one to replace; by default the result replaces the damaged file, which is
            kept beside it.

    Raises:
        ExperimentError: the disk is full, the file is from another program, or has
            no intact message; then nothing is changed.
    """
    source = recording.file
    if target is None and recording.complete:
        return Recovered(source, *_count(recording), None)
    kept = _free(source) if target is None else source
    with writing(target or source), replacing(target or source) as draft:
        messages, until_s, lost = _write(recording, draft)
        if not messages:
            raise ExperimentError("it does not have one intact message of a recording", path=source)
        if target is None:
            source.replace(kept)
    return Recovered(target or source, messages, until_s, kept, lost)


def _write(recording: RecordingReader, target: Path) -> tuple[int, float, int | None]:
    """Return the number of messages, the time of the last one, s, and the number of lost messages."""
    recovered, last_ns = McapFile(target, Codec({})), 0
    intact = McapMessages(recording.file, past_damage=True)
    try:
        for topic, message in intact:
            if message is None:
                continue
            if not recovered.knows(topic.name):
                recording.define(recovered.codec, topic)
                recovered.announce(topic.name, topic.type_name, topic.about)
            recovered.write(topic.name, message.log_time, (message.data,))
            last_ns = max(last_ns, message.log_time)
    finally:
        recovered.close()
    lost = None if intact.expected is None else intact.expected - intact.count
    return sum(recovered.counts.values()), seconds(last_ns), lost


def _count(recording: RecordingReader) -> tuple[int, float]:
    count = last_ns = 0
    for _, message in recording.raw():
        count, last_ns = count + 1, max(last_ns, message.log_time)
    return count, seconds(last_ns)


def _free(file: Path) -> Path:
    """Return an unused name beside a file."""
    number, free = 1, file.with_suffix(f".{DAMAGED}{file.suffix}")
    while free.exists():
        number += 1
        free = file.with_suffix(f".{DAMAGED}-{number}{file.suffix}")
    return free
