"""What a kernel has for each cell: the names of the rows of values and of constants.

In a kernel a name stands for the value of cell i, and ``all_`` before it for the array of a block of cells.

The largest local error of the integrated variables.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_brain_event.equation_source import DEFINITION, PARAMETER, STATE
from nrp_brain_event.runge_kutta import NODES
from nrp_core._support.arrays import CACHE_LINE
from nrp_core.network.equations.linear import ONE, columns, columns_of, driven, linear_part, pattern
from nrp_core.network.equations.model import EXACT, INPUT, Model, Variable
from nrp_core.units import AMPERE, NONE, SECOND, SIEMENS, VOLT

TOLERANCE: Final = 1e-7
"""The largest local error of a sub-step, in units of a variable's scale and value together."""
_SCALES: Final = {VOLT: 1e-3, AMPERE: 1e-9, SIEMENS: 1e-9, SECOND: 1e-3, NONE: 1e-2}
"""Sizes of variables by dimension, in SI units: mV, nA, nS, ms and percent."""


def scale_of(variable: Variable) -> float:
    """Return the size of a variable at which its error counts like that of larger values, in SI units."""
    return min(variable.unit.scale, _SCALES.get(variable.unit.dimension, variable.unit.scale))


STREAM: Final = "stream"
"""The stream of random numbers of a cell, see :func:`nrp_brain_event.random_numbers.uniform_at`."""
_OF_EXACT: Final = ("until",)
"""The last step in which the cell is refractory."""
_OF_RUNGE_KUTTA: Final = ("rest", "wanted", "mark")
"""The remaining refractory period and the length of the next sub-step, s, 0 for the first; how the step
went, see :mod:`nrp_brain_event.grid.equations.runge_kutta_source`."""
DRIVE: Final = "drive"
INPUTS: Final = "in_"
GAIN: Final = "gain_"
_ELEMENT: Final = "element_"
_IN_LINE: Final = CACHE_LINE // np.dtype(np.float64).itemsize
_FEW: Final = 32
"""Cells that are searched at once for one that needs more than the others."""
CHANGE: Final = "change"
"""The share by which coefficients of variables change in a step."""
LIMITS: Final = ("(least)", "(slope)", "(reach)")
"""What limits the sizes of coefficients, which are beside it; not the names of variables."""


def hidden(model: Model) -> tuple[str, ...]:
    """Return the names of the values that a cell stores in addition to its state variables."""
    of_method = _OF_EXACT if model.method == EXACT else _OF_RUNGE_KUTTA
    return (*of_method, STREAM) if model.is_random else of_method


def kept(model: Model) -> list[str]:
    """Return the names of the values that a cell stores, without recorded definitions."""
    return [*(STATE + name for name in model.variables), *hidden(model)]


def values_of(model: Model) -> list[str]:
    """Return the names of the rows of values."""
    return [*kept(model), *(DEFINITION + name for name in model.recorded)]


def constants_of(model: Model) -> list[str]:
    """Return the names of the rows of constants: parameters, gains of receptors, elements of propagators."""
    elements, driven_by = elements_of(model).values(), factors_of(model)
    return [
        *(PARAMETER + name for name in model.parameters),
        *(GAIN + receptor for receptor in model.receptors),
        *(name for rows in elements for row in rows.values() for name in row.values()),
        *([CHANGE] if driven_by else []),
        *(name for factors in driven_by.values() for row in factors for name in row.values()),
    ]


