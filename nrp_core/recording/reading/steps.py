"""A recording step by step, and the first difference of another run from it."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.text import join_with_limit
from nrp_core.clock import seconds
from nrp_core.messages.cdr import Codec
from nrp_core.messages.nrp_msgs import Called, Published, Spikes, StepHash
from nrp_core.recording.layout import CALLED, PUBLISHED, STEPS
from nrp_core.recording.reading.mcap_messages import RecordedTopic
from nrp_core.recording.reading.reader import RecordingReader
from nrp_core.recording.writing.encoding import join_parts
from nrp_core.recording.writing.hashes import BRAIN, GROUP_OF, GROUPS, INPUTS, OUTPUTS, WORLD, Step

_MOST_VALUES = 3
_MOST_ITEMS = 1000
"""Maximum number of values of an array that are compared; the rest, as of images, by a hash."""


@dataclass(slots=True)
class RecordedStep:
    """One step of a recording.

    Args:
        hash: its hashes, and its number.
        t_ns: its end, ns.
        messages: its recorded messages that are hashed, in order: topic and bytes.
        from_outside: messages published from outside before it.
        calls: other calls from outside before it.
    """

    hash: StepHash
    t_ns: int
    messages: list[tuple[RecordedTopic, bytes]] = field(default_factory=list)
    from_outside: list[tuple[str, Any]] = field(default_factory=list)
    calls: list[Called] = field(default_factory=list)

    @property
    def hashes(self) -> tuple[str, str, str, str]:
        """Its hashes, in the order of the groups."""
        return self.hash.brain, self.hash.world, self.hash.inputs, self.hash.outputs


def steps_of(recording: RecordingReader) -> Iterator[RecordedStep]:
    """Yield the steps of a recording, starting with the state before the first step."""
    codec = Codec({})
    messages: list[tuple[RecordedTopic, bytes]] = []
    published: list[Published] = []
    calls: list[Called] = []
    for topic, record in recording.raw():
        if topic.name == STEPS:
            hashed: StepHash = recording.decoded(codec, topic, record.data)
            from_outside = [(one.topic, codec.decode(bytes(one.data), one.type)) for one in published]
            yield RecordedStep(hashed, record.log_time, messages, from_outside, calls)
            messages, published, calls = [], [], []
        elif topic.name == PUBLISHED:
            published.append(recording.decoded(codec, topic, record.data))
        elif topic.name == CALLED:
            calls.append(recording.decoded(codec, topic, record.data))
        elif topic.role in GROUP_OF:
            messages.append((topic, record.data))
            if published:  # messages from outside are recorded on their own topics, too, with their types
                codec.define(topic.type_name, topic.definition)


@dataclass(frozen=True, slots=True)
class Difference:
    """The first difference of a run from a recording.

    Args:
        step: number of the step.
        t_ns: its end, ns.
        group: ``brain``, ``world``, ``inputs`` or ``outputs``.
        signal: the topic, or the kind of another difference.
        recorded, now: short descriptions of the recorded and the present value.
    """

    step: int
    t_ns: int
    group: str
    signal: str
    recorded: str
    now: str

    def __str__(self) -> str:
        return (
            f"step {self.step}, {seconds(self.t_ns):g} s: {self.signal} ({self.group}) "
            f"was {self.recorded}, now is {self.now}"
        )


class Comparison:
    """Compares the steps of a run with those that were recorded.

    Args:
        groups: the groups to compare, in this order.
        noise: numbers of a message are equal if they differ by less than this share of the largest of
            them, or of 1. Above 0, differences of hashes alone are ignored, because they may be noise.

    Attributes:
        difference: the first difference; None so far.
        steps: number of steps that were compared.
    """

    def __init__(self, groups: Collection[str] = GROUPS, *, noise: float = 0.0) -> None:
        self.difference: Difference | None = None
        self.steps = 0
        self._noise = noise
        self._groups = [index for index, name in enumerate(GROUPS) if name in groups]

    def add(
        self,
        recorded: RecordedStep,
        step: Step,
        hashes: Sequence[str],
        codec: Codec,
    ) -> None:
        """Compare one more step, unless there was a difference already.

        Args:
            recorded: the recorded step.
            step: the present step.
            hashes: its hashes.
            codec: decodes the messages.
        """
        if self.difference is None:
            after = [
                (entry.topic, entry.about["role"], codec.name(entry.kind), join_parts(entry.parts))
                for entry in step.entries
            ]
            self._add(recorded, after, hashes, codec)

    def add_recorded(self, recorded: RecordedStep, other: RecordedStep, codec: Codec) -> None:
        """Compare a step of another recording, unless there was a difference already."""
        if self.difference is None:
            for topic, _ in (*recorded.messages, *other.messages):
                codec.define(topic.type_name, topic.definition)
            self._add(recorded, _messages(other), other.hashes, codec)

    def _add(
        self, recorded: RecordedStep, after: Sequence[_Message], hashes: Sequence[str], codec: Codec
    ) -> None:
        self.steps += 1
        before = _messages(recorded)
        found: dict[int, tuple[str, str, str]] = {}
        for group in self._groups:
            then, now = _in_group(before, group), _in_group(after, group)
            signal = self._first_different(then, now, codec)
            if signal is not None:
                found[group] = signal, *_describe(then, now, signal, codec)
            elif not self._noise and recorded.hashes[group] != hashes[group]:
                signal = "the membrane voltages" if group == BRAIN else "the hash alone"
                found[group] = signal, recorded.hashes[group], hashes[group]
        for group in _causes_first(found):
            signal, recorded_text, now_text = found[group]
            self.difference = Difference(
                recorded.hash.step, recorded.t_ns, GROUPS[group], signal, recorded_text, now_text
            )
            return

    def _first_different(self, then: Sequence[_Message], now: Sequence[_Message], codec: Codec) -> str | None:
        """Return the first topic with different messages."""
        for topic in dict.fromkeys(one[0] for one in (*then, *now)):
            ours, theirs = ([one[2:] for one in side if one[0] == topic] for side in (then, now))
            if ours != theirs and not (self._noise and _alike(ours, theirs, codec, self._noise)):
                return topic
        return None

    def ended(self, recorded: RecordedStep | None, error: str) -> None:
        """Record that the run ended before a recorded step, if any."""
        if self.difference is None and recorded is not None:
            self.difference = Difference(
                recorded.hash.step, recorded.t_ns, "run", "the run", "going on", f"ended by: {error}"
            )


_Message = tuple[str, str, str, bytes]
"""Topic, role, type and bytes of a message."""


def _messages(step: RecordedStep) -> list[_Message]:
    return [(topic.name, topic.role, topic.type_name, data) for topic, data in step.messages]


def _causes_first(groups: Collection[int]) -> list[int]:
    """Return groups that differ in one step, in an order in which the first explains the others.

    Sensor data of a robot follow from its pose. But commands act at once, so its motion after the step may
    follow from the outputs.
    """
    order = (BRAIN, WORLD, INPUTS, OUTPUTS) if INPUTS in groups else (BRAIN, OUTPUTS, WORLD)
    return [group for group in order if group in groups]


def _in_group(messages: Sequence[_Message], group: int) -> list[_Message]:
    return [one for one in messages if GROUP_OF.get(one[1]) == group]


def _alike(
    then: Sequence[tuple[str, bytes]], now: Sequence[tuple[str, bytes]], codec: Codec, noise: float
) -> bool:
    """Return whether messages (type and bytes) differ at most by noise in their numbers."""
    if [kind for kind, _ in then] != [kind for kind, _ in now]:
        return False
    pairs = zip(then, now, strict=True)
    return all(
        _alike_in_numbers(codec.decode(a, kind), codec.decode(b, kind), noise) for (kind, a), (_, b) in pairs
    )


def _alike_in_numbers(one: Any, other: Any, noise: float) -> bool:
    ours, theirs = dict(_leaves(one, "")), dict(_leaves(other, ""))
    if ours.keys() != theirs.keys():
        return False
    numbers = {path for path, value in ours.items() if isinstance(value, float | np.floating)}
    if any(ours[path] != theirs[path] for path in ours.keys() - numbers):
        return False
    paths = sorted(numbers)
    a, b = (np.array([side[path] for path in paths], float) for side in (ours, theirs))
    b = nearest_quaternions(paths, a, b)
    finite = np.isfinite(a) & np.isfinite(b)
    if not np.array_equal(a[~finite], b[~finite], equal_nan=True):
        return False
    a, b = a[finite], b[finite]
    scale = max(1.0, float(np.abs(a).max(initial=0.0)), float(np.abs(b).max(initial=0.0)))
    return bool((np.abs(a - b) <= noise * scale).all())


def nearest_quaternions(names: Sequence[str], one: FloatArray, other: FloatArray) -> FloatArray:
    """Return the other numbers with the signs of quaternions that bring them nearest to the first ones.

    A quaternion and its negative are the same orientation; for half turns, rounding decides the sign.

    Args:
        names: what the numbers are called; those of a quaternion differ only in their ends x, y, z and w.
        one: numbers of a message or of a time series, shape ``(..., len(names))``.
        other: the same numbers of another run.
    """
    index, nearest = {name: number for number, name in enumerate(names)}, other.copy()
    for name in names:
        four = [index[name[:-1] + end] for end in "xyzw" if name[:-1] + end in index]
        if name.endswith("w") and len(four) == 4:
            with np.errstate(invalid="ignore"):  # infinite numbers have no nearest sign
                opposite = (one[..., four] * other[..., four]).sum(axis=-1, keepdims=True) < 0
            nearest[..., four] = np.where(opposite, -other[..., four], other[..., four])
    return nearest


def _describe(then: Sequence[_Message], now: Sequence[_Message], topic: str, codec: Codec) -> tuple[str, str]:
    """Return short descriptions of the difference of a topic's messages: recorded and now."""
    decoded = [
        [codec.decode(data, kind) for name, _, kind, data in messages if name == topic]
        for messages in (then, now)
    ]
    if all(isinstance(one, Spikes) for own in decoded for one in own):
        trains = [{spike for one in own for spike in _spikes_of(one)} for own in decoded]
        if trains[0] != trains[1]:
            return _spike_words(trains[0] - trains[1]), _spike_words(trains[1] - trains[0])
    both = [dict(_leaves(own[0] if len(own) == 1 else own, "")) for own in decoded]
    if not all(both):  # a single message: the time in its header does not matter
        return tuple(_words(one, _without_header(one)) for one in both)  # type: ignore[return-value]
    paths = [path for path in {**both[0], **both[1]} if both[0].get(path) != both[1].get(path)]
    return _words(both[0], paths), _words(both[1], paths)


