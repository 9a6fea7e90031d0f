"""Writes the kernel with which the lazy grid advances linear equations, and its arguments.

A cell is a row of ``states``: the input of its receptors in this step, the values that
:func:`~nrp_brain_event.grid.equations.layout.kept` names, the step at which this held, and the place of the
``factors`` of cells with its parameters. These are the bound of the
excess over the threshold, then the elements of the propagators by few and by many steps. A single step is
computed as in the plain grid, with the same bits.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from re import findall
from typing import Final

import numpy as np

from nrp_brain_event.equation_source import DEFINITION, PARAMETER, STATE, compiled, needed
from nrp_brain_event.grid.equations import exact_source
from nrp_brain_event.grid.equations.layout import (
    INPUTS,
    courses_of,
    elements_of,
    every,
    function,
    given,
    indented,
    kept,
    multiplied,
    product,
    stored,
)
from nrp_brain_event.grid.equations.settling import N_FINE, bound, powers
from nrp_brain_event.grid.equations.source import HEAD, arrays_of, arrived, refused, tested
from nrp_brain_event.grid.lazy_neuron import LOOK, SHOW
from nrp_core._support.arrays import CACHE_LINE, FloatArray
from nrp_core.network.equations.model import INPUT, Model

ARGUMENTS: Final = (
    ("values", "*float64"), ("constants", "*float64"), ("state", "*float64"), ("drive", "*float64"),
    ("fired", "*int32"), ("states", "*float64"), ("factors", "*float64"), ("rows", "*int32"),
    ("first_value", "int64"), ("first_constant", "int64"), ("first_state", "int64"), ("length", "int64"),
    ("first_row", "int64"), ("n", "int64"), ("n_rows", "int64"), ("begin", "int64"), ("n_due", "int64"),
    ("n_fired", "int64"), ("step", "int64"), ("h", "float64"), ("purpose", "int64"),
)  # fmt: skip
"""The arguments of a kernel, and their types for :func:`nrp_core._support.jit.c_function`.

It takes the ``n_due`` first of the ``rows`` from ``begin`` on, and returns how many cells have fired, or
``-1 - i`` if cell i cannot be integrated.
"""
_LINE: Final = CACHE_LINE // np.dtype(np.float64).itemsize
_AHEAD: Final = 8
"""Cells whose states are prefetched."""
_ROUNDING: Final = 1e-9
"""The excess, as a share of the unit of variables, within which rounding errors could matter."""


def n_inputs(model: Model) -> int:
    """Return for how many receptors a row of ``states`` has room."""
    return 1 + max((model.receptor_number(receptor) for receptor in model.receptors), default=-1)


def width_of(model: Model) -> int:
    """Return the length of a row of ``states``, in whole cache lines."""
    return -(-(n_inputs(model) + len(kept(model)) + 2) // _LINE) * _LINE


def factors_of_kind(model: Model, parameters: Mapping[str, FloatArray], step_s: float) -> FloatArray:
    """Return the ``factors`` of cells with equal parameters.

    Args:
        model: equations without an obstacle.
        parameters: in SI units, shape ``(1,)``.
        step_s: the step, s.
    """
    found = {course.held: powers(model, parameters, step_s, held=course.held) for course in courses_of(model)}
    limits = bound(model, parameters, found[False])
    excess = limits.excess[0] + _ROUNDING * limits.size, limits.excess[1]
    variables = np.stack([*limits.rest, limits.highest, limits.lowest], axis=1)
    n = len(model.variables)
    elements = [every_[:, :n][:, multiplied(model, held=held)] for held, every_ in found.items()]
    return np.concatenate([excess, variables.ravel(), np.concatenate(elements, axis=1).ravel()])


def lazy_kernel(model: Model, *, equal: bool) -> int:
    """Return the handle of the kernel of a cell, with the ``ARGUMENTS``.

    Args:
        model: equations without an obstacle.
        equal: whether all cells have the same constants.
    """
    return compiled(_source(model, equal=equal), "advance", ARGUMENTS)


def _source(model: Model, *, equal: bool) -> str:
    lines = [*_cell(model, equal=equal)]
    known = set(findall(r"\w+", "\n".join(lines)))
    arrays = {name: array for name, array in arrays_of(model, equal=equal).items() if name in known}
    body = [
        "first = 0",
        *(f"{name} = {array}" for name, array in arrays.items()),
        "for k in range(begin, begin + n_due):",
        *indented(lines),
        "return n_fired",
    ]
    more = "from nrp_core._support.jit import prefetch\n"
    return "\n\n".join([HEAD + more, function("advance", [name for name, _ in ARGUMENTS], body)])


def _cell(model: Model, *, equal: bool) -> Iterator[str]:
    names, width, begin = kept(model), width_of(model), n_inputs(model)
    end = begin + len(names)
    ahead = f"rows[min(k + {_AHEAD}, begin + n_due - 1)]"
    yield f"prefetch(states, first_state + ({ahead} - first_row) * {width}, 0)"
    yield "i = rows[k] - first_row"
    yield f"at = first_state + i * {width}"
    yield from (f"{name} = states[at + {k}]" for k, name in enumerate(names, start=begin))
    yield f"last = int(states[at + {end}])"
    yield f"own = int(states[at + {end + 1}])"
    yield from given(model, equal=equal)
    yield from _brought(model)
    yield f"if purpose == {SHOW}:"
    yield "    t = step * h"
    yield from indented(stored(names))
    yield from indented(needed(map(ast.Name, model.recorded), model))
    yield from indented(stored(DEFINITION + name for name in model.recorded))
    yield "    continue"
    yield f"if purpose == {LOOK}:"
    yield from indented([*exact_source.regime(model), *_arrived(model), *refused(model), *tested(model)])
    yield "    if met:"
    yield from indented(indented([*exact_source.fire(model), "fired[n_fired] = rows[k]", "n_fired += 1"]))
    yield from (f"states[at + {k}] = {name}" for k, name in enumerate([*names, "step"], start=begin))
    yield f"if purpose == {LOOK} and step >= until:"
    yield from indented(_bounded(model))


def _arrived(model: Model) -> Iterator[str]:
    """Yield the lines that read a cell's arrived input from its row."""
    for line in arrived(model):
        for receptor in model.receptors:
            line = line.replace(
                f"{every(INPUTS + receptor)}[i]", f"states[at + {model.receptor_number(receptor)}]"
            )
        yield line


