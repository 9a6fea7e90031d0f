"""New parts of a model: complete, with unique names."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from nrp_bibi.generation.walk import channels
from nrp_bibi.model.channels import DeviceChannel, DeviceType
from nrp_bibi.model.expressions import Constant, FlowExpression
from nrp_bibi.model.functions import (
    Bibi,
    BIBITransferFunction,
    Neuron2Monitor,
    Neuron2Robot,
    PythonTransferFunction,
)
from nrp_bibi.model.metamodel import Feature, Node, Value, concrete, features
from nrp_bibi.model.selectors import Index, MapSelector, NeuronSelector

from nrp_cockpit.designer.metamodel import device_kind
from nrp_cockpit.designer.surroundings import Surroundings

NO_POPULATION = "population"
_FIRST: dict[str, Any] = {
    "Natural": 0, "Positive": 1, "Number": 0, "Truth": False, "Topic": "/topic", "Template": "i", "Text": "",
    "Dotted": "std_msgs.msg.Float64", "File": "file", "Word": "name", "Path": "value",
}  # fmt: skip
_NAMES = {
    "Neuron2Robot": "to_robot", "Robot2Neuron": "to_neurons", "Neuron2Monitor": "monitor", "Local": "local",
    "DeviceChannel": "device", "DeviceGroupChannel": "devices", "TopicChannel": "topic",
}  # fmt: skip
_PYTHON = "@nrp.Robot2Neuron()\ndef {name}(t):\n    pass"


class Fresh:
    """Makes new parts.

    Args:
        model: their model.
        surroundings: the populations and topics to use.
        function: their transfer function.
    """

    def __init__(
        self, model: Bibi, surroundings: Surroundings, function: BIBITransferFunction | None = None
    ) -> None:
        self._model, self._surroundings, self._function = model, surroundings, function

    def make(self, kind: type[Node], **given: Any) -> Any:
        """Return a complete node of a class, or of its first concrete subclass."""
        kind = kind if not kind.abstract else self._usual(kind)
        if kind is PythonTransferFunction:
            return PythonTransferFunction(code=_PYTHON.format(name=self.name("python_function")))
        if issubclass(kind, DeviceChannel) and "type" not in given:
            given |= self._device_settings()
        if issubclass(kind, NeuronSelector) and given.get("population") is None:
            given["population"] = self.population()
        needed = (feature for feature in features(kind) if feature.least and feature.field not in given)
        return kind(**given, **{feature.field: self._first(kind, feature) for feature in needed})

    def name(self, wanted: str) -> str:
        """Return an unused name for a part, similar to the requested one."""
        plain = re.sub(r"\W+", "_", wanted).strip("_") or "name"
        plain = f"_{plain}" if plain[0].isdigit() else plain
        taken = set(self._taken())
        numbered = (f"{plain}_{i}" for i in range(2, len(taken) + 3))
        return plain if plain not in taken else next(name for name in numbered if name not in taken)

    def _taken(self) -> Iterable[str]:
        if self._function is not None:
            return [str(part.name) for part in (*channels(self._function), *self._function.local)]
        code = "\n".join(
            one.code for one in self._model.transfer_function if isinstance(one, PythonTransferFunction)
        )
        named = [one for one in self._model.transfer_function if isinstance(one, BIBITransferFunction)]
        return [*(one.name for one in named), *re.findall(r"def (\w+)", code)]

    def _usual(self, kind: type[Node]) -> type[Node]:
        if kind is FlowExpression:
            return Constant
        if kind is NeuronSelector:
            return Index
        return next(iter(concrete(kind).values()))

    def _first(self, kind: type[Node], feature: Feature) -> Any:
        one = self._of(kind, feature)
        return (one,) * feature.least if feature.many else one

    def _of(self, kind: type[Node], feature: Feature) -> Any:
        if not isinstance(feature.of, Value):
            return self.make(feature.of)
        if feature.field == "population":
            return self.population()
        if feature.of.name == "Name":
            return self.name(_NAMES.get(kind.__name__, "name"))
        found = [text for facet, text in feature.of.facets if facet == "enumeration"]
        return feature.of.parse(found[0]) if found else _FIRST[feature.of.name]

    def population(self) -> str:
        """Return the first population of the brain."""
        return next(iter(self._surroundings.populations), NO_POPULATION)

    def _device_settings(self) -> dict[str, Any]:
        """Return the type of a new device of the function; a device that drives neurons has a body."""
        match self._function:
            case Neuron2Robot():
                kind = DeviceType.LEAKY_INTEGRATOR_ALPHA
            case Neuron2Monitor() | None:
                kind = DeviceType.SPIKE_RECORDER
            case _:
                kind = DeviceType.POISSON
        return {"type": kind, **({"body": Constant(value=0)} if device_kind(kind).drives else {})}


def whole_neurons(node: Node, population: str) -> Node:
    """Return a selector with its neurons in another population."""
    fields = {feature.field: getattr(node, feature.field) for feature in features(type(node))}
    if isinstance(node, MapSelector):
        return MapSelector(**{**fields, "pattern": whole_neurons(node.pattern, population)})
    return type(node)(**{**fields, "population": population} if "population" in fields else fields)
