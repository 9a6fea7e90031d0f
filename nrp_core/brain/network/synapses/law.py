"""What there is to know of a synapse law, whichever simulator runs it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from nrp_core.brain.network.parameters import DELAY, Parameter

EVERY_SYNAPSE: Final = {"weight": Parameter(0.0, "uS, nA or mV"), "delay": Parameter(0.0, "ms", DELAY)}
"""Parameters of the synapses of every law."""


@dataclass(frozen=True, slots=True)
class SynapseLaw:
    """How synapses pass spikes on.

    Args:
        name: in a network and in its file.
        pynn: the class of PyNN scripts and of SONATA's ``pynn:`` models.
        summary: one sentence, for scripts and documentation.
        parameters: beyond :data:`EVERY_SYNAPSE`, of all parts together.
        state: variables of each synapse, with their values at rest.
        parts: of a law that PyNN composes: PyNN's argument, and the classes it takes with their parameters.
        stands_for: PyNN's classes that networks cannot hold and to which this is the nearest.
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
        """The first class of each part, as :attr:`Projection.plasticity` names them."""
        return {part: next(iter(classes)) for part, classes in self.parts.items()}


@dataclass(frozen=True, slots=True)
class RulePart:
    """A part of a law that PyNN composes.

    Args:
        summary: one sentence, for scripts and documentation.
        parameters: PyNN's names.
        stands_for: as in :class:`SynapseLaw`.
    """

    summary: str
    parameters: tuple[str, ...]
    stands_for: tuple[str, ...] = ()
