"""A model as boxes and wires: topics, transfer functions, populations."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from nrp_bibi.generation.walk import parts
from nrp_bibi.model.channels import AnyDevice, Local, TopicChannel
from nrp_bibi.model.functions import (
    Bibi,
    BIBITransferFunction,
    Calls,
    ChannelTransferFunction,
    Neuron2Monitor,
    PythonTransferFunction,
    TransferFunction,
)
from nrp_bibi.model.selectors import NeuronSelector, NeuronSelectorTemplate
from nrp_bibi.reverse.wiring import Connection, connections

from nrp_cockpit.designer.connecting import POPULATION, TOPIC
from nrp_cockpit.designer.surroundings import Surroundings, Topic
from nrp_cockpit.designer.tree import FUNCTIONS, text_of

OTHER = "other:"
"""The beginning of the paths in other files."""
Box = dict[str, Any]
Wire = dict[str, Any]


class Graph:
    """The boxes and wires of a model.

    Args:
        model: the model.
        surroundings: the topics and populations of its experiment.
        shown: names of unused topics that are shown.

    Attributes:
        boxes: each with ``id``, ``kind``, ``name`` and the data of its kind.
        wires: each from one end to another; ``kind`` is message, drives or reads.
    """

    def __init__(self, model: Bibi, surroundings: Surroundings, shown: frozenset[str] = frozenset()) -> None:
        self._surroundings, self._shown = surroundings, shown
        self.wires: list[Wire] = []
        self._topics: dict[str, str] = {}
        self._neurons: dict[str, dict[str, None]] = {}
        functions = [self._function(one, f"{FUNCTIONS}/{place}")
                     for place, one in enumerate(model.transfer_function)]  # fmt: skip
        functions += [
            box for file, other in surroundings.others.items() for box in self._of_file(file, other)
        ]
        self.boxes: list[Box] = [*self._topic_boxes(), *functions, *self._population_boxes()]

    def data(self) -> dict[str, Any]:
        """Return boxes and wires."""
        return {"boxes": self.boxes, "wires": self.wires}

    # -- functions

    def _function(self, function: TransferFunction, path: str) -> Box:
        box = {"id": path, "kind": "function", "type": type(function).__name__,
               "active": function.active, "when": _when(function)}  # fmt: skip
        if isinstance(function, PythonTransferFunction):
            name = function.src or _first_name(function.code)
            rows = list(self._python_rows(function.code, path))
            return {**box, "kind": "python", "name": name, "code": function.code, "rows": rows}
        assert isinstance(function, BIBITransferFunction)
        return {**box, "name": function.name, "rows": list(self._rows(function, path))}

    def _of_file(self, file: str, model: Bibi) -> Iterator[Box]:
        """Yield the functions of another file that are connected to something; they are not edited here."""
        for place, function in enumerate(model.transfer_function):
            box = self._function(function, f"{OTHER}{file}/{place}")
            if box["rows"]:
                yield {**box, "kind": "other", "file": file}

    def _rows(self, function: BIBITransferFunction, path: str) -> Iterator[dict[str, Any]]:
        """Yield the parts of a function in the order in which they are drawn, and add their wires."""
        for place, topic in enumerate(getattr(function, "topic", ())):
            yield self._topic_row(topic, f"{path}/topic/{place}", path)
        returned = getattr(function, "return_value", None)
        if isinstance(returned, TopicChannel):
            yield self._topic_row(returned, f"{path}/return_value", path)
        for place, local in enumerate(function.local):
            yield _local_row(local, f"{path}/local/{place}")
        if isinstance(function, Neuron2Monitor):
            yield self._device_row(function.device, f"{path}/device", path, function.name)
            return
        for field in ("device", "device_group"):
            for place, device in enumerate(getattr(function, field, ())):
                yield self._device_row(device, f"{path}/{field}/{place}", path, function.name)
        if isinstance(returned, AnyDevice):
            yield self._device_row(returned, f"{path}/return_value", path, function.name)

    def _python_rows(self, code: str, path: str) -> Iterator[dict[str, Any]]:
        """Yield the ends of the decorators of Python functions, and add the wires."""
        found = connections(code)
        several = len({one.function for one in found}) > 1
        for place, one in enumerate(found):
            end = [path, f"{path}/python/{place}"]
            variable = one.variable or "return"
            if one.is_topic:
                others = [[f"{TOPIC}{name}"] * 2 for name in self._topics_of(one)]
            else:
                self._neurons.setdefault(one.target, {})[one.neurons] = None
                others = [[f"{POPULATION}{one.target}", f"{POPULATION}{one.neurons}"]]
            kind = "message" if one.is_topic else "drives" if one.is_written else "reads"
            for other in others:
                pair = (end, other) if one.is_written else (other, end)
                self.wires.append(_wire(kind, *pair))
            yield {
                "path": end[1], "kind": "topic" if one.is_topic else "device", "is_written": one.is_written,
                "name": f"{one.function}: {variable}" if several else variable,
                "type": one.kind.rpartition(".")[2], "text": "", "neurons": one.neurons,
                "device": f"{one.function}/{variable}",
            }  # fmt: skip

    def _topics_of(self, one: Connection) -> list[str]:
        """Return the topics of a connection, and record them; an f-string represents all that match."""
        parts = re.split(r"\{[^}]*\}", one.target) if one.is_pattern else [one.target]
        fits = re.compile("[^/]+".join(map(re.escape, parts)))
        found = [name for name in self._surroundings.topics if fits.fullmatch(name)] or [one.target]
        self._topics |= dict.fromkeys(found, one.kind)
        return found

    def _topic_row(self, channel: TopicChannel, path: str, box: str) -> dict[str, Any]:
        self._topics[channel.topic] = channel.type
        ends = [f"{TOPIC}{channel.topic}"] * 2, [box, path]
        written = channel.body is not None
        pair = (ends[1], ends[0]) if written else ends
        self.wires.append(_wire("message", pair[0], pair[1]))
        return {
            "path": path, "kind": "topic", "name": channel.name or "return", "is_written": written,
            "type": channel.type.rpartition(".")[2], "text": text_of(channel.body) if channel.body else "",
        }  # fmt: skip

    def _device_row(self, device: AnyDevice, path: str, box: str, function: str) -> dict[str, Any]:
        written = device.body is not None
        neurons = text_of(device.neurons)
        for population, chosen in _populations(device, neurons):
            self._neurons.setdefault(population, {})[chosen] = None
            ends = [f"{POPULATION}{population}", f"{POPULATION}{chosen}"], [box, path]
            pair = (ends[1], ends[0]) if written else ends
            self.wires.append(_wire("drives" if written else "reads", pair[0], pair[1]))
        text = f"{device.type.default_property} = {text_of(device.body)}" if device.body else ""
        return {
            "path": path, "kind": "device", "name": device.name, "is_written": written,
            "type": device.type.value, "text": text, "neurons": neurons,
            "device": f"{function}/{device.name}",
        }  # fmt: skip

    # -- topics and populations

    def _topic_boxes(self) -> Iterator[Box]:
        known = self._surroundings.topics
        for name, topic in known.items():
            if name in self._topics or name in self._shown or topic.is_near:
                yield self._topic_box(topic, is_known=True)
        for name, kind in self._topics.items():
            if name not in known:
                yield self._topic_box(Topic(name, kind, is_heard=True), is_known=not known)

    def _topic_box(self, topic: Topic, *, is_known: bool) -> Box:
        return {
            "id": f"{TOPIC}{topic.name}", "kind": "topic", "name": topic.name,
            "type": topic.type.rpartition(".")[2], "is_sent": topic.is_sent, "is_heard": topic.is_heard,
            "rate_hz": topic.rate_hz, "is_used": topic.name in self._topics, "is_known": is_known,
        }  # fmt: skip

    def _population_boxes(self) -> Iterator[Box]:
        sizes = self._surroundings.populations
        for name in dict.fromkeys((*sizes, *self._neurons)):
            chosen = self._neurons.get(name, {})
            rows = [{"path": f"{POPULATION}{text}", "text": text.removeprefix(name) or "all"}
                    for text in chosen]  # fmt: skip
            yield {
                "id": f"{POPULATION}{name}", "kind": "population", "name": name, "size": sizes.get(name),
                "rows": rows, "is_used": bool(chosen), "is_known": name in sizes or not sizes,
            }  # fmt: skip


def _local_row(local: Local, path: str) -> dict[str, Any]:
    return {"path": path, "kind": "local", "name": local.name, "type": "", "is_written": True,
            "text": text_of(local.body)}  # fmt: skip


def _populations(device: AnyDevice, neurons: str) -> Iterator[tuple[str, str]]:
    """Yield the populations that a device reaches, each with the text of the neurons there."""
    if isinstance(device.neurons, NeuronSelector):
        if device.neurons.population:
            yield device.neurons.population, neurons
        return
    found = (part for part in parts(device.neurons)
             if isinstance(part, (NeuronSelector, NeuronSelectorTemplate)) and part.population)  # fmt: skip
    for population in dict.fromkeys(str(part.population) for part in found):
        yield population, neurons if population in neurons else population


def _when(function: TransferFunction) -> str:
    """Return when a function runs, in a few words; nothing for every step."""
    if not isinstance(function, ChannelTransferFunction):
        return ""
    rate = function.throttling_rate
    on = "on each" if function.calls is Calls.EACH else "on"
    return ", ".join([f"{on} {name}" for name in function.trigger] + ([f"≤ {rate} Hz"] if rate else []))


def _wire(kind: str, source: list[str], target: list[str]) -> Wire:
    return {
        "id": f"{source[1]} > {target[1]}", "kind": kind,
        "source": source[0], "source_end": source[1], "target": target[0], "target_end": target[1],
    }  # fmt: skip


def _first_name(code: str) -> str:
    """Return the names of the functions in a piece of Python, preferably of those that are connected."""
    names = dict.fromkeys(one.function for one in connections(code)) or re.findall(r"(?m)^def (\w+)", code)
    return ", ".join(list(names)[:3]) or "Python"
