"""Connections of boxes: which ends can be connected, and why others cannot.

An end of a connection is ``topic:/husky/camera``, ``population:sensors``, neurons that a function uses
already (``population:sensors[0, 2]``), or the path of a function or of one of its channels and locals.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from nrp_bibi.generation.walk import parts
from nrp_bibi.model.channels import AnyDevice, DeviceChannel, Local, TopicChannel
from nrp_bibi.model.expressions import ArgumentReference, Call
from nrp_bibi.model.functions import (
    BIBITransferFunction,
    Neuron2Monitor,
    Neuron2Robot,
    PythonTransferFunction,
    TransferFunction,
)
from nrp_bibi.model.selectors import Index, NeuronSelector

from nrp_cockpit.designer.edit import Edit
from nrp_cockpit.designer.fresh import Fresh, whole_neurons
from nrp_cockpit.designer.surroundings import Topic
from nrp_cockpit.designer.tree import at, function_of, replaced, text_of, walk
from nrp_core.errors import ExperimentError

TOPIC, POPULATION = "topic:", "population:"


class Connecting:
    """Connects the ends of an edit's model.

    Args:
        edit: the edit.
    """

    def __init__(self, edit: Edit) -> None:
        self._edit = edit

    def connect(self, source: str, target: str) -> None:
        """Connect two ends, in either order.

        Raises:
            ExperimentError: they cannot be connected; the message gives the reason.
        """
        ends = sorted((source, target), key=_order)
        match [_kind(end) for end in ends]:
            case ["topic", "topic"]:
                raise ExperimentError("two topics need a transfer function between them")
            case ["population", "population"]:
                raise ExperimentError("the brain connects its populations; transfer functions cannot")
            case ["topic", "population"]:
                raise ExperimentError("a topic and neurons need a transfer function between them: add one")
            case ["topic", _]:
                self._with_topic(self._topic(ends[0]), ends[1])
            case ["population", _]:
                self._with_neurons(ends[0].removeprefix(POPULATION), ends[1])
            case _:
                self._inside(source, target)

    # -- topics

    def _topic(self, end: str) -> Topic:
        name = end.removeprefix(TOPIC)
        known = self._edit.surroundings.topics
        return known[name] if name in known else Topic(name, self._type_in_use(name), is_heard=True)

    def _type_in_use(self, name: str) -> str:
        used = (part for part in parts(self._edit.model) if isinstance(part, TopicChannel))
        return next((part.type for part in used if part.topic == name), "std_msgs.msg.Float64")

    def _with_topic(self, topic: Topic, end: str) -> None:
        part = self._end(end)
        if isinstance(part, TopicChannel):
            self._retarget(topic, end, part)
            return
        function = self._blocks(end)
        if isinstance(function, Neuron2Monitor):
            raise ExperimentError(f"a monitor shows a device on neurons; {topic.name} is a topic")
        if isinstance(part, (AnyDevice, Local)):
            what = "a device on neurons" if isinstance(part, AnyDevice) else "a variable"
            raise ExperimentError(
                f"'{part.name}' is {what}; {topic.name} is a topic: drop it on the function"
            )
        self._add_topic(topic, end, function)

    def _add_topic(self, topic: Topic, end: str, function: BIBITransferFunction) -> None:
        written = topic.is_heard and (isinstance(function, Neuron2Robot) or not topic.is_sent)
        for channel in (*getattr(function, "topic", ()), getattr(function, "return_value", None)):
            if isinstance(channel, TopicChannel) and channel.topic == topic.name:
                raise ExperimentError(f"'{function.name}' is already connected to {topic.name}")
        body = Call(type=topic.type) if written else None
        if written and isinstance(function, Neuron2Robot) and function.return_value is None:
            self._edit.put(end, "return_value", TopicChannel(topic=topic.name, type=topic.type, body=body))
            return
        fresh = Fresh(self._edit.model, self._edit.surroundings, function)
        name = fresh.name(topic.name.rstrip("/").rpartition("/")[2])
        self._edit.put(end, "topic", TopicChannel(name=name, topic=topic.name, type=topic.type, body=body))

    def _retarget(self, topic: Topic, end: str, channel: TopicChannel) -> None:
        if channel.body is None and not topic.is_sent:
            raise ExperimentError(f"{topic.name} is a command: it can only be published")
        if channel.body is not None and not topic.is_heard:
            raise ExperimentError(f"{topic.name} is published by the robot: it can only be read")
        new = replace(channel, topic=topic.name, type=topic.type)
        self._edit.model = replaced(self._edit.model, end, new)
        self._edit.selected = end

    # -- neurons

    def _with_neurons(self, neurons: str, end: str) -> None:
        part = self._end(end)
        if isinstance(part, (TopicChannel, Local)):
            what = "a topic" if isinstance(part, TopicChannel) else "a variable"
            raise ExperimentError(
                f"{_name(part)} is {what}; {neurons} are neurons: drop them on the function"
            )
        function = self._blocks(end)
        if isinstance(function, Neuron2Monitor):
            part, end = function.device, f"{function_of(end)}/device"
        if isinstance(part, AnyDevice):
            new = replace(part, neurons=self._neurons_of(part, neurons))
            self._edit.model = replaced(self._edit.model, end, new)
            self._edit.selected = end
            return
        fresh = Fresh(self._edit.model, self._edit.surroundings, function)
        chosen = self._known(neurons) or self._next(neurons, function)
        name = fresh.name(text_of(chosen))
        self._edit.put(end, "device", fresh.make(DeviceChannel, name=name, neurons=chosen))

    def _neurons_of(self, device: AnyDevice, neurons: str) -> Any:
        known = self._known(neurons)
        fits = known is not None and isinstance(device, DeviceChannel)
        return known if fits else whole_neurons(device.neurons, neurons.partition("[")[0])

    def _known(self, neurons: str) -> NeuronSelector | None:
        """Return neurons that are already in use, by their text."""
        if "[" not in neurons:
            return None
        selectors = (part for _, part in walk(self._edit.model) if isinstance(part, NeuronSelector))
        return next((one for one in selectors if text_of(one) == neurons), None)

    def _next(self, neurons: str, function: BIBITransferFunction) -> Index:
        """Return the first neuron of a population that is not yet alone on a device of a function."""
        population = neurons.partition("[")[0]
        devices = getattr(function, "device", ())
        taken = {one.neurons.index for one in devices
                 if isinstance(one.neurons, Index) and one.neurons.population == population}  # fmt: skip
        size = self._edit.surroundings.populations.get(population, len(taken) + 1)
        free = (index for index in range(size) if index not in taken)
        return Index(population=population, index=next(free, 0))

    # -- variables

    def _inside(self, source: str, target: str) -> None:
        parts_ = [self._end(end) for end in (source, target)]
        if any(isinstance(part, TransferFunction) for part in parts_):
            raise ExperimentError("functions exchange values over topics or neurons, not directly")
        if function_of(source) != function_of(target):
            raise ExperimentError("a variable is known only inside its function; send it over a topic")
        read, written = sorted(parts_, key=_is_written)
        if not _is_written(written) or read is written:
            raise ExperimentError("both are read; one of them must be written")
        if _is_written(read) and not isinstance(read, Local):
            raise ExperimentError("both are written; one of them must be read")
        where = source if at(self._edit.model, source) is written else target
        named = ArgumentReference(name=str(read.name), property=_property(read))
        self._edit.model = replaced(self._edit.model, where, replace(written, body=named))
        self._edit.selected = where

    def _end(self, end: str) -> Any:
        """Return the part of the model at an end."""
        part = at(self._edit.model, end)
        if not isinstance(part, (TransferFunction, TopicChannel, AnyDevice, Local)):
            raise ExperimentError(f"'{end}' is not an end of a wire")
        return part

    def _blocks(self, end: str) -> BIBITransferFunction:
        found = at(self._edit.model, function_of(end))
        if isinstance(found, PythonTransferFunction):
            raise ExperimentError("this function is Python: its code says what it is connected to")
        assert isinstance(found, BIBITransferFunction)
        return found


def _order(end: str) -> int:
    return (TOPIC, POPULATION, "").index(next((k for k in (TOPIC, POPULATION) if end.startswith(k)), ""))


def _kind(end: str) -> str:
    return ("topic", "population", "part")[_order(end)]


def _is_written(part: Any) -> int:
    """Return a rank by which parts that are written sort last; locals can be both."""
    if isinstance(part, Local):
        return 1
    return 0 if part.body is None else 2


def _property(part: Any) -> str | None:
    if isinstance(part, TopicChannel):
        return "value"
    return part.type.default_property if isinstance(part, AnyDevice) else None


def _name(part: TopicChannel | Local) -> str:
    return "the return value" if part.name is None else f"'{part.name}'"
