"""The properties of a synapse law, independent of the simulator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from nrp_core.brain.network.parameters import DELAY, Parameter

EVERY_SYNAPSE: Final = {"weight": Parameter(0.0, "uS, nA or mV"), "delay": Parameter(0.0, "ms", DELAY)}
"""Parameters of the synapses of every law."""


@dataclass(frozen=True, slots=True)
class SynapseLaw:
    """How synapses transmit spikes.

    Args:
        name: its name in a network and in network files.
        pynn: PyNN's class, also in SONATA's ``pynn:`` models.
        summary: one sentence, for scripts and documentation.
        parameters: the parameters of all parts, besides those of :data:`EVERY_SYNAPSE`.
        state: state variables of each synapse, with their values at rest.
        parts: the parts that PyNN composes the law from: PyNN's argument, its classes and their parameters.
        stands_for: unsupported PyNN classes whose nearest equivalent this is.
    """

    name: str
    pynn: str
    summary: str
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    state: Mapping[str, Parameter] = field(default_factory=dict)
    parts: Mapping[str, Mapping[str, RulePart]] = field(default_factory=dict)
    stands_for: tuple[str, ...] = ()

    @property
    def defaults(self) -> dict[str, float]:
        """Default of every parameter by name."""
        return {name: parameter.default for name, parameter in self.parameters.items()}

    @property
    def first_parts(self) -> dict[str, str]:
        """The first class of each part, in the form of :attr:`Projection.plasticity`."""
        return {part: next(iter(classes)) for part, classes in self.parts.items()}


@dataclass(frozen=True, slots=True)
class RulePart:
    """A part of a law that PyNN composes from parts.

    Args:
        summary: one sentence, for scripts and documentation.
        parameters: parameters by PyNN name.
        stands_for: as in :class:`SynapseLaw`.
    """

    summary: str
    parameters: tuple[str, ...]
    stands_for: tuple[str, ...] = ()