def _spikes_of(message: Spikes) -> Iterator[tuple[float, int]]:
    """Return times, ms, and neurons."""
    return zip(message.times_ms.tolist(), message.ids.tolist(), strict=True)


def _spike_words(spikes: Collection[tuple[float, int]]) -> str:
    words = [f"neuron {neuron} at {time_ms!r} ms" for time_ms, neuron in sorted(spikes)]
    return join_with_limit(words, _MOST_VALUES) or "nothing"


def _without_header(paths: Iterable[str]) -> list[str]:
    found = list(paths)
    return [path for path in found if not path.startswith(".header.")] or found


def _words(leaves: Mapping[str, Any], paths: Iterable[str]) -> str:
    words = [f"{path.strip('.') or 'value'} {leaves.get(path, 'missing')}" for path in paths]
    return join_with_limit(words, _MOST_VALUES) or "nothing"


def _leaves(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Return the values in a message with their paths."""
    if dataclasses.is_dataclass(value):
        for item in dataclasses.fields(value):
            yield from _leaves(getattr(value, item.name), f"{path}.{item.name}")
    elif isinstance(value, (list, np.ndarray)):
        for index, item in enumerate(value[:_MOST_ITEMS]):
            yield from _leaves(item, f"{path}[{index}]")
        if len(value) > _MOST_ITEMS:
            rest = np.asarray(value[_MOST_ITEMS:])
            yield f"{path} from [{_MOST_ITEMS}] on", hashlib.sha256(rest.tobytes()).hexdigest()[:8]
    else:
        yield path, value
