"""Check that every byte of a recording is unchanged; nothing is run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xxhash
from mcap.records import Message

from nrp_core._support.files import lock
from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError
from nrp_core.messages.cdr import Codec
from nrp_core.messages.nrp_msgs import StepHash
from nrp_core.recording.layout import (
    CSV_FOLDER,
    EXPERIMENT_NAME,
    FILES_FOLDER,
    MCAP_NAME,
    RUN_NAME,
    RUNNING,
    STEPS,
    Role,
)
from nrp_core.recording.reading.mcap_messages import McapMessages, RecordedTopic
from nrp_core.recording.reading.tables import unread_chunk
from nrp_core.recording.sealing import DAMAGED, file_digest, read_sealed
from nrp_core.recording.writing.encoding import PACKED_BYTES
from nrp_core.recording.writing.hashes import BRAIN, GROUP_OF, GROUPS, VOLTAGES_EVERY, Chain, hash_of

_IMAGE = "sensor_msgs/msg/Image"


@dataclass(frozen=True, slots=True)
class ChainCheck:
    """The valid part of the chain of hashes of a recording.

    Args:
        steps: the number of steps that match their hashes, without the initial state.
        until_ns: end of the last of them, ns; None if not even the initial state matches.
        problem: a description of the first mismatch, or None.
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


MISSING = "is missing"
_FEWER_DIGESTS = 3
"""In recordings up to this format, only the files of the experiment have digests."""


@dataclass(frozen=True, slots=True)
class Flaw:
    """A damaged or missing file of a recording.

    Args:
        file: its path in the recording.
        problem: such as ``is missing``.
        holds: its contents, or the damaged part of them; empty if unknown.
    """

    file: str
    problem: str
    holds: str = ""

    def __str__(self) -> str:
        return f"{self.file}{f' ({self.holds})' if self.holds else ''} {self.problem}"


@dataclass(frozen=True, slots=True)
class IntegrityCheck:
    """The result of a check.

    Args:
        flaws: the damaged and missing files.
        finished: whether the recording was completed, which it is not if the run was killed.
        undigested: files of the recording without a digest.
        unlisted: files that are not part of the recording.
        files, size: the number of files that were compared with their digests, and their size in bytes.
        chain: how far the messages match the hashes of their steps; None if a digest covers them all.
        is_growing: whether a process is writing the recording.
    """

    flaws: tuple[Flaw, ...]
    finished: bool
    undigested: tuple[str, ...] = ()
    unlisted: tuple[str, ...] = ()
    files: int = 0
    size: int = 0
    chain: ChainCheck | None = None
    is_growing: bool = False

    @property
    def intact(self) -> bool:
        """Whether every byte has a digest and matches it."""
        return self.finished and not self.flaws and not self.undigested

    @property
    def notes(self) -> list[str]:
        """Remarks about it that are not flaws, as texts."""
        notes = []
        if not self.finished and self.chain is not None:
            end = "" if self.chain.until_ns is None else self._end(self.chain.until_ns)
            unfinished = "is unfinished, because its run was killed or continues"
            notes.append(f"the recording {'is being written' if self.is_growing else unfinished}{end}")
        elif self.undigested:
            files = " and ".join(self.undigested)
            notes.append(f"the recording has no digest of {files}, because an earlier version made it")
        notes += [f"{name} is not part of the recording" for name in self.unlisted]
        return notes

    def _end(self, until_ns: int) -> str:
        return f": it has {seconds(until_ns):g} s, which match the hashes of their steps"


def check_messages(file: Path) -> IntegrityCheck:
    """Check a file of messages without its folder."""
    grows = _is_growing(file)
    chain, problems = _check_chain(file, None, finished=False, grows=grows)
    return IntegrityCheck(
        tuple(problems), finished=False, undigested=(file.name,), chain=chain, is_growing=grows
    )


def check_folder_of(folder: Path) -> IntegrityCheck:
    """Compare every file of a recording with its digest, and messages without one with their hashes.

    Without an intact ``run.json`` they cannot be compared.
    """
    try:
        run = read_sealed(folder / RUN_NAME)
    except ExperimentError as error:
        problem = error.message if (folder / RUN_NAME).exists() else MISSING
        return IntegrityCheck(
            (Flaw(RUN_NAME, problem, "the description of the run, and the digests of all other files"),),
            finished=False,
        )
    digests = digests_of(run)
    flaws = list(_find_changed(folder, digests, run))
    finished = run.get("state", RUNNING) != RUNNING and (MCAP_NAME in digests or _has_fewer(run))
    chain, grows = None, not finished and _is_growing(folder / MCAP_NAME)
    if MCAP_NAME not in digests:
        chain, problems = _check_chain(folder / MCAP_NAME, _beginning(run), finished=finished, grows=grows)
        flaws += problems
    own = [name for name in (MCAP_NAME, EXPERIMENT_NAME) if (folder / name).is_file()]
    present = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    return IntegrityCheck(
        tuple(flaws),
        finished,
        undigested=tuple(name for name in own if name not in digests),
        unlisted=tuple(sorted(present - {RUN_NAME, *own, *digests})),
        files=len(digests),
        size=sum((folder / name).stat().st_size for name in digests if name in present),
        chain=chain,
        is_growing=grows,
    )


