"""The kinds of devices that transfer functions name: ``nrp.poisson``, ``nrp.leaky_integrator_alpha``, ..."""

from __future__ import annotations

import dataclasses
from abc import abstractmethod
from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar, Final, Self

import numpy as np

from nrp_core._support.arrays import IntArray
from nrp_core.brain.devices import sinks, sources
from nrp_core.brain.devices.ports import SourcePort
from nrp_core.brain.devices.sinks import SinkPort, SinkSpec
from nrp_core.brain.devices.sources import SourceSpec
from nrp_core.brain.interface import Brain
from nrp_core.dsl import devices
from nrp_core.dsl.devices import Device
from nrp_core.dsl.parameters import Adapter, Binding
from nrp_core.dsl.selection import Selection
from nrp_core.registry import Registry
from nrp_core.seeds import Seeds


class CustomDevice(Adapter):
    """Base of custom devices; a mapping takes an instance, and the function gets a copy bound to neurons.

    ::

        class Envelope(nrp.CustomDevice):
            def apply(self, neurons, brain, tau=20.0):
                self._port = brain.add_sink(PopulationRate(tau_fall=tau), neurons.ids, name="envelope")

            @property
            def level(self):
                return self._port.rate / 100

        @nrp.MapSpikeSink("envelope", nrp.brain.cells, Envelope(), tau=50.0)

    A device that keeps values between steps returns them from ``save`` and takes them back in ``restore``;
    devices of the brain save theirs themselves.

    Attributes:
        default_property: the attribute that BIBI documents and the designer assign or read.
        drives: whether it drives neurons, for the designer; otherwise it reads them.
    """

    default_property: ClassVar[str] = "value"
    drives: ClassVar[bool] = False

    _brain: Brain
    _ports: list[SourcePort | SinkPort]

    @abstractmethod
    def apply(self, neurons: Selection | list[Selection], brain: Brain, **settings: Any) -> None:
        """Bind the device to neurons; devices added to the brain here are removed with this device.

        Args:
            neurons: the selected neurons; a list if the selector gives one.
            brain: its ``add_source`` and ``add_sink`` make devices for neurons, given by their ``ids``.
            settings: the other arguments of the mapping.
        """

    def __repr__(self) -> str:
        return f"{type(self).__name__}()"  # without an address: descriptions of equal functions are equal

    def bound(self, neurons: Selection | list[Selection], brain: Brain, settings: dict[str, Any]) -> Self:
        """Return a copy that is bound to neurons."""
        device = copy(self)
        known = set(map(id, brain.devices))
        device._brain = brain
        try:
            device.apply(neurons, brain, **settings)
        except BaseException:
            device._take(known)
            device.release()
            raise
        device._take(known)
        return device

    def _take(self, known: set[int]) -> None:
        """Own the ports that were added to the brain since then."""
        self._ports = [port for port in self._brain.devices if id(port) not in known]

    def set_active(self, active: bool) -> None:
        for port in self._ports:
            port.active = active

    def release(self) -> None:
        for port in self._ports:
            self._brain.remove(port)
        self._ports = []


DEVICES: Final[Registry[CustomDevice]] = Registry("nrp_core.devices", "device", bases=(CustomDevice,))
"""The devices of packages, by their names in BIBI documents and for :func:`device`."""


def device(name: str) -> CustomDevice:
    """Return a new device of an installed package, for ``MapSpikeSink`` or ``MapSpikeSource``.

    Args:
        name: its name in the entry-point group ``nrp_core.devices``.

    Raises:
        BackendError: no package registers the name, two do, or it cannot be used.
    """
    return DEVICES.load(name)


