"""A synapse law given as equations, as data of a network."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.equations.expressions import names_in
from nrp_core.brain.network.equations.synapse_model import SYNAPSE_TYPE, SynapseModel, SynapseTexts
from nrp_core.brain.network.equations.synapse_reading import read_synapse
from nrp_core.brain.network.equations.units import NONE, Unit, described
from nrp_core.brain.network.equations.values import value_of
from nrp_core.brain.network.plain import Plain
from nrp_core.errors import NetworkError, did_you_mean


@dataclass(frozen=True)
class SynapseEquations(Plain, SynapseTexts):
    """The texts of a synapse law, which fit together.

    Raises:
        NetworkError: a text contradicts itself or another; the message names its line.
    """

    KIND: ClassVar[str] = SYNAPSE_TYPE

    def __post_init__(self) -> None:
        _ = self.model

    @cached_property
    def model(self) -> SynapseModel:
        """What the texts mean."""
        return read_synapse(self)

    def require_values(
        self, owner: str, item: Callable[[int], str], parameters: Mapping[str, FloatArray]
    ) -> None:
        """Check the parameters of synapses.

        Args:
            owner: the projection, for the message.
            item: returns the description of the synapse at an index.
            parameters: every parameter in its unit, shape ``(n,)``.

        Raises:
            NetworkError: a name is missing or unknown, or an equation has no finite solution.
        """
        known = self.model.parameters
        for name in known.keys() - parameters.keys():
            raise NetworkError(f"{owner} needs the parameter '{name}' of its equations")
        for name in parameters.keys() - known.keys():
            raise NetworkError(
                f"{owner}: its equations have no parameter '{name}'{did_you_mean(name, known)}"
            )
        values = self.in_si(parameters)
        for name, course in self.model.courses.items():
            for coefficient in course.coefficients:
                found = np.atleast_1d(value_of(coefficient, values, self.model.definitions))
                for wrong in np.flatnonzero(~np.isfinite(found))[:1]:
                    used = ", ".join(
                        f"{one} = {parameters[one][wrong]:g} {known[one].text}".removesuffix(" 1")
                        for one in dict.fromkeys(names_in(coefficient))
                        if one in known
                    )
                    raise NetworkError(f"{owner}: d{name}/dt of {item(int(wrong))} is not finite ({used})")

    def require_weight_unit(self, owner: str, unit: Unit) -> None:
        """Check that the weights of a projection have the unit that the equations say.

        Raises:
            NetworkError: they are of another kind.
        """
        own = self.model.weight_unit.dimension
        if own not in (NONE, unit.dimension):
            raise NetworkError(
                f"{owner}: 'weight' is in {described(own)} in the equations of its synapses (weight_unit), "
                f"and weights onto its target are in {unit.text}"
            )

    def weight_scale(self, unit: Unit) -> float:
        """Return what weights are multiplied by in the equations: 1, or the size of their unit."""
        return 1.0 if self.model.weight_unit.dimension == NONE else unit.scale

    def in_si(self, values: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """Return parameters in SI units, by name."""
        return {name: array * self.model.parameters[name].scale for name, array in values.items()}