def _is_growing(file: Path) -> bool:
    """Return whether a process is writing a file of messages."""
    try:
        with file.open("rb") as opened:
            lock(opened, shared=True)
    except BlockingIOError:
        return True
    except OSError:  # it is missing, or the file system has no locks
        pass
    return False


def digests_of(run: Mapping[str, Any]) -> dict[str, str]:
    """Return the digests of files in ``run.json``, by path in the recording."""
    digests = dict(run.get("files") or {})
    return {f"{FILES_FOLDER}/{name}": one for name, one in digests.items()} if _has_fewer(run) else digests


def _has_fewer(run: Mapping[str, Any]) -> bool:
    return int(run.get("format", _FEWER_DIGESTS)) <= _FEWER_DIGESTS


def _find_changed(folder: Path, digests: Mapping[str, str], run: Mapping[str, Any]) -> Iterator[Flaw]:
    for name, digest in digests.items():
        path = folder / name
        try:
            if not path.is_file():
                yield Flaw(name, MISSING, _part(name, run))
            elif file_digest(path) != digest:
                yield Flaw(name, DAMAGED, _damage(path) if name == MCAP_NAME else _part(name, run))
        except OSError as error:
            yield Flaw(name, f"cannot be read: {error.strerror}", _part(name, run))


def _part(name: str, run: Mapping[str, Any]) -> str:
    """Return a description of the contents of a file, as far as known."""
    parts = {MCAP_NAME: "every message", EXPERIMENT_NAME: "the experiment as it was run"}
    if name.startswith(f"{CSV_FOLDER}/"):
        return "rows that functions recorded"
    inside = name.removeprefix(f"{FILES_FOLDER}/")
    return parts.get(name) or next(_keys_of(run.get("settings"), inside), "")


def _keys_of(settings: Any, name: str, key: str = "") -> Iterator[str]:
    """Yield the keys of an experiment that have the path of a file as their value."""
    if isinstance(settings, str) and f"/{settings}".endswith(f"/{name}"):
        yield key
    elif isinstance(settings, dict):
        for own, value in settings.items():
            yield from _keys_of(value, name, f"{key}.{own}" if key else own)
    elif isinstance(settings, list):
        for value in settings:
            yield from _keys_of(value, name, key)


def _damage(file: Path) -> str:
    """Return a description of the messages of a file that are lost."""
    messages, last_ns = McapMessages(file), None
    for _, message in messages:
        last_ns = last_ns if message is None else message.log_time
    return _unread(messages, last_ns)


def _unread(messages: McapMessages, last_ns: int | None) -> str:
    if messages.all_read:
        return "all messages are intact, the data around them is not"
    return "every message" if last_ns is None else f"messages after {seconds(last_ns):g} s"


def _beginning(run: Mapping[str, Any]) -> Chain:
    """Return the chain of hashes before the first step."""
    if run.get("continues"):
        return Chain(run["continues"]["chain"])
    return Chain.of(run["brain"]["network"], run["world"]["scene"], run["seed"])


def _check_chain(
    file: Path, begin: Chain | None, *, finished: bool, grows: bool
) -> tuple[ChainCheck, list[Flaw]]:
    """Check the hashes of the messages; a file that was not closed may lack its end."""
    if not file.is_file():
        return ChainCheck(), [Flaw(file.name, MISSING, "every message")]
    messages = McapMessages(file)
    chain = check_chain(messages, begin)
    if chain.problem is not None:
        return chain, [Flaw(file.name, DAMAGED, chain.problem)]
    if grows or _is_sound(messages, finished=finished):
        return chain, []
    return chain, [Flaw(file.name, DAMAGED, _unread(messages, chain.until_ns))]


def _is_sound(messages: McapMessages, *, finished: bool) -> bool:
    """Return whether everything that was written to a file was read, up to its end or where a kill cut it."""
    if finished or messages.ends:
        return messages.whole if finished else messages.all_read
    return not messages.broken and unread_chunk(messages) is None
