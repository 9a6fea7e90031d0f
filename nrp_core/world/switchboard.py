"""The switchboard: subscriptions, the schedule of samples, and the delivery of messages.

It is independent of physics. A topic without subscribers costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass, field, replace
from functools import partial
from types import MappingProxyType
from typing import Any

from nrp_core.clock import SampleSchedule, from_seconds
from nrp_core.errors import TopicError, did_you_mean
from nrp_core.seeds import Seeds
from nrp_core.simulation import Simulation
from nrp_core.world.messages.base import type_name
from nrp_core.world.part import Part
from nrp_core.world.topics import Direction, Publication, Stamped, Subscription, TopicInfo


@dataclass(frozen=True, slots=True)
class Saved:
    """The state of a switchboard: the time, the messages in subscriptions, and the messages in transit."""

    at_ns: int
    started: bool
    kept: list[tuple[str, list[Stamped]]]
    late: dict[str, list[Stamped]]


@dataclass(slots=True)
class Sampling:
    """A subscribed topic with a rate.

    Args:
        info: the topic.
        schedule: when its samples are taken.
        part: the part that takes them.
        subscriptions: its subscriptions.
        due_ns: time of the next sample, ns.
        late: samples in transit, with their times of arrival.
        delay_ns: time from sample to arrival, ns.
    """

    info: TopicInfo
    schedule: SampleSchedule
    part: Part
    subscriptions: list[Subscription] = field(default_factory=list)
    due_ns: int = 0
    late: list[Stamped] = field(default_factory=list)
    delay_ns: int = field(init=False)

    def __post_init__(self) -> None:
        self.delay_ns = from_seconds(self.info.delay)

    def take(self, now_ns: int) -> None:
        """Take a sample now and send it."""
        sample = Stamped(now_ns + self.delay_ns, self.part.read(self.info.name, now_ns))
        if self.delay_ns:
            self.late.append(sample)
        else:
            self._deliver(sample)

    def loses(self, now_ns: int, seed: int) -> bool:
        """Return whether the present sample gets lost."""
        stream = Seeds(seed).child("world/drop_out").stream(f"{self.info.name}@{now_ns}")
        return bool(stream.random() < self.info.drop_out)

    def deliver(self, now_ns: int) -> None:
        """Deliver the messages that have arrived."""
        while self.late and self.late[0].t_ns <= now_ns:
            self._deliver(self.late.pop(0))

    def _deliver(self, sample: Stamped) -> None:
        for subscription in self.subscriptions:
            subscription.push(sample)


class Switchboard:
    """Topics by name, and the traffic on them.

    Args:
        step_ns: the grid of the times of samples, ns.
        owner: the owner of the topics.

    Attributes:
        at_ns: the current time, also during an advance of the owner, ns.
        started: whether the first samples have been taken.
        observers: called with every published message and its topic (never an alias).
    """

    def __init__(self, step_ns: int, owner: Simulation) -> None:
        self.at_ns = 0
        self.started = False
        self.observers: list[Callable[[str, Stamped], None]] = []
        self._step_ns, self._owner = step_ns, owner
        self._parts: dict[str, Part] = {}
        self._topics: dict[str, TopicInfo] = {}
        self._aliases: dict[str, str] = {}
        self._rated: dict[str, Sampling] = {}
        self._bus: dict[str, list[Subscription]] = {}
        self._subscriptions: list[Subscription] = []
        self._subscribed: frozenset[str] | None = None
        self._heard: set[str] = set()
        self._unheard: set[str] = set()

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
            TopicError: the name is taken, or there is no such topic.
        """
        self.require_free(alias)
        self._aliases[alias] = self.info(topic).name

    def declare(self, name: str, type_: type) -> None:
        """Add a topic of the user, which carries only published messages.

        Raises:
            TopicError: the name is taken.
        """
        self.require_free(name)
        self._topics[name] = TopicInfo(name, type_, Direction.BOTH, what="declared by the experiment")
        self._bus[name] = []

    def subscribe(self, topic: str, *, depth: int = 1) -> Subscription:
        """Subscribe to a topic.

        Args:
            topic: its name or an alias.
            depth: number of messages that the subscription keeps.

        Raises:
            TopicError: there is no such topic, or it can only be published on.
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
    def unheard(self) -> frozenset[str]:
        """The declared topics on which messages were published, but never while there was a subscriber."""
        return frozenset(self._unheard - self._heard)

    def advertise(self, topic: str) -> Publication:
        """Return the right to publish on a topic.

        Raises:
            TopicError: there is no such topic, or it cannot be published on.
        """
        info = self._require(topic, Direction.IN)
        deliver, taker = partial(self._deliver, info.name), partial(self._taker, info.name)
        return Publication(replace(info, name=topic), deliver, taker, partial(self._fail, info.name))

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
            TopicError: there is no such topic.
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
        return self._parts.get(topic)

    def connect(self, part: Part) -> None:
        """Add the topics of a part; subscribers of topics with the same names stay subscribed.

        Raises:
            TopicError: another part has a topic of that name.
        """
        for topic in part.topics:
            if topic.name in self._topics:
                who = f"{self._topics[topic.name].what} and {topic.what}"
                raise TopicError(f"two parts of the scene have the topic '{topic.name}': {who}")
            self._topics[topic.name] = topic
            self._parts[topic.name] = part
            listening = [s for s in self._subscriptions if s.topic.name == topic.name]
            if topic.name in part.carried:
                self._bus[topic.name] = listening
            elif topic.rate_hz is not None and listening:
                self._rated[topic.name] = self._sampling(topic)
                self._rated[topic.name].subscriptions += listening

    def disconnect(self, part: Part) -> None:
        """Remove the topics of a part; their subscribers get no more messages."""
        for topic in part.topics:
            del self._topics[topic.name], self._parts[topic.name]
            self._rated.pop(topic.name, None)
            self._bus.pop(topic.name, None)

    def _sampling(self, info: TopicInfo) -> Sampling:
        assert info.rate_hz is not None
        schedule = SampleSchedule.of(info.rate_hz, self._step_ns)
        sampling = Sampling(info, schedule, self._parts[info.name])
        sampling.due_ns = self._next_sample(sampling)
        return sampling

    # -- messages

    def push(self, topic: str, stamped: Stamped) -> None:
        """Deliver a message from outside to the subscribers of its topic."""
        for subscription in self._bus.get(topic, ()):
            subscription.push(stamped)

    def show(self, topic: str, message: Any) -> None:
        """Pass a published message to the observers."""
        for observer in self.observers:
            observer(topic, Stamped(self._owner.now_ns, message))

    def _deliver(self, name: str, message: Any) -> None:
        owner = self._owner
        owner.require_ready()
        part = self._parts.get(name)
        if part is not None:
            try:
                part.write(name, message, owner.now_ns)
            except BaseException as error:
                self._fail(name, error)
                raise
        elif name in self._bus:
            (self._heard if self._bus[name] else self._unheard).add(name)
            self.push(name, Stamped(owner.now_ns, deepcopy(message)))  # the sender may reuse its message
        else:
            raise TopicError(f"the topic '{name}' no longer exists: its model was deleted")
        if self.observers:
            self.show(name, message)

    def _fail(self, name: str, error: BaseException) -> None:
        self._owner.fail(f"take a message on {name}", error)

    def _taker(self, name: str) -> tuple[Part, str, int] | None:
        """Return the part that alone takes the messages on a topic, its name, and the time, ns."""
        owner, part = self._owner, self._parts.get(name)
        owner.require_ready()
        return None if part is None or self.observers else (part, name, owner.now_ns)

    def _read_now(self, name: str) -> Stamped | None:
        owner = self._owner
        owner.require_ready(or_failed=True)
        part, now_ns = self._parts.get(name), owner.now_ns
        return None if part is None else Stamped(now_ns, part.read(name, now_ns))

    def next_due(self) -> int | None:
        """Return the time of the next sample, or of its preparation one step before, ns."""
        next_ns = None
        for sampling in self._rated.values():
            ahead_ns, stop_ns = sampling.due_ns - self._step_ns, sampling.due_ns
            if sampling.part.foresees and ahead_ns > self.at_ns:
                stop_ns = ahead_ns
            if next_ns is None or stop_ns < next_ns:
                next_ns = stop_ns
        return next_ns

    def sample(self) -> None:
        """Take all samples that are due now, and deliver messages that have arrived."""
        at_ns = self.at_ns
        for name, sampling in self._rated.items():
            if sampling.due_ns == at_ns:
                sampling.due_ns = sampling.schedule.next_after(at_ns)
                if not (sampling.info.drop_out and sampling.loses(at_ns, self._owner.seed)):
                    sampling.take(at_ns)
            if sampling.due_ns == at_ns + self._step_ns and sampling.part.foresees:
                sampling.part.foresee(name, at_ns)
            if sampling.late:
                sampling.deliver(at_ns)

    def _next_sample(self, sampling: Sampling) -> int:
        return sampling.schedule.next_after(self.at_ns) if self.started else 0

    # -- reset and snapshots

    def restart(self) -> None:
        """Reset to time 0, without messages."""
        self._move_to(0, started=False)
        self._heard.clear()
        self._unheard.clear()
        self._forget_messages()

    def save(self) -> Saved:
        """Return the time, and the messages that are kept or in transit."""
        kept = [(subscription.topic.name, subscription.kept()) for subscription in self._subscriptions]
        late = {name: list(sampling.late) for name, sampling in self._rated.items()}
        return Saved(self.at_ns, self.started, kept, late)

    def restore_time(self, saved: Saved) -> None:
        """Restore a saved state."""
        self._move_to(saved.at_ns, started=saved.started)

    def restore_messages(self, saved: Saved) -> None:
        """Restore the messages of subscriptions; the n-th one of a topic gets those of the n-th one saved."""
        held: dict[str, list[list[Stamped]]] = {}
        for name, messages in saved.kept:
            held.setdefault(name, []).append(messages)
        self._forget_messages()
        for subscription in self._subscriptions:
            queue = held.get(subscription.topic.name)
            for stamped in queue.pop(0) if queue else ():
                subscription.push(stamped)
        for name, sampling in self._rated.items():
            sampling.late += saved.late.get(name, [])

    def _move_to(self, at_ns: int, *, started: bool) -> None:
        """Set the time, which alone determines when each sample is due."""
        self.at_ns, self.started = at_ns, started
        for sampling in self._rated.values():
            sampling.due_ns = self._next_sample(sampling)

    def _forget_messages(self) -> None:
        for subscription in self._subscriptions:
            subscription.clear()
        for sampling in self._rated.values():
            sampling.late.clear()
