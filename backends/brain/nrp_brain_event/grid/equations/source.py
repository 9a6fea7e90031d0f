"""Writes the kernel of a cell that is given as equations: the source of a function that advances cells.

In a step a cell advances to the grid point, then the spikes due there arrive, then it fires if the threshold
is met. A kernel takes a block of cells at a time. What all cells do is a loop that the compiler turns into
vector instructions; what few cells do, as to fire, is a loop of its own. How a cell advances is in
:mod:`nrp_brain_event.grid.equations.exact_source` and
:mod:`nrp_brain_event.grid.equations.runge_kutta_source`.
"""

from __future__ import annotations

import ast
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from re import findall
from typing import Final

from nrp_brain_event.equation_source import DEFINITION, IMPORTS, STATE, needed, source_of
from nrp_brain_event.grid.equations import exact_source, runge_kutta_source
from nrp_brain_event.grid.equations.exact_source import bounded
from nrp_brain_event.grid.equations.layout import (
    DRIVE,
    GAIN,
    INPUTS,
    STREAM,
    constants_of,
    every,
    function,
    indented,
    kept,
    loaded,
    searched,
    stored,
    values_of,
)  # fmt: skip
from nrp_brain_event.grid.equations.runge_kutta_source import attempted, changed, tested_again
from nrp_brain_event.grid.records import X
from nrp_core.network.equations.expressions import RANDOM, STEP
from nrp_core.network.equations.model import EXACT, Model

ARGUMENTS: Final = (
    ("values", "*float64"), ("constants", "*float64"), ("state", "*float64"), ("drive", "*float64"),
    ("fired", "*int32"), ("first_value", "int64"), ("first_constant", "int64"), ("length", "int64"),
    ("first_row", "int64"), ("a", "int64"), ("b", "int64"), ("n_rows", "int64"), ("n_fired", "int64"),
    ("step", "int64"), ("h", "float64"),
)  # fmt: skip
"""The arguments of a kernel, and their types for :func:`nrp_core._support.jit.c_function`."""
_BLOCK: Final = 1024
"""Cells whose values stay in the cache of a core while they are computed."""
HEAD: Final = f'''"""Advances cells that a user gave as equations; written by nrp_brain_event."""
{IMPORTS}
from numpy import uint64

from nrp_brain_event.equation_functions import exp
from nrp_core._support.jit import inlined
'''


def kernel_source(model: Model, *, equal: bool, driven: bool = False) -> str:
    """Return the module with the kernel, ``advance``, of a cell.

    Args:
        model: the cell.
        equal: whether all cells have the same constants.
        driven: whether cells attempt a step by :mod:`nrp_brain_event.grid.equations.exact_source`.
    """
    exact, load, arrays = (
        model.method == EXACT,
        list(loaded(model, equal=equal)),
        arrays_of(model, equal=equal),
    )
    functions = {"move": [*_moving(model, load, driven=driven)]}
    if not exact:
        ended = [*arrived(model), *stored(kept(model)), *refused(model)]
        if not _searched(model):
            ended += [*tested(model), *_fired(model)]
        functions["divide"] = [*runge_kutta_source.divide(model, load, ended)]
    if _searched(model):
        functions["fire"] = [*_firing(model, load)]
    if model.recorded:
        functions["note"] = [*_noting(model, load)]
    known = set(findall(r"\w+", "\n".join(line for lines in functions.values() for line in lines)))
    arrays = {name: array for name, array in arrays.items() if name in known}
    names = ["n", "step", "h", "first_row", "fired", "n_fired", *arrays]
    parts = [function(name, names, lines, "inlined") for name, lines in functions.items()]
    parts.append(function("advance", [name for name, _ in ARGUMENTS], _advance(functions, names, arrays)))
    return "\n\n".join([HEAD if exact else HEAD + runge_kutta_source.slopes(model), *parts])


