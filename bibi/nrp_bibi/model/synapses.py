"""How devices connect to their neurons."""

from __future__ import annotations

from dataclasses import dataclass

from nrp_bibi.model.metamodel import Node, attribute
from nrp_bibi.model.values import NUMBER, POSITIVE, WORD


@dataclass(frozen=True, slots=True, kw_only=True)
class NeuronConnector(Node, abstract=True):
    """Weights (uS or nA, as the target's) and delays (ms); by its name it can be referred to."""

    name: str = attribute(WORD, "default")
    weights: float | None = attribute(NUMBER, None)
    delays: float | None = attribute(NUMBER, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class OneToOneConnector(NeuronConnector):
    """Each device to its neuron."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AllToAllConnector(NeuronConnector):
    """The device to all neurons."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedNumberPreConnector(NeuronConnector):
    """Each neuron on the receiving side from ``count`` others."""

    count: int = attribute(POSITIVE)


@dataclass(frozen=True, slots=True, kw_only=True)
class SynapseDynamics(Node, abstract=True):
    """How a synapse changes; by its name it can be referred to."""

    name: str = attribute(WORD, "default")


@dataclass(frozen=True, slots=True, kw_only=True)
class TsodyksMarkramMechanism(SynapseDynamics):
    """Short-term plasticity: utilisation and two time constants in ms."""

    u: float = attribute(NUMBER)
    tau_rec: float = attribute(NUMBER, name="tau_rec")
    tau_facil: float = attribute(NUMBER, name="tau_facil")


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference(Node):
    """The name of a connector or of synapse dynamics that the whole model shares."""

    ref: str = attribute(WORD)
