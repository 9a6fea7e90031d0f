"""The module ``nrp`` of files of the platform: our language, with the platform's spellings and devices.

Where NEST is used directly, devices are set in pA, nS and pF. ``nrp.config.brain_root`` and ``nrp.brain``
have the variables of the brain file.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from math import inf
from types import ModuleType
from typing import Any, ClassVar, Literal, NoReturn
from weakref import WeakSet

import numpy as np
from nrp_pynest.built import to_built_brain
from nrp_pynest.models import valid_recovery_ms

from nrp_core import dsl
from nrp_core.brain import Brain as RunningBrain
from nrp_core.brain import Network
from nrp_core.clock import from_milliseconds, seconds
from nrp_core.dsl import (
    Binding,
    CurrentGenerator,
    Device,
    DeviceKind,
    LeakyIntegratorDevice,
    NoiseCurrentGenerator,
    Port,
    Selection,
    Selector,
    SettableAttribute,
    SineCurrentGenerator,
    SpikeGenerator,
    Variable,
    evaluate,
)
from nrp_core.dsl import brain as any_brain
from nrp_core.errors import CapabilityError
from nrp_core.findings import Code
from nrp_legacy.code import Notes
from nrp_legacy.live.cells import Cells
from nrp_legacy.shims.graph import absolute, log
from nrp_legacy.shims.modules import OpenMessage, as_in_ros1, module, with_numbers

_STEP_MS = 1.0
"""The time step of a machine whose network does not set another."""


class SendingIntegrator(LeakyIntegratorDevice):
    """A leaky integrator that sends its voltage each time a number of time steps of its network has passed.

    Args:
        timesteps: this number.
    """

    __slots__ = ("_brain", "_period_ns", "_sent", "_timesteps")

    options: ClassVar[tuple[str, ...]] = ("timesteps",)

    def __init__(
        self,
        parameter: str,
        port: Port,
        selection: Selection,
        release: Callable[[], None],
        *,
        timesteps: float = 10,
    ) -> None:
        super().__init__(parameter, port, selection, release)
        if not timesteps >= 1:
            raise ValueError(f"timesteps must be 1 or more, not {timesteps}")
        self._timesteps = int(timesteps)
        self._sent = 0

    def attach(self, brain: RunningBrain) -> None:
        """Follow the time of a brain."""
        self._brain = brain
        self._period_ns = from_milliseconds(self._timesteps * (brain.network.timestep_ms or _STEP_MS))
        self.refresh(brain.now_ns)

    def has_news(self) -> bool:
        return self._brain.now_ns // self._period_ns > self._sent

    def refresh(self, now_ns: int) -> None:
        self._sent = now_ns // self._period_ns

    def reset(self) -> None:
        self._sent = 0

    def save(self) -> Any:
        return self._sent

    def restore(self, saved: Any) -> None:
        self._sent = saved


class SendingKind(DeviceKind):
    """A kind of leaky integrator that can trigger functions."""

    __slots__ = ()

    def open(
        self, binding: Binding, selection: Selection, options: Mapping[str, Any], *, parameter: str, name: str
    ) -> Device:
        device = super().open(binding, selection, options, parameter=parameter, name=name)
        assert isinstance(device, SendingIntegrator)
        device.attach(binding.brain)
        return device


def sending_kind(kind: DeviceKind) -> SendingKind:
    """Return a kind of leaky integrator whose devices can trigger functions."""
    return SendingKind(kind.name, kind.spec, SendingIntegrator, kind.defaults)


_KILO = 1e-3
_LARGEST = sys.float_info.max
_SMALL = frozenset({"amplitude", "offset", "mean", "stdev", "weight", "cm", "i_offset"})
"""Settings in nA, uS or nF, which NEST has in pA, nS or pF."""


class _Forgiving(SettableAttribute):
    """An attribute with another name or unit; invalid values become the nearest valid value.

    Args:
        name: name of the port's attribute.
        scale: factor from the user's unit to that of the port.
        lowest: the lowest valid value.
    """

    def __init__(self, name: str, scale: float = 1.0, lowest: float = -inf) -> None:
        super().__init__(f"{name}, as on the platform.")
        self._port_name, self._scale, self._lowest = name, scale, lowest
        self._told: WeakSet[Any] = WeakSet()

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = self._port_name

    def __get__(self, device: Device | None, owner: type) -> Any:
        value = super().__get__(device, owner)
        return value if device is None else value / self._scale

    def __set__(self, device: Device, value: Any) -> None:
        if isinstance(value, (int, float)) and max(self._lowest, -_LARGEST) <= value <= _LARGEST:
            super().__set__(device, value * self._scale)
            return
        given = np.asarray(value, dtype=float) * self._scale
        taken = np.maximum(np.where(np.isfinite(given), given, 0.0), self._lowest)
        if (taken != given).any() and device.port not in self._told:
            self._told.add(device.port)
            message = f"{device.parameter}: {self._port_name} cannot be {value}: set to {taken}"
            type(device).notes(Code.NRP240, message, subject=device.parameter)  # type: ignore[attr-defined]
        super().__set__(device, taken.item() if taken.size == 1 else taken)


_CURRENTS: tuple[tuple[str, type[Device], dict[str, float]], ...] = (
    ("dc_source", CurrentGenerator, {"amplitude": -inf}),
    ("ac_source", SineCurrentGenerator, {"amplitude": -inf, "offset": -inf}),
    ("nc_source", NoiseCurrentGenerator, {"mean": -inf, "stdev": 0.0}),
)
"""Sources of currents: the kind, its class of devices, and the lowest valid value of each attribute."""


def _lenient(
    device: type[Device], lowest: Mapping[str, float], notes: Notes, scale: float = 1.0
) -> type[Device]:
    """Return a class of devices with attributes of another unit, which accept any value."""
    attributes: dict[str, Any] = {name: _Forgiving(name, scale, least) for name, least in lowest.items()}
    if "stdev" in lowest:  # NEST's name of it
        attributes["std"] = _Forgiving("stdev", scale, lowest["stdev"])
    return type(device.__name__, (device,), {"__slots__": (), "notes": staticmethod(notes), **attributes})


def device_kinds(notes: Notes, *, nest_units: bool) -> dict[str, DeviceKind]:
    """Return the lenient kinds of devices, by name.

    Args:
        notes: receives a note about each value that no device can have.
        nest_units: whether currents are in pA.
    """
    scale = _KILO if nest_units else 1.0
    devices = {name: _lenient(device, lowest, notes, scale) for name, device, lowest in _CURRENTS}
    devices |= dict.fromkeys(("poisson", "fixed_frequency"), _lenient(SpikeGenerator, {"rate": 0.0}, notes))
    forgiving = {name: replace(getattr(dsl, name), device=device) for name, device in devices.items()}
    integrators = (dsl.leaky_integrator_alpha, dsl.leaky_integrator_exp)
    return {**forgiving, **{kind.name: sending_kind(kind) for kind in integrators}}


def with_instant_recovery(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings in which synapses may have a time constant of recovery of 0, as on the platform."""
    law = settings.get("synapse_type")
    if not isinstance(law, Mapping) or not isinstance(law.get("tau_rec"), (int, float)):
        return dict(settings)
    return {**settings, "synapse_type": {**law, "tau_rec": valid_recovery_ms(law["tau_rec"])}}


