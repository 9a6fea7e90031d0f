"""The module ``nrp`` of files of the platform: our language, with the platform's spellings."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from types import ModuleType
from typing import Any

from nrp_core import dsl
from nrp_core.dsl.devices.kinds import DeviceKind
from nrp_core.dsl.functions.variables import Variable
from nrp_core.dsl.parameters.binding import Binding
from nrp_core.dsl.selection.selectors import evaluate
from nrp_core.findings import Code
from nrp_legacy.brain_root import Brain
from nrp_legacy.devices import device_kinds, in_our_units, recovering_at_once
from nrp_legacy.live.cells import Cells
from nrp_legacy.notes import Notes
from nrp_legacy.shims.graph import absolute, log
from nrp_legacy.shims.message_numbers import with_numbers
from nrp_legacy.shims.modules import OpenMessage, module
from nrp_legacy.shims.tuples import as_in_ros1

__extends_dsl__ = True
"""Errors here are reported at the caller; see :mod:`nrp_core.dsl.parameters.source_line`."""

SPELLINGS = {
    "std": "stdev", "weights": "weight", "delays": "delay", "target": "receptor_type", "initial_rate": "rate",
    "C_m": "cm", "t_ref": "tau_refrac", "V_th": "v_thresh", "V_reset": "v_reset", "E_L": "v_rest",
    "tau_syn_ex": "tau_syn_E", "tau_syn_in": "tau_syn_I", "I_e": "i_offset",
}  # fmt: skip
"""Settings of devices under the names that they have here."""


class Unavailable:
    """A kind of device that only one simulator of the platform had.

    Args:
        name: its name in transfer functions.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    def __repr__(self) -> str:
        return self.name


class ForgivingTopic(dsl.Topic):
    """A topic that takes arrays of one number for the number, as the messages of ROS 1 did, and nan for 0.

    If nothing is known of its messages, a value that is sent is the value of their first field.
    """

    __slots__ = ()

    @property
    def process(self) -> Callable[[Any], Any]:
        kind = self.topic_type
        if isinstance(kind, type) and issubclass(kind, OpenMessage):
            return lambda message: message if isinstance(message, OpenMessage) else kind(message)
        return partial(with_numbers, tell=cache(partial(self._tell, self.name)))

    @staticmethod
    def _tell(name: str, number: str) -> None:
        log.warning("a message for %s contains %s: 0 is sent instead", name, number)


def _heard(named: Any) -> Any:
    """Return a topic whose messages are those of ROS 1."""
    if isinstance(named, dsl.PreprocessedTopic):
        after = named.pre_processing
        return replace(named, pre_processing=lambda message: after(as_in_ros1(message)))
    return HeardTopic(named.name, named.topic_type) if isinstance(named, dsl.Topic) else named


class HeardTopic(dsl.Topic):
    """A topic whose messages are those of ROS 1."""

    __slots__ = ()

    @property
    def process(self) -> Callable[[Any], Any]:
        return as_in_ros1


def topic(name: str, topic_type: Any = None) -> dsl.Topic:
    """Return a topic; a name without a slash at its beginning is absolute as well."""
    return ForgivingTopic(absolute(name).rstrip("/"), topic_type)


def resolve(brain: Any, function: Callable[..., Any]) -> Any:
    """Call a function without arguments, with the brain, or with the brain and its adapter."""
    count = len(inspect.signature(function).parameters)
    return dsl.resolve(lambda _root: function(*(brain, None)[:count]))


class SameVariable(Variable):
    """A variable with the user's object itself, because a copy would not be the one in callbacks."""

    __slots__ = ()

    def begin_with(self, initial: Any) -> None:
        if self._initial is None and _is_of_users(initial):
            self._initial = self.value = initial
        else:
            super().begin_with(initial)

    def reset(self) -> None:
        if _is_of_users(self._initial):
            self.value = self._initial
        else:
            super().reset()


def _holds_cells(value: Any) -> bool:
    """Return whether a value has cells of the running brain, whose methods a function may call."""
    return isinstance(value, Cells) or (isinstance(value, (list, tuple)) and any(map(_holds_cells, value)))


def _is_of_users(value: Any) -> bool:
    return type(value).__module__.partition(".")[0] not in ("builtins", "numpy", "collections", "nrp_core")


def framework(
    notes: Notes,
    noted_late: Notes | None = None,
    *,
    nest_units: bool = False,
    brain_root: Any = dsl.brain,
) -> ModuleType:
    """Return the module for one experiment.

    Args:
        notes: receives a note about each argument left out of a mapping.
        noted_late: receives notes during the run, about values that no device can have; None: as ``notes``.
        nest_units: whether settings and attributes of devices are in pA, nS and pF.
        brain_root: the module of the brain file.
    """

    def settings(device_type: Any, given: Mapping[str, Any]) -> dict[str, Any]:
        taken = recovering_at_once(_settings(device_type, given, notes))
        return in_our_units(taken) if nest_units and isinstance(device_type, DeviceKind) else taken

    class MapSpikeSink(dsl.MapSpikeSink):
        def __init__(self, key: str, value: Any, device_type: Any, **kwargs: Any) -> None:
            super().__init__(key, value, device_type, **settings(device_type, kwargs))

    class MapSpikeSource(dsl.MapSpikeSource):
        def __init__(self, key: str, value: Any, device_type: Any, **kwargs: Any) -> None:
            super().__init__(key, value, device_type, **settings(device_type, kwargs))

    class MapRobotSubscriber(dsl.MapRobotSubscriber):
        def __init__(self, key: str, value: Any, initial_value: Any = None, **_queues: Any) -> None:
            named = topic(value) if isinstance(value, str) else value
            super().__init__(key, _heard(named), initial_value=initial_value)

    class MapRobotPublisher(dsl.MapRobotPublisher):
        def __init__(self, key: str, value: Any, **_queues: Any) -> None:
            super().__init__(key, topic(value) if isinstance(value, str) else value)

    class MapVariable(dsl.MapVariable):
        def _do_bind(self, binding: Binding) -> Variable:
            given = self.initial_value
            initial = given if _holds_cells(given) else evaluate(given, binding.root)
            shared = {} if self.global_key is None else binding.variables
            name = self.global_key or self.parameter
            variable: Variable = shared.setdefault(name, SameVariable(name))
            variable.begin_with(initial)
            return variable

    brain = Brain(brain_root)
    own = {name: getattr(dsl, name) for name in dsl.__all__}
    mappings = (MapSpikeSink, MapSpikeSource, MapRobotSubscriber, MapRobotPublisher, MapVariable)
    return module(
        "hbp_nrp_cle.tf_framework",
        **{
            **own,
            **device_kinds(noted_late or notes, nest_units=nest_units),
            **{mapping.__name__: mapping for mapping in mappings},
            "Topic": topic, "resolve": partial(resolve, brain), "brain": brain,
            "raw_signal": Unavailable("raw_signal"),
            "config": module("config", brain_root=brain_root, brain_source=None, active_node=None),
        },
    )  # fmt: skip


def _settings(device_type: Any, given: Mapping[str, Any], notes: Notes) -> dict[str, Any]:
    """Return the settings of a device by their names here, without unknown ones."""
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
            notes(Code.NRP287, f"{device_type} does not have the setting '{name}': left out", subject=name)
    return taken
