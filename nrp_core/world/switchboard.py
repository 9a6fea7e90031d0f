"""The switchboard: subscriptions, the schedule of samples, and the delivery of messages.

It is independent of physics. A topic without subscribers costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass, field, replace
from functools import partial
from math import isfinite
from types import MappingProxyType
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import SampleSchedule, from_seconds
from nrp_core.errors import TopicError, did_you_mean
from nrp_core.findings import Code
from nrp_core.messages.base import NumberLayout, layout_of, type_name
from nrp_core.seeds import Seeds
from nrp_core.simulation import Failures, Simulation, guarded, note_failure
from nrp_core.world.controllers.joint import JointGroup, effort_group
from nrp_core.world.engine import Engine
from nrp_core.world.part import Part
from nrp_core.world.topics import Direction, Publication, Stamped, Subscription, TopicInfo


@dataclass(frozen=True, slots=True)
class Saved:
    """The state of a switchboard: the messages in subscriptions, and the samples in flight."""

    started: bool
    messages: list[tuple[str, list[Stamped]]]
    in_flight: dict[str, list[Stamped]]
    untaken: tuple[int | None, ...] = ()


@dataclass(slots=True)
class Sampling:
    """A subscribed topic with a rate.

    Args:
        info: the topic.
        schedule: when its samples are taken.
        part: the part that takes them.
        subscriptions: its subscriptions.
        due_ns: time of the next sample, ns.
        in_flight: samples in transit, with their times of arrival.
        delay_ns: time from sample to arrival, ns.
    """

    info: TopicInfo
    schedule: SampleSchedule
    part: Part
    subscriptions: list[Subscription] = field(default_factory=list)
    due_ns: int = 0
    in_flight: list[Stamped] = field(default_factory=list)
    delay_ns: int = field(init=False)

    def __post_init__(self) -> None:
        self.delay_ns = from_seconds(self.info.delay)

    @property
    def is_read(self) -> bool:
        """Whether a reader exists; transfer functions in quarantine do not count."""
        return any(subscription.is_read for subscription in self.subscriptions)

    def is_dropped(self, now_ns: int, seed: int) -> bool:
        """Return whether the sample of this time is lost."""
        if not self.info.drop_out:
            return False
        stream = Seeds(seed).child("world/drop_out").stream(f"{self.info.name}@{now_ns}")
        return bool(stream.random() < self.info.drop_out)

    def deliver(self, now_ns: int) -> None:
        """Deliver the messages that have arrived."""
        while self.in_flight and self.in_flight[0].t_ns <= now_ns:
            sample = self.in_flight.pop(0)
            for subscription in self.subscriptions:
                subscription.push(sample)


class Switchboard:
    """Topics by name, and the traffic on them.

    Args:
        engine: the engine, with the time; samples are taken between its steps.
        owner: the owner of the topics.

    Attributes:
        connections: how often parts were connected or disconnected.
        started: whether the first samples have been taken.
        observers: called with every published message and its topic (never an alias).
    """

    def __init__(self, engine: Engine, owner: Simulation) -> None:
        self.started = False
        self.observers: list[Callable[[str, Stamped], None]] = []
        self._engine, self._step_ns, self._owner = engine, engine.step_ns, owner
        self._parts: dict[str, list[Part]] = {}  # several obey one topic of commands
        self._layouts: dict[str, NumberLayout] = {}
        self._topics: dict[str, TopicInfo] = {}
        self._aliases: dict[str, str] = {}
        self._rated: dict[str, Sampling] = {}
        self._bus: dict[str, list[Subscription]] = {}
        self._subscriptions: list[Subscription] = []
        self._subscribed: frozenset[str] | None = None
        self._held: list[tuple[str, Any, Sequence[float] | None]] | None = None
        self.connections = 0
        self._received: set[str] = set()
        self._unreceived: set[str] = set()

    @property
    def topics(self) -> Mapping[str, TopicInfo]:
        """Every topic by its name, aliases included."""
        aliases = {
            alias: replace(self._topics[name], name=alias)
            for alias, name in self._aliases.items()
            if name in self._topics
        }
        return MappingProxyType({**self._topics, **aliases})

    def add_alias(self, alias: str, topic: str) -> None:
        """Add an alias of a topic.

        Raises:
            TopicError: the name is taken, or the topic does not exist.
        """
        self.require_free(alias)
        self._aliases[alias] = self.info(topic).name

    def declare(self, name: str, type_: type) -> None:
        """Add a topic of the user, which carries only published messages.

        Args:
            name: the name.
            type_: the message class.

        Raises:
            TopicError: the name is taken.
        """
        self.require_free(name)
        self._topics[name] = TopicInfo(name, type_, Direction.BOTH, what="declared by the experiment")
        self._bus[name] = []

    def set_unit(self, name: str, unit: str) -> None:
        """Set the unit of a declared topic, whose message is one number."""
        self._topics[name] = replace(self._topics[name], unit=unit)

    def subscribe(self, topic: str, *, depth: int | None = 1) -> Subscription:
        """Subscribe to a topic.

        Args:
            topic: its name or an alias.
            depth: number of messages that the subscription keeps; None: all that came since the last
                :meth:`.Subscription.take`.

        Raises:
            TopicError: the topic does not exist, or it can only be published on.
        """
        info = self._require(topic, Direction.OUT)
        name = info.name
        if name in self._bus:
            subscription = Subscription(info, depth)
            self._bus[name].append(subscription)
        elif info.rate_hz is None:
            subscription = Subscription(info, depth, partial(self._read_now, name))
        else:
            subscription = Subscription(info, depth)
            if name not in self._rated:
                self._rated[name] = self._sampling(info)
            self._rated[name].subscriptions.append(subscription)
        self._subscriptions.append(subscription)
        self._subscribed = None
        return subscription

    def unsubscribe(self, subscription: Subscription) -> None:
        """End a subscription; a topic without subscribers costs nothing."""
        if subscription not in self._subscriptions:
            return
        name = subscription.topic.name
        self._subscriptions.remove(subscription)
        self._subscribed = None
        if name in self._rated:
            self._rated[name].subscriptions.remove(subscription)
            if not self._rated[name].subscriptions:
                del self._rated[name]
        elif name in self._bus:
            self._bus[name].remove(subscription)

    @property
    def subscribed(self) -> frozenset[str]:
        """The subscribed topics, never aliases; the same object until it changes."""
        if self._subscribed is None:
            self._subscribed = frozenset(subscription.topic.name for subscription in self._subscriptions)
        return self._subscribed

    @property
    def without_subscriber(self) -> frozenset[str]:
        """The declared topics on which messages were published, but never while there was a subscriber."""
        return frozenset(self._unreceived - self._received)

    def advertise(self, topic: str) -> Publication:
        """Return the right to publish on a topic.

        Raises:
            TopicError: the topic does not exist, or it cannot be published on.
        """
        info = self._require(topic, Direction.IN)
        return Publication(replace(info, name=topic), info.name, self)

    # -- names

    def require_free(self, name: str) -> None:
        """Raise a TopicError if a name is taken, or not absolute."""
        if not name.startswith("/"):
            raise TopicError(f"topic names must be absolute: '/{name}', not '{name}'")
        if name in self._topics or name in self._aliases:
            raise TopicError(f"the topic '{name}' already exists")

    def info(self, topic: str) -> TopicInfo:
        """Return the description of a topic, given by its name or an alias.

        Raises:
            TopicError: the topic does not exist.
        """
        if not isinstance(topic, str):
            raise TopicError(f"a topic is given by its name, a text, not {topic!r:.60}")
        name = self._aliases.get(topic, topic)
        if name not in self._topics:
            raise TopicError(f"no topic '{topic}'{did_you_mean(topic, self.topics)}")
        return self._topics[name]

    def _require(self, topic: str, direction: Direction) -> TopicInfo:
        self._owner.require_ready(or_failed=True)
        info = self.info(topic)
        if not info.direction & direction:
            verb = "takes" if direction is Direction.OUT else "gives"
            raise TopicError(f"the topic '{topic}' ({type_name(info.type)}) only {verb} messages")
        return info

    # -- topics of parts

    def part(self, topic: str) -> Part | None:
        """Return the part that a topic belongs to, if any."""
        return next(iter(self._parts.get(topic, ())), None)

    def connect(self, part: Part, model: Sequence[Part] = ()) -> None:
        """Add the topics of a part; subscribers of topics with the same names stay subscribed.

        Several parts of one model may obey one topic of commands; those of others, too, if it is the same.

        Args:
            part: the part.
            model: all parts of its model.

        Raises:
            TopicError: another part has a topic of that name.
        """
        self.connections += 1
        for topic in part.topics:
            if known := self._topics.get(topic.name):
                is_command = known.direction is topic.direction is Direction.IN and known.type is topic.type
                is_same = (topic.name in part.number_topics) == (topic.name in self._layouts)
                sharing = self._parts.get(topic.name, [])
                if is_command and is_same and (known == topic or any(each in model for each in sharing)):
                    sharing.append(part)
                    continue
                who = f"{known.what} and {topic.what}"
                raise TopicError(f"two parts of the scene have the topic '{topic.name}': {who}")
            self._topics[topic.name] = topic
            self._parts[topic.name] = [part]
            if topic.name in part.number_topics:
                self._layouts[topic.name] = layout_of(topic.type)
            subscriptions = [s for s in self._subscriptions if s.topic.name == topic.name]
            if topic.name in part.pushed_topics:
                self._bus[topic.name] = subscriptions
            elif topic.rate_hz is not None and subscriptions:
                self._rated[topic.name] = self._sampling(topic)
                self._rated[topic.name].subscriptions += subscriptions

    def disconnect(self, part: Part) -> None:
        """Remove the topics of a part; their subscribers receive no further messages."""
        self.connections += 1
        for topic in part.topics:
            self._parts[topic.name].remove(part)
            if self._parts[topic.name]:
                continue
            del self._topics[topic.name], self._parts[topic.name]
            self._layouts.pop(topic.name, None)
            self._rated.pop(topic.name, None)
            self._bus.pop(topic.name, None)

    def _sampling(self, info: TopicInfo) -> Sampling:
        assert info.rate_hz is not None
        schedule = SampleSchedule.of(info.rate_hz, self._step_ns)
        sampling = Sampling(info, schedule, self._parts[info.name][0])
        sampling.due_ns = self._next_sample(sampling)
        return sampling

    # -- messages

    def drop_old(self) -> None:
        """Drop old messages that no reader has taken; called once a second, before a step."""
        now_ns = self._engine.now_ns
        for subscription in self._subscriptions:
            if subscription.depth is None:
                subscription.drop_old(now_ns)

    def push(self, topic: str, stamped: Stamped) -> None:
        """Deliver a message from outside to the subscribers of its topic."""
        for subscription in self._bus.get(topic, ()):
            subscription.push(stamped)

    def show(self, topic: str, message: Any) -> None:
        """Pass a published message to the observers."""
        for observer in self.observers:
            observer(topic, Stamped(self._engine.now_ns, message))

    def deliver(self, name: str, message: Any, *, is_own: bool = False) -> None:
        """Deliver a checked message to the part of its topic, or to the subscribers of a declared topic.

        It is copied unless nobody else has it.

        Raises:
            TopicError: the model of the topic was deleted.
        """
        self._owner.require_ready()
        if name not in self._parts and name not in self._bus:
            raise TopicError(f"the topic '{name}' no longer exists: its model was deleted")
        layout = self._layouts.get(name)
        numbers = None if layout is None else layout.numbers(message)
        if self._held is not None:
            own = None if numbers else message if is_own else deepcopy(message)
            self._held.append((name, own, numbers))
        else:
            self._send(name, message if is_own or name in self._parts else deepcopy(message), numbers)

    def hold(self) -> None:
        """Let published messages wait until :meth:`release`.

        What runs until then sees the same messages in whatever order it runs.
        """
        self._held = []

    def release(self) -> None:
        """Deliver the messages that wait, in the order in which they were published."""
        held, self._held = self._held or (), None
        for name, message, numbers in held:
            self._send(name, message, numbers)

    def _send(self, name: str, message: Any, numbers: Sequence[float] | None) -> None:
        """Deliver a message that its sender does not change any more, or the numbers in it."""
        if parts := self._parts.get(name):
            try:
                for part in parts:
                    part.write(name, message if numbers is None else numbers, self._engine.now_ns)
            except BaseException as error:
                self._owner.fail(f"take a message on {name}", error)  # raises it as one of ours if it is not
                raise
        elif (subscriptions := self._bus.get(name)) is not None:
            (self._received if subscriptions else self._unreceived).add(name)
            self.push(name, Stamped(self._engine.now_ns, message))
        else:
            lost = f"a message on '{name}' was dropped: its model was deleted in the same step"
            self._engine.warnings.add(Code.NRP282, lost, subject=name)
            return
        if self.observers:
            self.show(name, message if numbers is None else self._layouts[name].message(numbers))

    def deliver_numbers(self, name: str, numbers: Sequence[float]) -> bool:
        """Deliver the finite numbers of a message to the parts of its topic, if any."""
        self._owner.require_ready()
        if name not in self._layouts:
            return False
        if self._held is not None:
            self._held.append((name, None, numbers))
        else:
            self._send(name, None, numbers)
        return True

    def effort_group(self, names: Sequence[str]) -> JointGroup | None:
        """Return what obeys topics at once, if each commands the effort of one joint, all of one model."""
        found = [self._parts.get(name, ()) for name in names]
        return (
            effort_group(names, [parts[0] for parts in found if len(parts) == 1])
            if all(len(parts) == 1 for parts in found)
            else None
        )

    def _read_now(self, name: str) -> Stamped | None:
        owner = self._owner
        owner.require_ready(or_failed=True)
        part, now_ns = self.part(name), self._engine.now_ns
        return None if part is None else Stamped(now_ns, part.read(name, now_ns))

    def next_due(self) -> int | None:
        """Return the time of the next sample, or of its preparation one step before, ns."""
        next_ns, now_ns = None, self._engine.now_ns
        for sampling in self._rated.values():
            ahead_ns, stop_ns = sampling.due_ns - self._step_ns, sampling.due_ns
            if sampling.part.needs_previous_step and ahead_ns > now_ns:
                stop_ns = ahead_ns
            if next_ns is None or stop_ns < next_ns:
                next_ns = stop_ns
        return next_ns

    def sample(self) -> None:
        """Take all samples that are due now, and deliver messages that have arrived."""
        now_ns = self._engine.now_ns
        for name, sampling in self._rated.items():
            if sampling.due_ns == now_ns:
                sampling.due_ns = sampling.schedule.next_after(now_ns)
                if sampling.is_read and not sampling.is_dropped(now_ns, self._owner.seed):
                    message = sampling.part.read(name, now_ns)
                    sampling.in_flight.append(Stamped(now_ns + sampling.delay_ns, message))
            if sampling.due_ns == now_ns + self._step_ns and sampling.part.needs_previous_step:
                sampling.part.prepare_sample(name, now_ns)
            if sampling.in_flight:
                sampling.deliver(now_ns)

    def _next_sample(self, sampling: Sampling) -> int:
        return sampling.schedule.next_after(self._engine.now_ns) if self.started else 0

    # -- reset and snapshots

    def reset(self) -> None:
        """Remove all messages, and schedule samples from time 0."""
        self._schedule(started=False)
        self._received.clear()
        self._unreceived.clear()
        self._forget_messages()

    def save(self) -> Saved:
        """Return the messages in subscriptions and in flight."""
        stored = [each.save() for each in self._subscriptions]
        names = [each.topic.name for each in self._subscriptions]
        messages = [(name, kept) for name, (kept, _) in zip(names, stored, strict=True)]
        in_flight = {name: list(sampling.in_flight) for name, sampling in self._rated.items()}
        return Saved(self.started, messages, in_flight, tuple(untaken for _, untaken in stored))

    def restore(self, saved: Saved) -> None:
        """Restore a saved state; the n-th subscription of a topic gets the messages of the n-th one saved."""
        self._schedule(started=saved.started)
        by_topic: dict[str, list[tuple[list[Stamped], int | None]]] = {}
        untaken = getattr(saved, "untaken", ()) or (None,) * len(saved.messages)  # older ones have none
        for (name, messages), count in zip(saved.messages, untaken, strict=True):
            by_topic.setdefault(name, []).append((messages, count))
        self._forget_messages()
        for subscription in self._subscriptions:
            if queue := by_topic.get(subscription.topic.name):
                subscription.restore(*queue.pop(0))
        for name, sampling in self._rated.items():
            sampling.in_flight += saved.in_flight.get(name, [])

    def _schedule(self, *, started: bool) -> None:
        """Set when each sample is due, which the time alone determines."""
        self.started = started
        for sampling in self._rated.values():
            sampling.due_ns = self._next_sample(sampling)

    def _forget_messages(self) -> None:
        for subscription in self._subscriptions:
            subscription.clear()
        for sampling in self._rated.values():
            sampling.in_flight.clear()


class NumbersPublication:
    """The right to publish on several topics at once, each of which carries one number.

    Args:
        publications: one for each topic.
        board: delivers the messages.
    """

    def __init__(self, publications: Sequence[Publication], board: Switchboard) -> None:
        self._publications, self._board = publications, board
        self._names = [each.name for each in publications]
        self._connections = -1
        self._group: JointGroup | None = None

    @staticmethod
    def publish_all(publications: Sequence[NumbersPublication], rows: FloatArray) -> None:
        """Publish numbers in several copies of a world, a row for each.

        Efforts of the joints of one model take one call of the engine.

        Raises:
            TopicError: a number is not finite.
        """
        groups = [each._find_group() for each in publications]
        rest: Iterable[int] = range(len(rows))
        if None not in groups and np.isfinite(rows).all():
            rest = JointGroup.lead_all(groups, rows)  # type: ignore[arg-type]
        for number in rest:
            publications[number]._publish(groups[number], rows[number].tolist())

    def _find_group(self) -> JointGroup | None:
        """Return what leads the joints; None while messages wait, are observed or go to other parts."""
        board = self._board
        board._owner.require_ready()
        if self._connections != board.connections:
            self._connections, self._group = board.connections, board.effort_group(self._names)
        return None if board._held is not None or board.observers else self._group

    def _publish(self, group: JointGroup | None, values: Sequence[float]) -> None:
        if group is not None and isfinite(sum(values)):
            with guarded(self._board._owner, "take efforts of joints"):
                group.lead_each(values, self._board._engine.now_ns)
        else:
            for publication, value in zip(self._publications, values, strict=True):
                publication.publish_numbers([value])


def release_all(boards: Sequence[Switchboard]) -> Failures:
    """Let the boards of several copies deliver the messages that wait, each in its own order.

    Returns:
        The errors by the numbers of the boards.
    """
    held = [board._held or () for board in boards]
    for board in boards:
        board._held = None
    failed: Failures = {}
    for place in range(max(map(len, held), default=0)):
        waiting = {
            number: messages[place]
            for number, messages in enumerate(held)
            if place < len(messages) and number not in failed
        }
        for number in _written_together(boards, waiting):
            del waiting[number]
        for number, message in waiting.items():
            note_failure(failed, number, partial(boards[number]._send, *message))
    return failed


def _written_together(
    boards: Sequence[Switchboard],
    waiting: Mapping[int, tuple[str, Any, Sequence[float] | None]],
) -> list[int]:
    """Write numbers that parts of one kind take at once; return the numbers of their boards."""
    batches: dict[Any, list[tuple[int, Part]]] = {}
    for number, (name, _, numbers) in waiting.items():
        board = boards[number]
        parts = board._parts.get(name, ())
        if numbers is not None and len(parts) == 1 and not board.observers:
            batches.setdefault((type(parts[0]), name), []).append((number, parts[0]))
    done: list[int] = []
    for (kind, name), batch in batches.items():
        parts = [part for _, part in batch]
        rows = [waiting[number][2] for number, _ in batch]
        times_ns = [boards[number]._engine.now_ns for number, _ in batch]
        with suppress(Exception):  # each then gets its own numbers alone, and those that are bad fail alone
            if len(parts) > 1 and kind.write_all(parts, name, rows, times_ns):
                done += [number for number, _ in batch]
    return done
