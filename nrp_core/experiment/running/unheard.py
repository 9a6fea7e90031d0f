"""Commands that nothing subscribes to, found while they are published."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from difflib import get_close_matches
from pathlib import Path

from nrp_core.dsl.functions import TransferFunction
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.messages.base import type_name
from nrp_core.world.topics import Direction
from nrp_core.world.world import World

_SHOWN = "/monitor/"
"""Namespace of a platform's measurements; such topics are for people."""


class UnheardCommands:
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
            meant = self._meant(topic)
            declared = topic in self._declared or topic.startswith(_SHOWN)
            if meant or not declared:
                yield self._finding(topic, meant)

    def _finding(self, topic: str, meant: str | None) -> Finding:
        hint = f"; did you mean '{meant}'?" if meant else self._of_other_type(topic)
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
            return Finding(Code.NRP267, message, Level.WARNING, subject=topic)
        return Finding(Code.NRP267, message, Level.WARNING, Path(place.path), place.line, subject=topic)

    def _of_other_type(self, topic: str) -> str:
        """Return the topic of the world that ends in the same name and takes other messages, in words."""
        topics = self._world.topics
        kind = topics[topic].type if topic in topics else object
        for name, info in topics.items():
            same = name != topic and name.rpartition("/")[2] == topic.rpartition("/")[2]
            if same and info.direction & Direction.IN and kind not in (object, info.type):
                return f"; '{name}' takes {type_name(info.type)}, not {type_name(kind)}"
        return ""

    def _meant(self, topic: str) -> str | None:
        """Return the similar topic of the world that was probably intended, if there is one."""
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
