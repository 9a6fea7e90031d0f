"""Cells given as equations: the texts, which are data of a network, and what they mean."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import count
from typing import Final

from nrp_core.brain.network.equations.expressions import RANDOM, TextOrigin, names_in
from nrp_core.brain.network.equations.units import SIEMENS, Unit

CELL_TYPE: Final = "EquationCell"
"""The cell type of all populations whose cells are given as equations."""
INPUT: Final = "i_offset"
"""The parameter to which injected currents are added."""
EXACT: Final = "exact"
RUNGE_KUTTA: Final = "runge_kutta"
METHODS: Final = (EXACT, RUNGE_KUTTA)
RECEPTORS: Final = ("excitatory", "inhibitory")
"""The receptors of all cells but those whose equations name others."""
INHIBITORY: Final = frozenset({"inhibitory", "GABA", "GABAA", "GABAB"})
"""The receptors that inhibit, as PyNN lists them."""


@dataclass(frozen=True, slots=True)
class Variable:
    """A state variable.

    Args:
        name: its name.
        unit: its unit in scripts and recordings.
        rate: its derivative.
        held: whether it stays while the cell is refractory.
        place: where it was written.
    """

    name: str
    unit: Unit
    rate: ast.expr
    held: bool
    place: TextOrigin


@dataclass(frozen=True, slots=True)
class Effect:
    """What a spike at a receptor does: ``variable += factor * weight``.

    Args:
        variable: the state variable.
        factor: an expression of parameters.
        unit: the unit of weights.
        always: whether it is not lost while the cell is refractory and holds the variable.
    """

    variable: str
    factor: ast.expr
    unit: Unit
    always: bool = False


@dataclass(frozen=True, slots=True)
class Model:
    """The meaning of a cell's equations.

    Args:
        variables: the state variables by name.
        definitions: expressions with a name, each after those that it needs.
        parameters: units of parameters by name.
        threshold: the condition for a spike.
        reset: variables and their values after a spike, in this order.
        refractory: a time, or a condition in which the cell does not spike.
        lasts: whether ``refractory`` is a time.
        receptors: effects of spikes by receptor.
        method: ``exact`` or ``runge_kutta``.
        recorded: units of the definitions that can be recorded.
    """

    variables: Mapping[str, Variable]
    definitions: Mapping[str, ast.expr]
    parameters: Mapping[str, Unit]
    threshold: ast.expr
    reset: tuple[tuple[str, ast.expr], ...]
    refractory: ast.expr
    lasts: bool
    receptors: Mapping[str, Effect]
    method: str
    recorded: Mapping[str, Unit]

    @property
    def is_random(self) -> bool:
        """Whether the threshold has a random number."""
        return RANDOM in names_in(self.threshold)

    def unit_of(self, name: str) -> Unit | None:
        """Return the unit of what can be recorded, a variable or a definition; None if it cannot."""
        found = self.variables.get(name)
        return found.unit if found else self.recorded.get(name)

    def receptor_number(self, receptor: str) -> int:
        """Return the number of a receptor: 0 for ``excitatory``, 1 for ``inhibitory``, others are between."""
        usual = {name: number for number, name in enumerate(RECEPTORS) if name in self.receptors}
        free = (number for number in count() if number not in usual.values())
        return ({name: next(free) for name in self.receptors if name not in usual} | usual)[receptor]

    @property
    def is_conductance_based(self) -> bool:
        """Whether all weights are conductances."""
        effects = self.receptors.values()
        return bool(effects) and all(effect.unit.dimension == SIEMENS for effect in effects)


@dataclass(frozen=True)
class Texts:
    """What a user wrote.

    Args:
        equations: one equation a line.
        threshold: the condition for a spike.
        reset: assignments.
        refractory: a time or a condition.
        receptors: effect of a spike by receptor, e.g. ``ge += weight``.
        units: unit of each parameter.
        method: ``exact``, ``runge_kutta``, or empty for the first where it is possible.
    """

    equations: str
    threshold: str
    reset: str = ""
    refractory: str = "0 ms"
    receptors: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    method: str = ""
