"""A cell given as equations, as data of a network."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.equations.expressions import TIME, names_in
from nrp_core.brain.network.equations.model import CELL_TYPE, INPUT, Model, Texts
from nrp_core.brain.network.equations.reading import read
from nrp_core.brain.network.equations.values import value_of
from nrp_core.brain.network.plain import Plain
from nrp_core.errors import NetworkError, did_you_mean


@dataclass(frozen=True)
class CellEquations(Plain, Texts):
    """The texts of a cell, which fit together.

    Raises:
        NetworkError: a text contradicts itself or another; the message names its line.
    """

    KIND: ClassVar[str] = CELL_TYPE

    def __post_init__(self) -> None:
        _ = self.model

    @cached_property
    def model(self) -> Model:
        """What the texts mean."""
        return read(self)

    def require_values(
        self, owner: str, parameters: Mapping[str, FloatArray], states: Mapping[str, FloatArray]
    ) -> None:
        """Check the parameters and initial values of cells.

        Args:
            owner: the population, for the message.
            parameters: every parameter in its unit, shape ``(n,)``.
            states: initial values of state variables.

        Raises:
            NetworkError: a name is missing or unknown, a refractory period is negative, or a cell would fire
                in every step.
        """
        for name in self.model.parameters.keys() - parameters.keys():
            raise NetworkError(f"{owner} needs the parameter '{name}' of its equations")
        kinds: tuple[tuple[str, Mapping[str, FloatArray], Mapping[str, object]], ...] = (
            ("parameter", parameters, self.model.parameters),
            ("state variable", states, self.model.variables),
        )
        for what, given, valid in kinds:
            for name in given.keys() - valid.keys():
                raise NetworkError(
                    f"{owner}: its equations have no {what} '{name}'{did_you_mean(name, valid)}"
                )
        self.require_periods(owner, self.in_si(parameters))
        self._require_finite(owner, parameters, states)

    def require_periods(self, owner: str, known: Mapping[str, FloatArray]) -> None:
        """Check that refractory periods are not negative, and that the reset ends a spike.

        Args:
            owner: the population, for the message.
            known: every parameter in SI units.

        Raises:
            NetworkError: a cell could not go on after a spike.
        """
        self._require_refractory(owner, known)
        self._require_end_of_spike(owner, known)

    def _require_finite(
        self, owner: str, parameters: Mapping[str, FloatArray], states: Mapping[str, FloatArray]
    ) -> None:
        model = self.model
        known = self.state_at_start(parameters, states)
        for name, variable in model.variables.items():
            try:
                rate = np.atleast_1d(value_of(variable.rate, known, model.definitions))
            except KeyError:  # a state variable has no initial value here
                continue
            for wrong in np.flatnonzero(~np.isfinite(rate))[:1]:
                zeros = [
                    one for one in names_in(variable.rate) if one in parameters and 0.0 in parameters[one]
                ]
                hint = f" ({', '.join(dict.fromkeys(zeros))} = 0)" if zeros else ""
                raise NetworkError(f"{owner}: d{name}/dt of cell {wrong} is not finite at time 0{hint}")

    def in_si(self, values: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        """Return parameters in SI units, by name."""
        return {name: array * self.model.parameters[name].scale for name, array in values.items()}

    def state_at_start(
        self, parameters: Mapping[str, FloatArray], states: Mapping[str, FloatArray]
    ) -> dict[str, Any]:
        """Return the parameters and state of cells at time 0, in SI units.

        Args:
            parameters: every parameter in its unit, shape ``(n,)``.
            states: initial values of state variables, in their units.
        """
        variables = self.model.variables
        values = {name: array * variables[name].unit.scale for name, array in states.items()}
        return {TIME: 0.0, INPUT: 0.0, **self.in_si(parameters), **values}

    def _require_refractory(self, owner: str, known: Mapping[str, FloatArray]) -> None:
        try:
            lasts = value_of(self.model.refractory, known, self.model.definitions)
        except KeyError:  # it depends on the state
            return
        if not self.model.lasts:
            return
        cells = np.flatnonzero(~(np.atleast_1d(lasts) >= 0.0))
        if len(cells):
            raise NetworkError(
                f"{owner}: the refractory period of cell {cells[0]}, '{self.refractory}', is "
                f"{np.atleast_1d(lasts)[cells[0]] * 1e3:g} ms; it must be 0 or more"
            )

    def _require_end_of_spike(self, owner: str, known: Mapping[str, FloatArray]) -> None:
        after: dict[str, Any] = dict(known)
        for name, value in self.model.reset:
            try:
                after[name] = value_of(value, after, self.model.definitions)
            except KeyError:  # it depends on the state before the spike
                after.pop(name, None)
        try:
            again = np.atleast_1d(value_of(self.model.threshold, after, self.model.definitions))
        except KeyError:  # it depends on the state before the spike
            return
        if again.any() and any(name in after for name in names_in(self.model.threshold)):
            raise NetworkError(
                f"{owner}: after the reset, '{self.reset.strip()}', cell {int(np.argmax(again))} still meets "
                f"the threshold, '{self.threshold.strip()}', so it would fire without end"
            )
