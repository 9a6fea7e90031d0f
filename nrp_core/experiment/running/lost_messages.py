"""Findings about messages that have no effect: topics without a publisher or subscriber, lost commands."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Final

from nrp_core.cle.loop import ClosedLoop
from nrp_core.clock import seconds
from nrp_core.dsl.functions import TransferFunction
from nrp_core.experiment.making.watch import declare_missing_topics, silent_topic
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.running.observers import RunObserver
from nrp_core.findings import Code, Finding, Level
from nrp_core.messages.base import type_name
from nrp_core.observables.observable import topic_of
from nrp_core.world.topics import Direction
from nrp_core.world.world import World

_logger = logging.getLogger(__name__)
_EVERY_OTHER: Final = 2
"""Who publishes in every other step or more replaces the commands of functions deliberately."""
_SHOWN = "/monitor/"
"""Namespace of a platform's measurements; such topics are for people."""


class SilentTopics:
    """Declares the topics of functions that are exchanged while an experiment that is not strict runs.

    Args:
        experiment: the experiment.
        world: its world.
        functions: returns the transfer functions at the time of a finding.
    """

    def __init__(
        self, experiment: Experiment, world: World, functions: Callable[[], Iterable[TransferFunction]]
    ) -> None:
        self._experiment, self._world, self._functions = experiment, world, functions
        self._said: dict[str, str] = {}

    def declare(self, functions: Sequence[TransferFunction]) -> None:
        """Add the topics that functions expect and that the world does not have."""
        served = dict(self._world.topics)
        for topic in declare_missing_topics(self._experiment, self._world, functions):
            self._said[topic] = silent_topic(topic, served)

    def findings(self) -> Iterator[Finding]:
        """Yield a finding for each of these topics that a function reads and none publishes."""
        functions = list(self._functions())
        published = {topic.name for function in functions for topic in function.published}
        for topic, message in self._said.items():
            readers = [
                one for one in functions if topic in {subscribed.name for subscribed in one.subscribed}
            ]
            if readers and topic not in published:
                place = readers[0].place
                yield Finding(
                    Code.NRP212, message, Level.WARNING, Path(place.path), place.line, subject=topic
                )


class LostMessages(RunObserver[object]):
    """Finds messages from outside without the effect that they were meant to have.

    Args:
        loop: the loop that delivers them.
    """

    def __init__(self, loop: ClosedLoop) -> None:
        self._loop = loop
        self._counts: dict[str, int] = {}
        self._first: dict[str, int] = {}
        loop.hooks.from_outside.append(self._count)
        loop.hooks.after_reset.append(self._reset)

    def _reset(self, loop: ClosedLoop) -> None:
        self._counts.clear()
        self._first.clear()

    def _count(self, topic: str, message: Any) -> None:
        self._counts[topic] = self._counts.get(topic, 0) + 1
        self._first.setdefault(topic, self._loop.steps)

    def findings(self) -> Iterator[Finding]:
        """Yield a finding for each topic with such messages so far."""
        loop = self._loop
        yield from self._find_undelivered()
        for topic, count in self._counts.items():
            names = self._publishers(topic)
            if names and count * _EVERY_OTHER < loop.steps - self._first[topic]:
                message = (
                    f"{count} message{'s' * (count != 1)} on '{topic}' from outside lasted until "
                    f"{', '.join(names)} published on it, too, at the end of the step"
                )
                yield Finding(Code.NRP282, message, Level.NOTE, subject=topic)

    def closing(self, run: object) -> None:
        """Log the messages that no step has taken."""
        for finding in self._find_undelivered():
            _logger.warning("%s", finding.message)

    def _find_undelivered(self) -> Iterator[Finding]:
        """Yield a finding for each topic with messages that wait for a step."""
        for topic in sorted(set(self._loop.waiting)):
            message = (
                f"a message on '{topic}' was published at {seconds(self._loop.now_ns):g} s, and no step was "
                "taken since: publish before the step in which it is to act"
            )
            yield Finding(Code.NRP282, message, Level.WARNING, subject=topic)

    def _publishers(self, topic: str) -> list[str]:
        """Return the active functions that publish on a topic, quoted."""
        world = self._loop.world
        return [
            f"'{one.name}'"
            for one in self._loop.functions
            if one.active and any(world.advertise(each.name).topic.name == topic for each in one.published)
        ]


class CommandsWithoutReceiver:
    """Finds messages on topics without a subscriber: part of the world, function, event or criterion.

    A topic that the experiment declares may be for people and recordings; it is reported only if a
    topic of the world has nearly the same name and the same type.

    Args:
        world: the world, which records the topics without a subscriber.
        declared: the topics that the experiment declares.
        functions: returns the transfer functions at the time of a finding.
    """

    def __init__(
        self, world: World, declared: Collection[str], functions: Callable[[], Iterable[TransferFunction]]
    ) -> None:
        self._world, self._declared, self._functions = world, declared, functions

    def findings(self) -> Iterator[Finding]:
        """Yield a finding for each topic with messages but without a subscriber so far."""
        for topic in sorted(self._world.without_subscriber):
            meant = self._intended_topic(topic)
            declared = topic in self._declared or topic.startswith((_SHOWN, topic_of("")))
            if meant or not declared:
                yield self._finding(topic, meant)

    def _finding(self, topic: str, meant: str | None) -> Finding:
        hint = f"; did you mean '{meant}'?" if meant else self._same_name_of_other_type(topic)
        message = f"nothing subscribes to '{topic}', so its commands have no effect{hint}"
        place = next(
            (
                function.place
                for function in self._functions()
                if topic in (published.name for published in function.published)
            ),
            None,
        )
        if place is None:
            return Finding(Code.NRP212, message, Level.WARNING, subject=topic)
        return Finding(Code.NRP212, message, Level.WARNING, Path(place.path), place.line, subject=topic)

    def _same_name_of_other_type(self, topic: str) -> str:
        """Return the topic of the world that ends in the same name and takes other messages, in words."""
        topics = self._world.topics
        kind = topics[topic].type if topic in topics else object
        for name, info in topics.items():
            same = name != topic and name.rpartition("/")[2] == topic.rpartition("/")[2]
            if same and info.direction & Direction.IN and kind not in (object, info.type):
                return f"; '{name}' takes {type_name(info.type)}, not {type_name(kind)}"
        return ""

    def _intended_topic(self, topic: str) -> str | None:
        """Return the similar topic of the world that was probably intended, if any."""
        topics = self._world.topics
        if topic not in topics:
            return None
        kind = topics[topic].type  # object: any message
        names = [
            name
            for name, info in topics.items()
            if info.direction is Direction.IN and (kind is object or type_name(info.type) == type_name(kind))
        ]
        return next(iter(get_close_matches(topic, names, n=1)), None)
