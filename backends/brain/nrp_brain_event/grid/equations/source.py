"""Writes the kernel of a cell that is given as equations: the source of a function that advances cells.

A kernel has parts that depend on the method, see :mod:`nrp_brain_event.grid.equations.exact_source` and
:mod:`nrp_brain_event.grid.equations.runge_kutta_source`; all others are written here. In a step a cell
advances to the grid point, then the spikes due there arrive, then it fires if the threshold is met.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from textwrap import indent
from typing import Final

from nrp_brain_event.equations.expressions import DEFINITION, IMPORTS, PARAMETER, STATE, needed, source_of
from nrp_brain_event.grid.equations import exact_source, runge_kutta_source
from nrp_brain_event.grid.records import X
from nrp_core.brain.network.equations.expressions import RANDOM, STEP
from nrp_core.brain.network.equations.model import EXACT, INPUT, Model

ARGUMENTS: Final = (
    ("values", "*float64"), ("constants", "*float64"), ("state", "*float64"), ("drive", "*float64"),
    ("fired", "*int32"), ("first_value", "int64"), ("first_constant", "int64"), ("size", "int64"),
    ("first_row", "int64"), ("a", "int64"), ("b", "int64"), ("n_rows", "int64"), ("n_fired", "int64"),
    ("step", "int64"), ("h", "float64"),
)  # fmt: skip
"""The arguments of a kernel, and their types for :func:`nrp_core._support.jit.c_function`."""
STREAM: Final = "stream"
"""The stream of random numbers of a cell, see :func:`nrp_brain_event.random_numbers.uniform_at`."""
_HEAD: Final = f'"""Advances cells that a user gave as equations; written by nrp_brain_event."""\n{IMPORTS}'


def hidden(model: Model) -> Sequence[str]:
    """Return the names of what a cell keeps besides its state variables."""
    of_method = exact_source.HIDDEN if model.method == EXACT else runge_kutta_source.HIDDEN
    return (*of_method, STREAM) if model.is_random else of_method


def kernel_source(model: Model) -> str:
    """Return the module with the kernel, ``advance``, of a cell."""
    exact = model.method == EXACT
    method = exact_source if exact else runge_kutta_source
    body = [
        *_loaded(model),
        *method.advanced(model),
        *_arrivals(model),
        *_threshold(model, method.fire(model)),
        *_stored(model),
    ]
    names = ", ".join(name for name, _ in ARGUMENTS)
    loop = indent("\n".join(body), 8 * " ")
    return (
        f"{_HEAD}\n{'' if exact else runge_kutta_source.slopes(model)}\n"
        f"@jit\ndef advance({names}):\n    for i in range(a, b):\n{loop}\n    return n_fired\n"
    )


def _loaded(model: Model) -> Iterator[str]:
    for k, name in enumerate(model.parameters):
        own = f"constants[first_constant + {k} * size + i]"
        yield f"{PARAMETER}{name} = {'drive[first_row + i] * 1e-9' if name == INPUT else own}"
    for k, name in enumerate([*(STATE + name for name in model.variables), *hidden(model)]):
        yield f"{name} = values[first_value + {k} * size + i]"


def _arrivals(model: Model) -> Iterator[str]:
    """Yield what the spikes that arrive at the grid point do; those onto held variables are lost."""
    yield "t = step * h"
    if model.lasts:  # a condition holds for the step that begins with it
        yield f"held = {exact_source.HELD if model.method == EXACT else runge_kutta_source.HELD}"
    for receptor, effect in model.receptors.items():
        place = f"state[{X + model.receptor_number(receptor)} * n_rows + first_row + i]"
        gain = f"({source_of(effect.factor, model)}) * {effect.unit.scale!r}"
        condition = f"{place} != 0.0" + (" and not held" if model.variables[effect.variable].held else "")
        yield f"if {condition}:"
        yield f"    {STATE}{effect.variable} += {gain} * {place}"
        yield f"{place} = 0.0"


def _threshold(model: Model, fire: Sequence[str]) -> Iterator[str]:
    if model.method != EXACT:
        yield "if not held and not spiked:"
    else:
        yield "if not held:"
    if model.is_random:
        yield f"    {RANDOM} = uniform_at({STREAM}, step)"
        yield f"    {STEP} = h"
    yield from (f"    {line}" for line in needed([model.threshold], model))
    yield f"    if {source_of(model.threshold, model)}:"
    yield from (f"        {line}" for line in fire)
    if model.method != EXACT:
        yield "if spiked:"
        yield "    fired[n_fired] = first_row + i"
        yield "    n_fired += 1"


def _stored(model: Model) -> Iterator[str]:
    finite = " and ".join(f"abs({STATE}{name}) < inf" for name in model.variables)
    yield f"if not ({finite}):"
    yield "    return -1 - i"
    for k, name in enumerate([*(STATE + name for name in model.variables), *hidden(model)]):
        yield f"values[first_value + {k} * size + i] = {name}"
    first = len(model.variables) + len(hidden(model))
    yield from needed(map(ast.Name, model.recorded), model)
    for k, name in enumerate(model.recorded, first):
        yield f"values[first_value + {k} * size + i] = {DEFINITION}{name}"