def _brought(model: Model) -> Iterator[str]:
    """Yield the lines that advance a cell to a step, by stretches in which it is refractory or not."""
    free, held = elements_of(model).values()
    n_elements = sum(len(row) for rows in (free, held) for row in rows.values())
    yield "while last < step:"
    yield "    gap = (int(until) if last < until and until < step else step) - last"
    yield f"    many = min(gap // {N_FINE}, {N_FINE - 1})"
    yield f"    place = own + {_n_limits(model)} + (many + {N_FINE} if many > 0 else gap) * {n_elements}"
    yield "    if last < until:"
    clamped = {name for name, variable in model.variables.items() if variable.held}
    rows = {name: held[name] or free[name] for name in model.variables if name not in clamped}
    yield from indented(indented(_multiplied(rows)))
    yield "    else:"
    yield from indented(indented(_multiplied(free)))
    yield f"    last += many * {N_FINE} if many > 0 else gap"


def _multiplied(rows: Mapping[str, Mapping[str, str]]) -> Iterator[str]:
    """Yield the lines that multiply the state by rows of a propagator."""
    yield "pass"
    for name, row in rows.items():
        placed = {key: f"factors[place + {element.rpartition('_')[2]}]" for key, element in row.items()}
        yield f"y_{name} = {product(placed)}"
    yield from (f"{STATE}{name} = y_{name}" for name in rows)


def _n_limits(model: Model) -> int:
    return 2 + 4 * len(model.variables)


def _bounded(model: Model) -> Iterator[str]:
    """Yield the lines that mark a row that cannot reach the threshold without further input."""
    current = PARAMETER + INPUT if INPUT in model.parameters else "0.0"
    yield f"excess = factors[own] + factors[own + 1] * {current}"
    for k, name in enumerate(model.variables):
        rest, gain, highest, lowest = (f"factors[own + {2 + 4 * k + j}]" for j in range(4))
        yield f"away = {STATE}{name} - ({rest} + {gain} * {current})"
        yield f"excess += max({highest} * away, {lowest} * away)"
    yield "if excess < 0.0:"
    yield "    rows[k] = -1 - rows[k]"
