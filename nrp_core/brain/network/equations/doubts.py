"""Equations that are valid, and probably not meant: names without effect, values without sense, growth."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain
from typing import Any, Final, NamedTuple

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.brain.network.equations.expressions import names_in
from nrp_core.brain.network.equations.units import (
    AMPERE,
    FARAD,
    NONE,
    SECOND,
    SIEMENS,
    VOLT,
    Dimension,
    Unit,
    times,
)
from nrp_core.brain.network.equations.values import value_of

Values = Mapping[str, FloatArray]


class _Sense(NamedTuple):
    """The positive values of a quantity that make sense, in its SI unit times ``scale``."""

    kind: str
    low: float
    high: float
    unit: str
    scale: float


_SENSE: Final[Mapping[Dimension, _Sense]] = {
    SECOND: _Sense("a time", 0.01, 100_000.0, "ms", 1e-3),
    FARAD: _Sense("a capacitance", 1e-4, 50.0, "nF", 1e-9),
    SIEMENS: _Sense("a conductance", 1e-7, 5_000.0, "uS", 1e-6),
    times(NONE, SIEMENS, -1): _Sense("a resistance", 0.05, 1e6, "Mohm", 1e6),
}
"""As wide as those of our own cells; reversal potentials and currents may have either sign."""
_HIGHEST: Final[Mapping[Dimension, _Sense]] = {
    VOLT: _Sense("a voltage", 0.0, 1_000.0, "mV", 1e-3),
    AMPERE: _Sense("a current", 0.0, 50.0, "nA", 1e-9),
}
_INITIAL: Final = "_init"
"""The end of names of NESTML's parameters that only initial values use."""
_TINY_REST_V: Final = (-1e-4, -2e-5)
"""Resting potentials of neurons, divided by a thousand."""
_SIGNED: Final = frozenset({SIEMENS})
"""Quantities of which a negative value has a meaning."""


def doubts_about_values(units: Mapping[str, Unit], values: Values) -> Iterator[str]:
    """Yield a sentence for each parameter whose value makes no sense for its kind of quantity.

    Args:
        units: the unit of each parameter.
        values: their values in these units.
    """
    for name, unit in units.items():
        if name not in values or not values[name].size:
            continue
        given = values[name]
        positive = _SENSE.get(unit.dimension)
        sense = positive or _HIGHEST.get(unit.dimension)
        if sense is None:
            continue
        sizes = np.abs(given[given != 0]) * (unit.scale / sense.scale)
        lowest = given[np.argmin(given)]
        if positive is not None and lowest < 0 and unit.dimension not in _SIGNED:
            yield f"{name} is {lowest:g} {unit.text}: {sense.kind} is more than 0"
        elif sizes.size and not sense.low <= sizes.min():
            yield f"{name} is {sizes.min():g} {sense.unit}; is it in another unit?"
        elif sizes.size and sizes.max() > sense.high:
            yield f"{name} is {sizes.max():g} {sense.unit}; is it in another unit?"


def tiny_voltages(units: Mapping[str, Unit], values: Values) -> Iterator[str]:
    """Yield a sentence for each voltage that is a resting potential in the wrong unit, e.g. -65 uV.

    Args:
        units: the unit of each parameter and state variable.
        values: their values in these units.
    """
    low, high = _TINY_REST_V
    for name, array in values.items():
        if name in units and units[name].dimension == VOLT and array.size:
            volts = array * units[name].scale
            if low <= volts.min() and volts.max() <= high:
                yield f"{name} is {volts.flat[0] * 1e3:g} mV; is it in another unit?"


def unused(
    parameters: Iterable[str], definitions: Mapping[str, ast.expr], nodes: Iterable[ast.expr]
) -> Iterator[str]:
    """Yield a sentence for each parameter and each expression with a name that nothing uses.

    Args:
        parameters: the names of parameters.
        definitions: expressions with a name.
        nodes: all other expressions.
    """
    used = set(chain.from_iterable(map(names_in, nodes)))
    for name in reversed(list(definitions)):  # each stands after those that it needs
        if name in used:
            used.update(names_in(definitions[name]))
    for name in parameters:
        if name not in used and not name.endswith(_INITIAL):
            yield f"the parameter '{name}' is not used"
    for name in definitions:
        if name not in used:
            yield f"'{name}' is not used"


def reached(
    start: Iterable[ast.expr], needs: Mapping[str, Iterable[ast.expr]], definitions: Mapping[str, ast.expr]
) -> set[str]:
    """Return all names on which expressions depend, through the equations and statements of variables.

    Args:
        start: the expressions.
        needs: for each variable, the expressions that change it.
        definitions: expressions with a name.
    """
    found, pending = set[str](), list(start)
    while pending:
        for name in set(names_in(pending.pop())) - found:
            found.add(name)
            pending += needs.get(name, ())
            if name in definitions:
                pending.append(definitions[name])
    return found


def reversed_limits(
    nodes: Iterable[ast.expr], known: Mapping[str, Any], definitions: Mapping[str, ast.expr]
) -> Iterator[str]:
    """Yield a sentence for each ``clip`` whose lower limit is above its upper one."""
    for call in chain.from_iterable(map(ast.walk, nodes)):
        match call:
            case ast.Call(func=ast.Name(id="clip"), args=[_, low, high]):
                pair = [known_value(node, known, definitions) for node in (low, high)]
                if None not in pair and (pair[0] > pair[1]).any():
                    yield f"the limits of clip are reversed: {pair[0].flat[0]:g} and {pair[1].flat[0]:g}"


def known_value(node: ast.expr, known: Mapping[str, Any], definitions: Mapping[str, ast.expr]) -> Any:
    """Return the value of an expression, an array; None if it depends on names without one."""
    try:
        return np.atleast_1d(value_of(node, known, definitions))
    except KeyError:
        return None
