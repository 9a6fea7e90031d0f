"""How devices connect to their neurons."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_bibi.model.metamodel import Node, attribute
from nrp_bibi.model.values import NUMBER, POSITIVE, WORD


@dataclass(frozen=True, slots=True, kw_only=True)
class NeuronConnector(Node, abstract=True):
    """Weights (uS or nA, depending on the target) and delays (ms); its name is for references."""

    name: str = attribute(WORD, "default")
    weights: float | None = attribute(NUMBER, None, unit="uS or nA")
    delays: float | None = attribute(NUMBER, None, unit="ms")


@dataclass(frozen=True, slots=True, kw_only=True)
class OneToOneConnector(NeuronConnector):
    """Connects each device to its neuron."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AllToAllConnector(NeuronConnector):
    """Connects the device to all neurons."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedNumberPreConnector(NeuronConnector):
    """Connects ``count`` sources to each target neuron."""

    count: int = attribute(POSITIVE)


@dataclass(frozen=True, slots=True, kw_only=True)
class SynapseDynamics(Node, abstract=True):
    """The plasticity of a synapse; its name is for references."""

    name: str = attribute(WORD, "default")


@dataclass(frozen=True, slots=True, kw_only=True)
class TsodyksMarkramMechanism(SynapseDynamics):
    """Short-term plasticity: utilisation and two time constants in ms."""

    u: float = attribute(NUMBER)
    tau_rec: float = attribute(NUMBER, name="tau_rec", unit="ms")
    tau_facil: float = attribute(NUMBER, name="tau_facil", unit="ms")


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference(Node):
    """The name of a connector or of synapse dynamics that the whole model shares."""

    ref: str = attribute(WORD)
