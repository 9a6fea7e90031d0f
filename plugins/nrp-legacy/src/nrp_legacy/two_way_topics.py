"""Let functions read commands to a robot, and publish on topics that the robot publishes, as in ROS.

A world's topics have one direction each. The other direction is a separate topic with another name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.parameters.messages import message_type
from nrp_core.dsl.parameters.topics import Topic
from nrp_core.findings import Code
from nrp_core.world.messages.base import type_name
from nrp_core.world.topics import Direction, Stamped
from nrp_core.world.world import World
from nrp_legacy.shims.modules import OpenMessage

HEARD, UNHEARD, MISTYPED = "/heard", "/unheard", "/mistyped"
"""Prefixes of topics to a robot, of topics without a receiver, and of topics with another type."""


def plain_name(topic: Topic) -> str:
    """Return the name of a topic in the user's code, redirected or not."""
    lead = next((lead for lead in (HEARD, UNHEARD, MISTYPED) if topic.name.startswith(f"{lead}/")), "")
    return topic.name.removeprefix(lead)


def let_all_talk(functions: Sequence[TransferFunction], world: World, aliases: Mapping[str, str]) -> None:
    """Redirect reading and publishing against the direction of a topic.

    Args:
        functions: the transfer functions, not bound.
        world: the world.
        aliases: the topics that further names stand for.
    """
    redirect = _Redirection(world, aliases)
    for function in functions:
        if function.topic is not None:
            function.topic = redirect.published(function.topic)
        for mapping in function.mappings.values():
            if mapping.writes is not None:
                mapping.writes = redirect.published(mapping.writes)
            if mapping.reads is not None:
                mapping.reads = redirect.read(mapping.reads)


class _Redirection:
    def __init__(self, world: World, aliases: Mapping[str, str]) -> None:
        self._world, self._aliases = world, aliases

    def published(self, topic: Topic) -> Topic:
        """Return a topic for messages to a topic that only the robot publishes."""
        sent = "messages of the other type reach nothing"
        mistyped = self._mistyped(topic, sent)
        if mistyped is not None:
            self._world.subscribe(mistyped.name)  # the finding says what happens to them
            return mistyped
        return self._beside(topic, UNHEARD, Direction.IN)[0]

    def read(self, topic: Topic) -> Topic:
        """Return a topic that repeats the messages to a topic that only the robot reads."""
        topic = self._known(topic)
        mistyped = self._mistyped(topic, "a subscriber with the other type gets no messages")
        if mistyped is not None:
            return mistyped
        beside, is_new = self._beside(topic, HEARD, Direction.OUT)
        if is_new:
            self._repeat(beside.name.removeprefix(HEARD), beside.name)
        return beside

    def _known(self, topic: Topic) -> Topic:
        """Return a topic with the type in the world, if the user's type is unknown but has the same name."""
        info, kind = self._world.topics.get(plain_name(topic)), topic.topic_type
        is_open = isinstance(kind, type) and issubclass(kind, OpenMessage)
        same = info is not None and is_open and kind.__name__ == info.type.__name__
        return replace(topic, topic_type=info.type) if info is not None and same else topic

    def _mistyped(self, topic: Topic, effect: str) -> Topic | None:
        """Return a silent topic for one with other messages, as such connections fail in ROS."""
        name, kind = plain_name(topic), topic.topic_type
        info = self._world.topics.get(name)
        if info is None or kind is None or type_name(kind) == type_name(info.type):
            return None
        beside = replace(topic, name=f"{MISTYPED}{name}")
        if beside.name not in self._world.topics:
            self._world.declare(beside.name, message_type(kind))
            carried = f"'{name}' carries {type_name(info.type)}, not {type_name(message_type(kind))}"
            self._world.warnings.add(Code.NRP282, f"{carried}: {effect}", subject=name)
        return beside

    def _beside(self, topic: Topic, lead: str, wanted: Direction) -> tuple[Topic, bool]:
        name = plain_name(topic)
        info = self._world.topics.get(name)
        if info is None or info.direction & wanted:
            return topic, False
        beside = replace(topic, name=f"{lead}{name}")
        is_new = beside.name not in self._world.topics
        if is_new:
            self._world.declare(beside.name, info.type)
        return beside, is_new

    def _repeat(self, name: str, beside: str) -> None:
        served, repeated = self._aliases.get(name, name), self._world.advertise(beside)

        def repeat(topic: str, stamped: Stamped) -> None:
            if topic == served:
                repeated.publish(stamped.message)

        self._world.add_observer(repeat)
