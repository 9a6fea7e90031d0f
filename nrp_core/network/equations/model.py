"""Cells given by equations: the texts, which are data of a network, and their meaning."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import count
from typing import Any, Final

import numpy as np

from nrp_core.network.equations.expressions import RANDOM, TextOrigin, names_in
from nrp_core.units import SIEMENS, Unit

_OPERATIONS: Final[Mapping[type, Callable[..., Any]]] = {
    ast.Add: np.add, ast.Sub: np.subtract, ast.Mult: np.multiply, ast.Div: np.true_divide,
    ast.FloorDiv: np.floor_divide, ast.Mod: np.mod, ast.Pow: np.power, ast.USub: np.negative,
    ast.UAdd: np.positive, ast.Not: np.logical_not, ast.Gt: np.greater, ast.GtE: np.greater_equal,
    ast.Lt: np.less, ast.LtE: np.less_equal, ast.Eq: np.equal, ast.NotEq: np.not_equal,
}  # fmt: skip
_FUNCTIONS: Final[Mapping[str, Callable[..., Any]]] = {
    "abs": np.abs, "min": np.minimum, "max": np.maximum, "clip": np.clip, "int": np.trunc,
    "exprel": lambda x: np.where(x == 0.0, 1.0, np.expm1(x) / np.where(x == 0.0, 1.0, x)),
}  # fmt: skip


def value_of(node: ast.expr, known: Mapping[str, Any], definitions: Mapping[str, ast.expr]) -> Any:
    """Return the value of an expression, in SI units.

    Args:
        node: the expression.
        known: the values of names, numbers or arrays of one shape.
        definitions: expressions by the names that represent them.

    Raises:
        KeyError: the expression needs a name without a value.
    """

    def of(part: ast.expr) -> Any:
        return value_of(part, known, definitions)

    with np.errstate(all="ignore"):
        match node:
            case ast.Constant(value=value):
                assert isinstance(value, (int, float))
                return value if isinstance(value, bool) else float(value)
            case ast.Name(id=name):
                return _look_up(name, known, definitions)
            case ast.UnaryOp(op=op, operand=operand):
                return _OPERATIONS[type(op)](of(operand))
            case ast.BinOp(left=left, op=op, right=right):
                return _OPERATIONS[type(op)](of(left), of(right))
            case ast.BoolOp(op=op, values=values):
                combine = np.logical_and if isinstance(op, ast.And) else np.logical_or
                return combine.reduce(np.broadcast_arrays(*map(of, values)))
            case ast.Compare(left=left, ops=ops, comparators=others):
                sides = [of(part) for part in (left, *others)]
                pairs = zip(sides, ops, others and sides[1:], strict=False)
                return np.logical_and.reduce(
                    np.broadcast_arrays(*(_OPERATIONS[type(op)](a, b) for a, op, b in pairs))
                )
            case ast.Call(func=ast.Name(id=name), args=arguments):
                return _FUNCTIONS.get(name, getattr(np, name, None))(*map(of, arguments))  # type: ignore[misc]
    raise AssertionError(ast.dump(node))


def _look_up(name: str, known: Mapping[str, Any], definitions: Mapping[str, ast.expr]) -> Any:
    if name in known:
        return known[name]
    if name in definitions:
        return value_of(definitions[name], known, definitions)
    raise KeyError(name)


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
        place: its place in the source.
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
        on_step: variables and their values at each grid point, after spikes have arrived, in this order.
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
    on_step: tuple[tuple[str, ast.expr], ...] = ()

    @property
    def is_random(self) -> bool:
        """Whether the threshold has a random number."""
        return RANDOM in names_in(self.threshold)

    def unit_of(self, name: str) -> Unit | None:
        """Return the unit of a variable or definition that can be recorded, else None."""
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
        on_step: assignments at each grid point, after the spikes that arrive there.
    """

    equations: str
    threshold: str
    reset: str = ""
    refractory: str = "0 ms"
    receptors: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    method: str = ""
    on_step: str = ""


def known_value(node: ast.expr, known: Mapping[str, Any], definitions: Mapping[str, ast.expr]) -> Any:
    """Return the value of an expression, an array; None if it depends on names without one."""
    try:
        return np.atleast_1d(value_of(node, known, definitions))
    except KeyError:
        return None
