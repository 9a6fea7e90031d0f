"""What files of the platform call ``nrp``: our language, with the spellings that it had there."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any

from nrp_core import dsl
from nrp_core.dsl.kinds import DeviceKind
from nrp_legacy.devices import device_kinds, in_our_units
from nrp_legacy.shims.graph import absolute
from nrp_legacy.shims.modules import module

__extends_dsl__ = True
"""What goes wrong here is the fault of whoever calls; see :mod:`nrp_core.dsl.place`."""

SPELLINGS = {
    "std": "stdev", "weights": "weight", "delays": "delay", "target": "receptor_type", "initial_rate": "rate",
    "C_m": "cm", "t_ref": "tau_refrac", "V_th": "v_thresh", "V_reset": "v_reset", "E_L": "v_rest",
    "tau_syn_ex": "tau_syn_E", "tau_syn_in": "tau_syn_I", "I_e": "i_offset",
}  # fmt: skip
"""Settings of devices under the names that they have here."""


class Unavailable:
    """A kind of device that only one simulator of the platform had.

    Args:
        name: what users write.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    def __repr__(self) -> str:
        return self.name


def topic(name: str, topic_type: Any = None) -> dsl.Topic:
    """Return a topic; a name without a slash at its beginning is absolute as well."""
    return dsl.Topic(absolute(name).rstrip("/"), topic_type)


def resolve(function: Callable[..., Any]) -> Any:
    """Return what a function of nothing, of the brain, or of the brain and its adapter gives."""
    count = len(inspect.signature(function).parameters)
    return dsl.resolve(lambda root: function(*(root, None)[:count]))


def framework(notes: Callable[[str], None], *, nest_units: bool = False) -> ModuleType:
    """Return the module for one experiment.

    Args:
        notes: told what is left out of a mapping.
        nest_units: whether settings and attributes of devices are in pA, nS and pF.
    """

    def settings(device_type: Any, given: Mapping[str, Any]) -> dict[str, Any]:
        taken = _settings(device_type, given, notes)
        return in_our_units(taken) if nest_units and isinstance(device_type, DeviceKind) else taken

    class MapSpikeSink(dsl.MapSpikeSink):
        def __init__(self, key: str, value: Any, device_type: Any, **kwargs: Any) -> None:
            super().__init__(key, value, device_type, **settings(device_type, kwargs))

    class MapSpikeSource(dsl.MapSpikeSource):
        def __init__(self, key: str, value: Any, device_type: Any, **kwargs: Any) -> None:
            super().__init__(key, value, device_type, **settings(device_type, kwargs))

    class MapRobotSubscriber(dsl.MapRobotSubscriber):
        def __init__(self, key: str, value: Any, initial_value: Any = None, **_queues: Any) -> None:
            super().__init__(
                key, topic(value) if isinstance(value, str) else value, initial_value=initial_value
            )

    class MapRobotPublisher(dsl.MapRobotPublisher):
        def __init__(self, key: str, value: Any, **_queues: Any) -> None:
            super().__init__(key, topic(value) if isinstance(value, str) else value)

    own = {name: getattr(dsl, name) for name in dsl.__all__}
    mappings = (MapSpikeSink, MapSpikeSource, MapRobotSubscriber, MapRobotPublisher)
    return module(
        "hbp_nrp_cle.tf_framework",
        **{
            **own,
            **device_kinds(nest_units=nest_units),
            **{mapping.__name__: mapping for mapping in mappings},
            "Topic": topic, "resolve": resolve,
            "raw_signal": Unavailable("raw_signal"),
            "config": module("config", brain_root=dsl.brain, brain_source=None),
        },
    )  # fmt: skip


def _settings(device_type: Any, given: Mapping[str, Any], notes: Callable[[str], None]) -> dict[str, Any]:
    """Return the settings of a device under the names that it has here; what it has not is left out."""
    if not isinstance(device_type, DeviceKind):
        return dict(given)
    connector = given.get("connector")
    wired = (
        {key: connector[key] for key in ("weight", "delay", "weights", "delays") if key in connector}
        if (isinstance(connector, Mapping))
        else {}
    )
    named = {SPELLINGS.get(name, name): value for name, value in {**wired, **given}.items()}
    if "stop" in named and "stop" not in device_type.options:
        named["duration"] = named.pop("stop") - named.get("start", 0.0)
    taken = {
        name: value for name, value in named.items() if name in device_type.options and value is not None
    }
    for name in sorted(named.keys() - taken.keys() - {"connector"}):
        if named[name] is not None:
            notes(f"{device_type} has no setting '{name}' here: left out")
    return taken
