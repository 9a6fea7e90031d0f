"""Connect transfer functions with a brain and a world."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from typing import Any

from nrp_core.brain.interface import Brain
from nrp_core.dsl.collector import require_new_name
from nrp_core.dsl.function import TransferFunction
from nrp_core.world.interface import World


def connect(functions: Iterable[TransferFunction], brain: Brain, world: World) -> list[TransferFunction]:
    """Bind functions and return them in the order in which they run.

    Those of higher priority run first; equals run in the order given.

    Raises:
        ExperimentError: two have one name, or one names what does not exist; none stays bound.
    """
    ordered = sorted(functions, key=lambda function: -function.priority)
    for i, function in enumerate(ordered):
        require_new_name(function, ordered[:i])
    declare_topics(ordered, world)
    variables: dict[str, Any] = {}
    with ExitStack() as undo:
        for function in ordered:
            function.bind(brain, world, variables=variables)
            undo.callback(function.unbind)
        undo.pop_all()
    return ordered


def declare_topics(functions: Sequence[TransferFunction], world: World) -> None:
    """Declare the topics between functions: no part of the world serves them, one publishes, one reads.

    One that is only published, or only read, is left to fail where it is bound: it is misspelt.
    """
    read = {topic.name for function in functions for topic in function.subscribed}
    for function in functions:
        for topic in function.published:
            between = topic.name in read and topic.name not in world.topics
            if between and topic.topic_type is not None:
                world.declare(topic.name, topic.topic_type)


def declare_unserved(functions: Sequence[TransferFunction], world: World) -> list[str]:
    """Declare every topic that a function names and no part of the world serves; return their names.

    One whose type nobody says carries anything.
    """
    named = [topic for function in functions for topic in (*function.published, *function.subscribed)]
    unserved = [topic for topic in named if topic.name not in world.topics]
    types: dict[str, type] = {}
    for topic in unserved:
        known = types.get(topic.name, object)
        types[topic.name] = known if known is not object else topic.topic_type or object
    for name, kind in types.items():
        world.declare(name, kind)
    return list(types)
