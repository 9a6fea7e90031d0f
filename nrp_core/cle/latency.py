"""The latency from sensors to actuators, in steps, derived from the mappings."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.dsl.parameters import Topic

BRAIN = "brain"


@dataclass(frozen=True, slots=True)
class LoopPath:
    """The shortest path from a sensor to an actuator.

    Args:
        sensor: a topic that a function reads and none publishes.
        actuator: a topic that a function publishes and none reads.
        steps: number of steps from the sensor's sample to the first step in which the actuator acts on
            it; rates, throttling and the brain's own delays are added to it.
        via: the transfer functions, ``brain`` and the topics between functions, in order.
    """

    sensor: str
    actuator: str
    steps: int
    via: tuple[str, ...]

    def __str__(self) -> str:
        return f"{' -> '.join((self.sensor, *self.via, self.actuator))}: {self.steps} steps"


def paths(functions: Sequence[TransferFunction]) -> list[LoopPath]:
    """Return the shortest path for every connected pair of a sensor and an actuator.

    A published message acts in the next step, and reaches other functions there; an input of the brain can be
    read one step later.

    Args:
        functions: the transfer functions.
    """
    read = {topic.name for function in functions for topic in function.subscribed}
    published = {topic.name for function in functions for topic in function.published}
    found = []
    for sensor in sorted(read - published):
        reached = _paths_from(functions, sensor)
        for actuator in sorted(published - read):
            ways = [reached[i] for i in reached if actuator in _names(functions[i].published)]
            if ways:
                steps, via = min(ways)
                found.append(LoopPath(sensor, actuator, steps + 1, via))
    return found


def _paths_from(functions: Sequence[TransferFunction], sensor: str) -> dict[int, tuple[int, tuple[str, ...]]]:
    """Return the number of steps and the path to each function that a sensor reaches (Dijkstra)."""
    queue: list[tuple[int, tuple[str, ...], int]] = [
        (0, (function.name,), i)
        for i, function in enumerate(functions)
        if sensor in _names(function.subscribed)
    ]
    reached: dict[int, tuple[int, tuple[str, ...]]] = {}
    while queue:
        steps, via, i = heapq.heappop(queue)
        if i in reached:
            continue
        reached[i] = (steps, via)
        for j, more, by in _next(functions, i):
            heapq.heappush(queue, (steps + more, (*via, by, functions[j].name), j))
    return reached


def _next(functions: Sequence[TransferFunction], i: int) -> Iterator[tuple[int, int, str]]:
    """Return the successors of a function: the function, the number of steps, and the link."""
    drives = any(isinstance(mapping, MapSpikeSource) for mapping in functions[i].mappings.values())
    for j, function in enumerate(functions):
        if drives and any(isinstance(mapping, MapSpikeSink) for mapping in function.mappings.values()):
            yield j, 1, BRAIN
        for topic in sorted(_names(functions[i].published) & _names(function.subscribed)):
            yield j, 1, topic


def _names(topics: Sequence[Topic]) -> set[str]:
    return {topic.name for topic in topics}
