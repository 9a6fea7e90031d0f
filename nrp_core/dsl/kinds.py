"""The kinds of devices that transfer functions name: ``nrp.poisson``, ``nrp.leaky_integrator_alpha``, ..."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from nrp_core.brain import sinks, sources
from nrp_core.brain.sinks import SinkSpec
from nrp_core.brain.sources import SourceSpec
from nrp_core.dsl import devices
from nrp_core.dsl.binding import Binding
from nrp_core.dsl.devices import Device
from nrp_core.dsl.selection import Selection


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class DeviceKind:
    """A kind of device.

    Args:
        name: what users write.
        spec: the device of the brain interface; its fields are the keyword arguments.
        device: what the function sees.
        defaults: where they differ from those of ``spec``.
    """

    name: str
    spec: type[SourceSpec] | type[SinkSpec]
    device: type[Device]
    defaults: Mapping[str, Any] = field(default_factory=dict)

    @property
    def drives(self) -> bool:
        """Whether it acts on neurons (else it listens to them)."""
        return issubclass(self.spec, SourceSpec)

    @property
    def options(self) -> list[str]:
        """Names of the keyword arguments."""
        return [*(item.name for item in dataclasses.fields(self.spec)), *self.device.options]

    def open(
        self, binding: Binding, selection: Selection, options: Mapping[str, Any], *, parameter: str, name: str
    ) -> Device:
        """Put a device to work.

        Args:
            binding: the brain.
            selection: the neurons.
            options: keyword arguments, their names checked.
            parameter: for messages.
            name: names its random stream.

        Raises:
            ValueError: an option has a value that cannot be.
        """
        brain = binding.brain
        given = {**self.defaults, **options}
        of_device = {key: given.pop(key) for key in self.device.options if key in given}
        spec = self.spec(**given)
        port: devices.Port
        if isinstance(spec, SourceSpec):
            port = brain.add_source(spec, selection.ids, name=name)
        else:
            port = brain.add_sink(spec, selection.ids, name=name)
        return self.device(parameter, port, selection, partial(brain.remove, port), **of_device)

    def __repr__(self) -> str:
        return self.name


poisson = DeviceKind("poisson", sources.PoissonSource, devices.SpikeGenerator)
fixed_frequency = DeviceKind("fixed_frequency", sources.FixedFrequencySource, devices.SpikeGenerator)
dc_source = DeviceKind("dc_source", sources.DCSource, devices.CurrentGenerator)
ac_source = DeviceKind("ac_source", sources.ACSource, devices.SineCurrentGenerator)
nc_source = DeviceKind("nc_source", sources.NoisyCurrentSource, devices.NoiseCurrentGenerator)
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

KINDS = (
    poisson, fixed_frequency, dc_source, ac_source, nc_source,
    leaky_integrator_alpha, leaky_integrator_exp, population_rate, spike_recorder,
)  # fmt: skip
"""All kinds."""