def in_our_units(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings in the units of NEST in ours."""
    return {name: _scaled(value) if name in _SMALL else value for name, value in settings.items()}


def _scaled(value: Any) -> Any:
    return [_scaled(one) for one in value] if isinstance(value, (list, tuple)) else value * _KILO


_NOTHING = object()


class BrainRoot:
    """The module of the brain file; changes of its cells and synapses change the running brain.

    Args:
        network: the network that the file has built; None before that.
    """

    def __init__(self, network: Network | None) -> None:
        self._network = network
        self._built = None if network is None else to_built_brain(network)

    def __deepcopy__(self, memo: object) -> BrainRoot:
        """Return the root itself, so that variables are not copies."""
        return self

    def __getattr__(self, name: str) -> Any:
        if name[:2] == "__":
            raise AttributeError(name)
        found = self.found(name)
        return getattr(any_brain, name) if found is _NOTHING else found

    def found(self, name: str) -> Any:
        """Return the neurons of this name, otherwise the value of the file's variable."""
        network, built = self._network, self._built
        if network is None or built is None:
            return _NOTHING
        if name in network.views or name in network.populations:
            return Cells(built, f"brain.{name}", network.neurons(name))
        if name in built.variables:
            return built.show(built.variables[name], f"brain.{name}")
        return _NOTHING


class Brain(Selector):
    """The object ``nrp.brain``: its attributes are selectors, or values of variables of the brain file.

    Args:
        root: holds the variables.
    """

    __slots__ = ("_root",)

    def __init__(self, root: Any) -> None:
        super().__init__(any_brain._find, repr(any_brain))
        self._root = root

    def __getattr__(self, name: str) -> Any:
        held = self._root.found(name) if isinstance(self._root, BrainRoot) else _NOTHING
        return super().__getattr__(name) if held is _NOTHING or isinstance(held, Cells) else held


__extends_dsl__ = True
"""Errors here are reported at the caller; see :mod:`nrp_core.dsl.parameters`."""

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

    If the type of its messages is unknown, a sent value is the value of their first field.
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


def _subscribed_topic(named: Any) -> Any:
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


def _calls(triggers: Any) -> Literal["once", "each"]:
    """Return how functions are called: those with triggers for each message, as callbacks of the platform."""
    return "once" if triggers in (None, dsl.TIME) else "each"


def no_retina(*_values: Any, **_options: Any) -> NoReturn:
    """Refuse a retina."""
    raise CapabilityError("nrp.MapRetina: the platform's simulator of retinas is not supported")


class CSVRecords(dsl.MapCSVRecorder):
    """A recorder whose file has a column for resets, as on the platform."""

    def __init__(self, key: str, filename: str, headers: Any, *values: Any, **more: Any) -> None:
        super().__init__(key, filename, [*headers, dsl.RESET_HEADER], *values, **more)


class Pauses(dsl.Throttle):
    """Admits a run one period of the rate after the last, in the platform's summed time."""

    def admits(self, t_ns: int, t: float | None = None) -> bool:
        t = seconds(t_ns) if t is None else t
        if self.rate_hz is not None and self._last >= 0.0 and self._last + 1.0 / self.rate_hz > t:
            return False
        self._last = t
        return True


class _Pausing:
    """Gives functions the throttling of the platform."""

    def _make(self, function: Callable[..., Any]) -> dsl.TransferFunction:
        made: dsl.TransferFunction = super()._make(function)  # type: ignore[misc]
        made.throttle = Pauses(made.throttle.rate_hz)
        return made


def framework(
    notes: Notes,
    noted_late: Notes | None = None,
    *,
    nest_units: bool = False,
    brain_root: Any = dsl.brain,
) -> ModuleType:
    """Return the module for one experiment.

    Args:
        notes: receives a note about each omitted argument of a mapping.
        noted_late: receives notes during the run, about values that no device can have; None: as ``notes``.
        nest_units: whether settings and attributes of devices are in pA, nS and pF.
        brain_root: the module of the brain file.
    """

    def settings(device_type: Any, given: Mapping[str, Any]) -> dict[str, Any]:
        taken = with_instant_recovery(_settings(device_type, given, notes))
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
            super().__init__(key, _subscribed_topic(named), initial_value=initial_value)

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

    class Robot2Neuron(_Pausing, dsl.Robot2Neuron):
        def __init__(self, triggers: Any = None, rate: Any = None, **more: Any) -> None:
            super().__init__(triggers, more.pop("throttling_rate", rate), calls=_calls(triggers), **more)

    class Neuron2Robot(_Pausing, dsl.Neuron2Robot):
        def __init__(self, to: Any = None, triggers: Any = None, rate: Any = None, **more: Any) -> None:
            to, rate = more.pop("robot_topic", to), more.pop("throttling_rate", rate)
            super().__init__(to, triggers, rate, calls=_calls(triggers), **more)

    brain = Brain(brain_root)
    own = {name: getattr(dsl, name) for name in dsl.__all__}
    own_kinds = (MapSpikeSink, MapSpikeSource, MapRobotSubscriber, MapRobotPublisher, MapVariable)
    return module(
        "hbp_nrp_cle.tf_framework",
        **{
            **own,
            **device_kinds(noted_late or notes, nest_units=nest_units),
            **{kind.__name__: kind for kind in (*own_kinds, Robot2Neuron, Neuron2Robot)},
            "MapRetina": no_retina, "MapCSVRecorder": CSVRecords,
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
            notes(Code.NRP216, f"{device_type} does not have the setting '{name}': left out", subject=name)
    return taken
