"""How long it takes from a sensor to an actuator, in steps, read off the mappings."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.functions.mappings import MapSpikeSink, MapSpikeSource
from nrp_core.dsl.parameters.topics import Topic

BRAIN = "brain"


@dataclass(frozen=True, slots=True)
class LoopPath:
    """The shortest way from a sensor to an actuator.

    Args:
        sensor: topic that a function reads and none publishes.
        actuator: topic that a function publishes on and none reads.
        steps: from the step in which the sensor sampled to the first in which the actuator acts on
            it; rates, throttling and the brain's own delays come on top.
        via: transfer functions, ``brain`` and topics between functions, in order.
    """

    sensor: str
    actuator: str
    steps: int
    via: tuple[str, ...]

    def __str__(self) -> str:
        return f"{' -> '.join((self.sensor, *self.via, self.actuator))}: {self.steps} steps"


def paths(functions: Sequence[TransferFunction]) -> list[LoopPath]:
    """Return the shortest path of every sensor and actuator that are connected.

    What a function sends acts in the next step; what it writes to the brain can be read one step
    later; what it sends to a function that runs after it arrives in the same step.

    Args:
        functions: in the order in which they run.
    """
    read = {topic.name for function in functions for topic in function.subscribed}
    published = {topic.name for function in functions for topic in function.published}
    found = []
    for sensor in sorted(read - published):
        reached = _reached(functions, sensor)
        for actuator in sorted(published - read):
            ways = [reached[i] for i in reached if actuator in _names(functions[i].published)]
            if ways:
                steps, via = min(ways)
                found.append(LoopPath(sensor, actuator, steps + 1, via))
    return found


def _reached(functions: Sequence[TransferFunction], sensor: str) -> dict[int, tuple[int, tuple[str, ...]]]:
    """Return, for each function that a sensor reaches, after how many steps and by which way (Dijkstra)."""
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
    """Return what a function hands on to: which function, after how many steps, by what."""
    drives = any(isinstance(mapping, MapSpikeSource) for mapping in functions[i].mappings.values())
    for j, function in enumerate(functions):
        if drives and any(isinstance(mapping, MapSpikeSink) for mapping in function.mappings.values()):
            yield j, 1, BRAIN
        for topic in sorted(_names(functions[i].published) & _names(function.subscribed)):
            yield j, 0 if i < j else 1, topic


def _names(topics: Sequence[Topic]) -> set[str]:
    return {topic.name for topic in topics}
