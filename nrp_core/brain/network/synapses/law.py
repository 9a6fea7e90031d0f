"""The properties of a synapse law, independent of the simulator."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.parameters import DELAY, Parameter
from nrp_core.errors import NetworkError

_ROUNDING: Final = 1e-9

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
        shares: the state variables that are shares of one whole, so that their sum is at most 1.
        complements: further names of initial values: a state variable, and the parameter less which it is.
        parts: the parts that PyNN composes the law from: PyNN's argument, its classes and their parameters.
        plastic: whether spikes change the weight itself, not only the share of it that one spike transmits.
        stands_for: unsupported PyNN classes whose nearest equivalent this is.
    """

    name: str
    pynn: str
    summary: str
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    state: Mapping[str, Parameter] = field(default_factory=dict)
    shares: tuple[str, ...] = ()
    complements: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    parts: Mapping[str, Mapping[str, RulePart]] = field(default_factory=dict)
    plastic: bool = False
    stands_for: tuple[str, ...] = ()

    @property
    def defaults(self) -> dict[str, float]:
        """Default of every parameter by name."""
        return {name: parameter.default for name, parameter in self.parameters.items()}

    def require_shares(self, where: str, initial_values: Mapping[str, FloatArray]) -> None:
        """Refuse states at time 0 in which shares of one whole are more than it.

        Raises:
            NetworkError: there is such a synapse.
        """
        given = [initial_values[name] for name in self.shares if name in initial_values]
        most = float(np.max(sum(given), initial=0.0)) if given else 0.0
        if most > 1.0 + _ROUNDING:
            names = " and ".join(self.shares)
            raise NetworkError(
                f"{where}: the initial {names} are shares of one whole, and their sum is {most:g}"
            )

    @property
    def in_units_of_weight(self) -> frozenset[str]:
        """The parameters that scale with the weights."""
        unit = EVERY_SYNAPSE["weight"].unit
        return frozenset(name for name, parameter in self.parameters.items() if parameter.unit == unit)

    @property
    def first_parts(self) -> dict[str, str]:
        """The first class of each part, in the form of :attr:`Projection.plasticity`."""
        return {part: next(iter(classes)) for part, classes in self.parts.items()}

    def chosen_parts(self, names: Collection[str]) -> list[tuple[str, RulePart]] | None:
        """Return the named class of each part, in the order of the parts; None unless each has just one."""
        chosen = [[(name, part) for name, part in of.items() if name in names] for of in self.parts.values()]
        complete = all(len(classes) == 1 for classes in chosen) and len(set(names)) == len(chosen)
        return [classes[0] for classes in chosen] if complete else None


@dataclass(frozen=True, slots=True)
class RulePart:
    """A part of a law that PyNN composes from parts.

    Args:
        summary: one sentence, for scripts and documentation.
        parameters: parameters by PyNN name.
        implied: values of other parameters of the law that this part fixes.
        requires: the only class of each other part with which this one is composed, if there is just one.
        stands_for: as in :class:`SynapseLaw`.
    """

    summary: str
    parameters: tuple[str, ...]
    implied: Mapping[str, float] = field(default_factory=dict)
    requires: Mapping[str, str] = field(default_factory=dict)
    stands_for: tuple[str, ...] = ()
