"""Connections of a transfer function: to neurons through devices, to the robot through topics."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

from nrp_bibi.model.expressions import FlowExpression
from nrp_bibi.model.metamodel import Node, attribute, child, choice
from nrp_bibi.model.selectors import NeuronGroupSelector, NeuronSelector
from nrp_bibi.model.synapses import NeuronConnector, Reference, SynapseDynamics
from nrp_bibi.model.values import DOTTED, NAME, TOPIC
from nrp_core.dsl import DEVICES, device


class DeviceType(Enum):
    """The kinds of devices."""

    AC_SOURCE = "ACSource"
    DC_SOURCE = "DCSource"
    FIXED_FREQUENCY = "FixedFrequency"
    LEAKY_INTEGRATOR_ALPHA = "LeakyIntegratorAlpha"
    LEAKY_INTEGRATOR_EXP = "LeakyIntegratorExp"
    NC_SOURCE = "NCSource"
    POISSON = "Poisson"
    SPIKE_RECORDER = "SpikeRecorder"
    POPULATION_RATE = "PopulationRate"

    @property
    def dsl_name(self) -> str:
        """The name in transfer functions: ``nrp.<name>``."""
        return self.name.lower()

    @property
    def default_property(self) -> str:
        """The property that the body of a channel is assigned to."""
        return _DEFAULT_PROPERTIES[self]


_DEFAULT_PROPERTIES = {
    DeviceType.AC_SOURCE: "amplitude",
    DeviceType.DC_SOURCE: "amplitude",
    DeviceType.FIXED_FREQUENCY: "rate",
    DeviceType.LEAKY_INTEGRATOR_ALPHA: "voltage",
    DeviceType.LEAKY_INTEGRATOR_EXP: "voltage",
    DeviceType.NC_SOURCE: "mean",
    DeviceType.POISSON: "rate",
    DeviceType.SPIKE_RECORDER: "times",
    DeviceType.POPULATION_RATE: "rate",
}


@dataclass(frozen=True, slots=True)
class PackagedDevice:
    """A device of a package.

    Args:
        value: its name in the entry-point group ``nrp_core.devices``.
    """

    value: str

    @property
    def dsl_name(self) -> str:
        """The expression in transfer functions: ``nrp.<expression>``."""
        return f'device("{self.value}")'

    @property
    def default_property(self) -> str:
        """The property that the body of a channel is assigned to."""
        return device(self.value).default_property


class Target(Enum):
    """The receptors that a device's synapses act on."""

    EXCITATORY = "Excitatory"
    INHIBITORY = "Inhibitory"


_OURS = choice("DeviceType", DeviceType)


def _device_type(text: str) -> DeviceType | PackagedDevice:
    name = text.strip()
    return PackagedDevice(name) if name in DEVICES.names() else _OURS.parse(text)


DEVICE_TYPE = replace(
    _OURS, parse=_device_type, expects=f"{_OURS.expects}, or a device that an installed package registers"
)
"""The schema lists our own kinds."""
TARGET = choice("SynapseTarget", Target)


@dataclass(frozen=True, slots=True, kw_only=True)
class AnyDevice(Node, abstract=True):
    """A device or group of devices; the function writes one with a body, and reads one without."""

    name: str = attribute(NAME)
    type: DeviceType | PackagedDevice = attribute(DEVICE_TYPE)
    neurons: NeuronSelector | NeuronGroupSelector
    connector: NeuronConnector | None = child(NeuronConnector, None)
    connector_ref: Reference | None = child(Reference, None)
    synapse_dynamics: SynapseDynamics | None = child(SynapseDynamics, None)
    synapse_dynamics_ref: Reference | None = child(Reference, None)
    target: Target | None = child(TARGET, None)
    body: FlowExpression | None = child(FlowExpression, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceChannel(AnyDevice):
    """One device on some neurons."""

    neurons: NeuronSelector = child(NeuronSelector)


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceGroupChannel(AnyDevice):
    """A device for each of many selections."""

    neurons: NeuronGroupSelector = child(NeuronGroupSelector)


@dataclass(frozen=True, slots=True, kw_only=True)
class TopicChannel(Node):
    """A topic of the robot; the function publishes on one with a body, and subscribes to one without."""

    name: str | None = attribute(NAME, None)
    topic: str = attribute(TOPIC)
    type: str = attribute(DOTTED)
    body: FlowExpression | None = child(FlowExpression, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Local(Node):
    """A local variable of one run of the transfer function."""

    name: str = attribute(NAME)
    body: FlowExpression = child(FlowExpression)
