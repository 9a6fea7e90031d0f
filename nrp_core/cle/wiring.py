"""Connect transfer functions with a brain and a world."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from typing import Any

from nrp_core.brain.devices.ports import SourcePort
from nrp_core.brain.devices.sinks import SinkPort
from nrp_core.brain.interface import Brain
from nrp_core.dsl.functions import TransferFunction, require_new_name
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.world.world import World


class Wiring:
    """The transfer functions bound to a brain and a world, and the variables that they share.

    Args:
        brain, world: the two sides.

    Attributes:
        functions: in the order in which they run: by priority, then in the order given.
    """

    def __init__(self, brain: Brain, world: World) -> None:
        self._brain, self._world = brain, world
        self._variables: dict[str, Any] = {}
        self.functions: tuple[TransferFunction, ...] = ()

    def change(self, add: Iterable[TransferFunction], remove: Iterable[str] = ()) -> None:
        """Add and remove functions; if anything is wrong, change nothing.

        A new function replaces the function of the same name and continues its state: variables keep their
        values, and devices on the same neurons keep their state and random streams.

        Args:
            add: functions to add; those already bound stay.
            remove: names of functions to remove.

        Raises:
            ExperimentError: two functions have the same name, a function names something that does not
                exist, or a function to remove does not exist.
        """
        bound = {function.name: function for function in self.functions}
        added = [function for function in add if bound.get(function.name) is not function]
        for i, function in enumerate(added):
            require_new_name(function, added[:i])
        new = {function.name: function for function in added}
        removed = {self._require_known(name) for name in remove} - new.keys()
        after = {name: function for name, function in bound.items() if name not in removed} | new
        declare_topics(list(after.values()), self._world)
        self._bind(added, bound)
        for name in removed | (bound.keys() & new.keys()):
            bound[name].unbind()
        self.functions = tuple(sorted(after.values(), key=lambda function: -function.priority))

    def _bind(self, added: Iterable[TransferFunction], bound: Mapping[str, TransferFunction]) -> None:
        """Bind all functions or none; a function continues the state of the bound one of the same name."""
        there = self._brain.devices
        before, known = {_device_key(port): port for port in there}, set(map(id, there))
        with ExitStack() as undo:
            for function in added:
                function.bind(self._brain, self._world, variables=self._variables)
                undo.callback(function.unbind)
                if function.name in bound:
                    function.restore(bound[function.name].save())
            for port in self._brain.devices:
                if id(port) not in known and _device_key(port) in before:
                    port.restore(before[_device_key(port)].save())
            undo.pop_all()

    def _require_known(self, name: str) -> str:
        names = [function.name for function in self.functions]
        if name not in names:
            raise ExperimentError(f"there is no transfer function '{name}'{did_you_mean(name, names)}")
        return name

    def __getitem__(self, name: str) -> TransferFunction:
        """Return a function by its name.

        Raises:
            ExperimentError: it does not exist.
        """
        self._require_known(name)
        return next(function for function in self.functions if function.name == name)

    def close(self) -> None:
        """Unbind all functions."""
        for function in self.functions:
            function.unbind()


def _device_key(port: SourcePort | SinkPort) -> tuple[str, str, tuple[int, ...]]:
    """Return the identity of a device: its kind, its name and its neurons."""
    return type(port).__qualname__, port.name, tuple(port.neurons.tolist())


def declare_topics(functions: Sequence[TransferFunction], world: World) -> None:
    """Declare the topics between functions: those that the world lacks, one function publishes and one reads.

    A topic that is only published or only read is probably misspelt, and fails when it is bound.
    """
    read = {topic.name for function in functions for topic in function.subscribed}
    for function in functions:
        for topic in function.published:
            between = topic.name in read and topic.name not in world.topics
            if between and topic.topic_type is not None:
                world.declare(topic.name, topic.topic_type)


def declare_unserved(functions: Sequence[TransferFunction], world: World) -> list[str]:
    """Declare every topic that a function names and the world lacks; return their names.

    A topic without a declared type carries any message.
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