def length_of_row(n: int) -> int:
    """Return the length of a row of values or constants of n cells, so that each begins at a cache line."""
    return -(-n // _IN_LINE) * _IN_LINE


class Course(NamedTuple):
    """What a propagator advances by: a share of a step, in which a cell is held or not."""

    share: float
    held: bool = False


def courses_of(model: Model) -> list[Course]:
    """Return the courses that have propagators; otherwise those to the stages of Runge-Kutta."""
    if model.method == EXACT:
        return [Course(1.0), Course(1.0, held=True)]
    return [Course(share) for share in np.unique(NODES[1:]).tolist()]


def propagated(model: Model) -> Model:
    """Return the part of the equations that has propagators; empty if Runge-Kutta is chosen for all."""
    if model.method == EXACT:
        return model
    part = linear_part(model)
    return part if len(part.variables) < len(model.variables) else replace(model, variables={})


def elements_of(model: Model) -> dict[Course, dict[str, dict[str, str]]]:
    """Return the names of the elements of propagators, by course, variable and column."""
    part, n = propagated(model), 0
    columns = columns_of(part)
    found: dict[Course, dict[str, dict[str, str]]] = {course: {} for course in courses_of(model)}
    for course, rows in found.items():
        for name, row in zip(part.variables, multiplied(part, held=course.held), strict=True):
            keys = [columns[column] for column in row.nonzero()[0].tolist()]
            rows[name] = {key: f"{_ELEMENT}{n + k}" for k, key in enumerate(keys)}
            n += len(keys)
    return found


def multiplied(part: Model, *, held: bool) -> npt.NDArray[np.bool_]:
    """Return by which elements of propagators a kernel multiplies.

    In a cell that is held these are the rows of variables that depend on a held one; other rows are as in a
    cell that is not.
    """
    found = pattern(part, held=held)
    if held:
        clamped = np.array([variable.held for variable in part.variables.values()])
        depends = pattern(part, held=False)[:, : len(clamped)][:, clamped].any(axis=1)
        found[~depends | clamped] = False
    return found


class Factors(NamedTuple):
    """The names of the factors that advance a driven variable.

    Args:
        whole_a, moment_a: factors of :class:`~nrp_core.network.equations.linear.Integrals`, by column.
        whole_b, moment_b: the same for the other coefficient.
        bound: of :class:`~nrp_brain_event.grid.equations.blocks.Bound`, by its fields and columns.
    """

    whole_a: Mapping[str, str]
    moment_a: Mapping[str, str]
    whole_b: Mapping[str, str]
    moment_b: Mapping[str, str]
    bound: Mapping[str, str]


def factors_of(model: Model) -> dict[str, Factors]:
    """Return the factors of all variables that are driven, if all others are linear."""
    found = {}
    for name, both in (driven(model) or {}).items() if model.method != EXACT else ():
        (whole_a, moment_a), (whole_b, moment_b) = (columns(model, own) for own in both)
        sized = [key for key in dict.fromkeys([*whole_a, *whole_b]) if key != ONE]
        rows = (whole_a, moment_a, whole_b, moment_b, [*LIMITS, *sized])
        found[name] = Factors(
            *(
                {key: f"{kind}_{name}_{k}" for k, key in enumerate(keys)}
                for kind, keys in zip(Factors._fields, rows, strict=True)
            )
        )
    return found


def product(elements: Mapping[str, str]) -> str:
    """Return the source of a row of a propagator times the state, the current and 1."""
    return sum_of((name, factor(key)) for key, name in elements.items())


def sum_of(products: Iterable[tuple[str, str]]) -> str:
    """Return the source of a sum of products; an empty factor stands for 1."""
    source = ""
    for one, other in reversed(list(products)):
        if not other:
            source = f"{one} + {source}" if source else one
        else:
            source = f"fma({one}, {other}, {source})" if source else f"{one} * {other}"
    return source


def factor(column: str) -> str:
    """Return the source of the factor of an element of a column; an empty text for 1."""
    return {ONE: "", INPUT: PARAMETER + INPUT}.get(column, STATE + column)


def loaded(model: Model, *, equal: bool) -> Iterator[str]:
    """Yield the lines that load cell i; constants that are equal for all cells are known before."""
    for name in kept(model):
        yield f"{name} = {every(name)}[i]"
    yield from given(model, equal=equal)


def given(model: Model, *, equal: bool) -> Iterator[str]:
    """Yield the lines that load the inputs of cell i: its constants and its current."""
    for name in () if equal else constants_of(model):
        yield f"{name} = {every(name)}[i]"
    if INPUT in model.parameters:  # with what devices inject
        yield f"{PARAMETER}{INPUT} = {every(DRIVE)}[i] * 1e-9"


def stored(names: Iterable[str]) -> Iterator[str]:
    """Yield the lines that store values of cell i."""
    return (f"{every(name)}[i] = {name}" for name in names)


def every(name: str) -> str:
    """Return the name of the array that has a value for each cell of a block."""
    return f"all_{name}"


def indented(lines: Iterable[str]) -> Iterator[str]:
    """Yield lines of a block of source."""
    return (f"    {line}" for line in lines)


def searched(test: Iterable[str], lines: Iterable[str]) -> Iterator[str]:
    """Yield a loop over a few cells i at once, for ``lines`` that few cells need.

    Args:
        test: the lines that find whether a cell is ``due``, which become vector instructions.
        lines: the update of the other cells in the block of a cell that is due.
    """
    yield f"for few in range(0, n, {_FEW}):"
    yield "    due = False"
    yield f"    for i in range(uint64(few), uint64(min(few + {_FEW}, n))):"  # not checked for a sign
    yield from indented(indented(test))
    yield "    if not due:"
    yield "        continue"
    yield f"    for i in range(few, min(few + {_FEW}, n)):"
    yield from indented(indented(lines))


def function(name: str, arguments: Sequence[str], lines: Iterable[str], compiled: str = "jit") -> str:
    """Return the source of a compiled function."""
    body = "\n".join(indented(lines))
    return f"@{compiled}\ndef {name}({', '.join(arguments)}):\n{body}\n"
