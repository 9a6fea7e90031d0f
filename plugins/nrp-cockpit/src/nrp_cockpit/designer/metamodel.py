"""The metamodel of BIBI as data, from which the page builds its forms."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from nrp_bibi.model.channels import DEVICE_TYPE, DeviceType
from nrp_bibi.model.functions import Bibi
from nrp_bibi.model.metamodel import Feature, Node, Value, concrete, features

from nrp_core import dsl
from nrp_core.dsl import DEVICES, DeviceKind
from nrp_core.errors import BackendError

_UNITS = {"rate": "Hz", "voltage": "mV", "amplitude": "nA", "mean": "nA"}
"""The units of device values."""


def metamodel_data() -> dict[str, Any]:
    """Return every class that a model can hold, and the kinds of devices."""
    return {
        "classes": classes_data(Bibi),
        "devices": {**{kind.value: _device_data(kind) for kind in DeviceType}, **_packaged_devices()},
    }


def classes_data(root: type[Node]) -> dict[str, Any]:
    """Return every class that a node can hold, by name."""
    return {node.__name__: _class_data(node) for node in reachable(root)}


def reachable(root: type[Node]) -> list[type[Node]]:
    """Return the classes that a node can hold, itself first, in order of appearance."""
    found: dict[str, type[Node]] = {}
    todo = [root]
    while todo:
        node = todo.pop(0)
        if node.__name__ in found:
            continue
        found[node.__name__] = node
        todo += concrete(node).values()
        if not node.abstract:
            todo += [feature.of for feature in features(node) if not isinstance(feature.of, Value)]
    return list(found.values())


def device_kind(kind: DeviceType) -> DeviceKind:
    """Return a kind of device as used by transfer functions."""
    found: DeviceKind = getattr(dsl, kind.dsl_name)
    return found


def _class_data(node: type[Node]) -> dict[str, Any]:
    return {
        "summary": (node.__doc__ or "").partition("\n")[0].replace("``", ""),
        "choices": list(concrete(node)),
        "features": [] if node.abstract else [_feature_data(node, feature) for feature in features(node)],
    }


def _feature_data(node: type[Node], feature: Feature) -> dict[str, Any]:
    value = feature.of if isinstance(feature.of, Value) else None
    default = node.__dataclass_fields__[feature.field].default
    return {
        "field": feature.field,
        "name": feature.name,
        "of": feature.of.name if value else feature.of.__name__,  # type: ignore[union-attr]
        "is_node": value is None,
        "many": feature.many,
        "least": feature.least,
        "unit": feature.unit,
        "expects": value.expects if value else "",
        "enumeration": _enumerated(value) if value else [],
        "default": value.show(default) if value and _is_given(default) else "",
    }


def _enumerated(value: Value) -> list[str]:
    ours = [text for facet, text in value.facets if facet == "enumeration"]
    return [*ours, *_packaged_devices()] if value is DEVICE_TYPE else ours


def _is_given(default: object) -> bool:
    return isinstance(default, (bool, int, float, str)) and default != ""


def _packaged_devices() -> dict[str, Any]:
    """Return the devices that packages register, without those that cannot be used."""
    found = {}
    for name in DEVICES.names():
        with suppress(BackendError):
            one = DEVICES.load(name)
            found[name] = {"drives": one.drives, "property": one.default_property, "unit": ""}
    return found


def _device_data(kind: DeviceType) -> dict[str, Any]:
    device = device_kind(kind)
    return {
        "drives": device.drives,
        "property": kind.default_property,
        "unit": _UNITS.get(kind.default_property, ""),
    }