_MODES: Final = ("AllToAll", "OneToOne", "Fixed")
_CONNECTED: Final = (
    sources.PoissonSource, sources.FixedFrequencySource, sinks.LeakyIntegratorAlpha, sinks.LeakyIntegratorExp,
)  # fmt: skip
"""The devices whose synapses have weights and delays."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class DeviceKind:
    """A kind of device.

    Args:
        name: its name in transfer functions.
        spec: the device of the brain interface; its fields are the keyword arguments.
        device: the class that the function sees.
        defaults: defaults that differ from those of ``spec``.
    """

    name: str
    spec: type[SourceSpec] | type[SinkSpec]
    device: type[Device]
    defaults: Mapping[str, Any] = field(default_factory=dict)

    @property
    def drives(self) -> bool:
        """Whether it drives neurons (otherwise it reads them)."""
        return issubclass(self.spec, SourceSpec)

    @property
    def options(self) -> list[str]:
        """Names of the keyword arguments."""
        names = [item.name for item in dataclasses.fields(self.spec)]
        connected = ["connector"] if self.spec in _CONNECTED else []
        return [*names, *connected, *self.device.options]

    def open(
        self, binding: Binding, selection: Selection, options: Mapping[str, Any], *, parameter: str, name: str
    ) -> Device:
        """Create a device.

        Args:
            binding: the brain.
            selection: the neurons.
            options: keyword arguments; their names have been checked.
            parameter: for messages.
            name: names its random stream.

        Raises:
            ValueError: an option has an invalid value.
        """
        brain = binding.brain
        given, ids = self._connect({**self.defaults, **options}, selection.ids, brain.seed, name)
        of_device = {key: given.pop(key) for key in self.device.options if key in given}
        for item in dataclasses.fields(self.spec):
            if item.type in ("float", "int") and isinstance(given.get(item.name), str):
                raise ValueError(f"{item.name} must be a number, not {given[item.name]!r}")
        spec = self.spec(**given)
        port: devices.Port
        if isinstance(spec, SourceSpec):
            port = brain.add_source(spec, ids, name=name)
        else:
            port = brain.add_sink(spec, ids, name=name)
        return self.device(parameter, port, selection, partial(brain.remove, port), **of_device)

    def _connect(
        self, given: dict[str, Any], ids: IntArray, seed: int, name: str
    ) -> tuple[dict[str, Any], IntArray]:
        """Return the settings and neurons that a ``connector`` describes.

        It is ``{"mode": "AllToAll" | "OneToOne" | "Fixed", "n": ..., "weight": ..., "delay": ...}``. A
        device reaches each neuron once; with ``Fixed`` a neuron has n generators, and a sink reads n neurons
        drawn at random.
        """
        connector = given.pop("connector", None)
        if connector is None:
            return given, ids
        mode, n = connector.get("mode"), int(connector.get("n", 1))
        if mode not in _MODES:
            raise ValueError(f"the mode of a connector is {' or '.join(_MODES)}, not {mode!r}")
        if n < 1:
            raise ValueError(f"n of a connector is 1 or more, not {n}")
        given = {**{key: connector[key] for key in ("weight", "delay") if key in connector}, **given}
        if mode == "Fixed" and self.drives:
            given.setdefault("n", n)
        elif mode == "Fixed":
            drawn = Seeds(seed).child("brain").child("connector").stream(name)
            ids = np.sort(drawn.choice(ids, n, replace=n > len(ids)))
        return given, ids

    def __repr__(self) -> str:
        return self.name


poisson = DeviceKind("poisson", sources.PoissonSource, devices.SpikeGenerator)
fixed_frequency = DeviceKind("fixed_frequency", sources.FixedFrequencySource, devices.SpikeGenerator)
dc_source = DeviceKind("dc_source", sources.DCSource, devices.CurrentGenerator)
ac_source = DeviceKind("ac_source", sources.ACSource, devices.SineCurrentGenerator)
nc_source = DeviceKind("nc_source", sources.NoisyCurrentSource, devices.NoiseCurrentGenerator)
injector = DeviceKind("injector", sources.SpikeInjector, devices.SpikeInjectorDevice)
leaky_integrator_alpha = DeviceKind(
    "leaky_integrator_alpha", sinks.LeakyIntegratorAlpha, devices.LeakyIntegratorDevice
)
leaky_integrator_exp = DeviceKind(
    "leaky_integrator_exp", sinks.LeakyIntegratorExp, devices.LeakyIntegratorDevice
)
population_rate = DeviceKind("population_rate", sinks.PopulationRate, devices.PopulationRateDevice)
spike_recorder = DeviceKind(
    "spike_recorder", sinks.SpikeRecorder, devices.SpikeRecorderDevice, {"keep_ms": 10_000.0}
)
voltage_recorder = DeviceKind(
    "voltage_recorder", sinks.VoltageRecorder, devices.StateRecorderDevice, {"keep_ms": 10_000.0}
)
conductance_recorder = DeviceKind(
    "conductance_recorder", sinks.ConductanceRecorder, devices.StateRecorderDevice,
    {"keep_ms": 10_000.0},
)  # fmt: skip

KINDS = (
    poisson, fixed_frequency, dc_source, ac_source, nc_source, injector,
    leaky_integrator_alpha, leaky_integrator_exp, population_rate, spike_recorder,
    voltage_recorder, conductance_recorder,
)  # fmt: skip
"""All kinds."""