def _advance(functions: Iterable[str], names: Sequence[str], arrays: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines that take a block at a time; a cell that cannot be integrated ends them."""
    yield f"for first in range(a, b, {_BLOCK}):"
    yield f"    n = min({_BLOCK}, b - first)"
    yield from (f"    {name} = {value}" for name, value in arrays.items())
    given = ", ".join(names).replace("first_row", "first_row + first")
    yield f"    due = move({given})"
    yield "    if due < 0:"
    yield "        return due - first"
    yield "    if due:"
    for name in ("divide", "fire"):
        if name in functions:
            yield f"        n_fired = {name}({given})"
    if "divide" in functions:
        yield "        if n_fired < 0:"
        yield "            return n_fired - first"
    if "note" in functions:
        yield f"    note({given})"
    yield "return n_fired"


def _searched(model: Model) -> bool:
    """Return whether cells may fire whose step is not divided."""
    return model.method == EXACT or tested_again(model)


def arrays_of(model: Model, *, equal: bool) -> dict[str, str]:
    """Return the names of the arrays that a block passes to the parts of a kernel, with the kind of each."""

    def cells(whole: str, place: str) -> str:
        return f"{whole}[{place} + first:{place} + first + n]"

    found = {every(DRIVE): cells("drive", "first_row")}
    for k, name in enumerate(values_of(model)):
        found[every(name)] = cells("values", f"first_value + {k} * length")
    for receptor in model.receptors:
        line = X + model.receptor_number(receptor)
        found[every(INPUTS + receptor)] = cells("state", f"{line} * n_rows + first_row")
    for k, name in enumerate(constants_of(model)):
        place = f"first_constant + {k} * length"
        found |= {name: f"constants[{place}]"} if equal else {every(name): cells("constants", place)}
    return found


def _moving(model: Model, load: Sequence[str], *, driven: bool) -> Iterator[str]:
    """Yield the lines that advance all cells that need no other loop, and let spikes arrive there."""
    exact = model.method == EXACT
    only = "" if exact else "done"
    names = exact_source.changed(model) if exact else changed(model, driven=driven)
    yield "due, lost = False, False"
    yield "for i in range(n):"
    yield from indented(load)
    yield from indented(exact_source.advanced(model) if exact else attempted(model, driven=driven))
    yield from indented([*arrived(model, only), *stored(names)])
    again = _searched(model)
    yield from indented(tested(model) if again else [])
    yield f"    due |= {' or '.join([*(['met'] if again else []), *([] if exact else ['not done'])])}"
    finite = _finite(model, bounded(model) if driven else ())
    if finite:
        yield f"    lost |= not {finite}"
    yield "if lost:"
    yield "    for i in range(n):"
    yield from indented(indented([*load, *refused(model)]))
    yield "return int(due)"


def arrived(model: Model, only: str = "") -> Iterator[str]:
    """Yield the lines for spikes that arrive at the grid point, and for the update of the cell after them.

    Some spikes onto held variables are lost.

    Args:
        model: the cell.
        only: the name of a condition for arrivals.
    """
    for receptor, effect in model.receptors.items():
        arrived = f"{every(INPUTS + receptor)}[i]"
        is_lost = model.variables[effect.variable].held and not effect.always
        condition = " and ".join([*(["not held"] if is_lost else []), *([only] if only else [])])
        variable = STATE + effect.variable
        more = f"fma({GAIN}{receptor}, {arrived}, {variable})"
        yield f"{variable} = {more}" + (f" if {condition} else {variable}" if condition else "")
        yield f"{arrived} = 0.0" + (f" if {only} else {arrived}" if only else "")
    if model.on_step:
        yield "t = step * h"
    for name, value in model.on_step:
        yield from needed([value], model)
        yield f"{STATE}{name} = {source_of(value, model)}" + (
            f" if {only} else {STATE}{name}" if only else ""
        )


def tested(model: Model) -> Iterator[str]:
    """Yield the lines that find whether a cell meets its threshold."""
    yield "t = step * h"
    if model.is_random:
        yield f"{RANDOM} = uniform_at({STREAM}, step)"
        yield f"{STEP} = h"
    yield from needed([model.threshold], model)
    yield f"met = not held and not spiked and ({source_of(model.threshold, model)})"


def _finite(model: Model, known: Container[str] = ()) -> str:
    """Return the condition that the state is finite, without variables that are known to be."""
    names = [STATE + name for name in model.variables if name not in known]
    return f"abs({' + '.join(names)}) < inf" if names else ""


def refused(model: Model) -> Iterator[str]:
    """Yield the lines that end a kernel if the state of a cell is not finite."""
    if finite := _finite(model):
        yield f"if not {finite}:"
        yield "    return -1 - i"


def _firing(model: Model, load: Sequence[str]) -> Iterator[str]:
    """Yield the lines that find the cells that fire, and reset them."""
    method = exact_source if model.method == EXACT else runge_kutta_source
    begun = [*load, *method.regime(model)]
    met = [*begun, *tested(model), "due |= met or spiked"]
    yield from searched(met, [*begun, *tested(model), *_fired(model)])
    yield "return n_fired"


def _fired(model: Model) -> Iterator[str]:
    """Yield the lines by which a cell fires that is tested."""
    method = exact_source if model.method == EXACT else runge_kutta_source
    yield "if met:"
    yield from indented([*method.fire(model), *stored(kept(model))])
    yield "if met or spiked:"
    yield "    fired[n_fired] = first_row + i"
    yield "    n_fired += 1"


def _noting(model: Model, load: Sequence[str]) -> Iterator[str]:
    """Yield the lines that store recorded definitions."""
    yield "t = step * h"
    yield "for i in range(n):"
    yield from indented([*load, *needed(map(ast.Name, model.recorded), model)])
    yield from indented(stored(DEFINITION + name for name in model.recorded))
    yield "return 0"
