"""Writes the kernel of a cell that is given as equations: the source of a function that advances cells.

In a step a cell advances to the grid point, then the spikes due there arrive, then it fires if the threshold
is met. A kernel takes a block of cells at a time. What all cells do is a loop that the compiler turns into
vector instructions; what few cells do, as to fire, is a loop of its own. How a cell advances is in
:mod:`nrp_brain_event.grid.equations.exact_source` and
:mod:`nrp_brain_event.grid.equations.runge_kutta_source`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final

from nrp_brain_event.equations.expressions import DEFINITION, IMPORTS, STATE, needed, source_of
from nrp_brain_event.grid.equations import exact_source, runge_kutta_source
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
    stored,
    values_of,
)  # fmt: skip
from nrp_brain_event.grid.records import X
from nrp_core.brain.network.equations.expressions import RANDOM, STEP
from nrp_core.brain.network.equations.model import EXACT, Model

ARGUMENTS: Final = (
    ("values", "*float64"), ("constants", "*float64"), ("state", "*float64"), ("drive", "*float64"),
    ("fired", "*int32"), ("first_value", "int64"), ("first_constant", "int64"), ("size", "int64"),
    ("first_row", "int64"), ("a", "int64"), ("b", "int64"), ("n_rows", "int64"), ("n_fired", "int64"),
    ("step", "int64"), ("h", "float64"),
)  # fmt: skip
"""The arguments of a kernel, and their types for :func:`nrp_core._support.jit.c_function`."""
_BLOCK: Final = 1024
"""Cells whose values stay in the cache of a core while they are computed."""
_FEW: Final = 32
"""Cells that are searched at once for one that fires."""
_HEAD: Final = f'''"""Advances cells that a user gave as equations; written by nrp_brain_event."""
{IMPORTS}
from numpy import uint64

from nrp_brain_event.equations.functions import exp
from nrp_core._support.jit import inlined
'''


def kernel_source(model: Model, *, equal: bool) -> str:
    """Return the module with the kernel, ``advance``, of a cell.

    Args:
        model: the cell.
        equal: whether all cells have the same constants.
    """
    exact, load, arrays = model.method == EXACT, list(loaded(model, equal=equal)), _arrays(model, equal=equal)
    functions = {} if exact else runge_kutta_source.advancing(model, load)
    before = exact_source.advanced(model) if exact else runge_kutta_source.regime(model)
    functions["arrive"] = [*_arriving(model, [*load, *before])]
    functions["fire"] = [*_firing(model, load)]
    if model.recorded:
        functions["note"] = [*_noting(model, load)]
    names = ["n", "step", "h", "first_row", "fired", "n_fired", *arrays]
    parts = [function(name, names, lines, "inlined") for name, lines in functions.items()]
    parts.append(function("advance", [name for name, _ in ARGUMENTS], _advance(functions, names, arrays)))
    return "\n\n".join([_HEAD if exact else _HEAD + runge_kutta_source.slopes(model), *parts])


def _advance(functions: Iterable[str], names: Sequence[str], arrays: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines that take a block at a time; a cell that cannot be integrated ends them."""
    yield f"for first in range(a, b, {_BLOCK}):"
    yield f"    n = min({_BLOCK}, b - first)"
    yield from (f"    {name} = {value}" for name, value in arrays.items())
    given = ", ".join(names).replace("first_row", "first_row + first")
    if "attempt" in functions:
        yield f"    if attempt({given}):"
        yield f"        failed = divide({given})"
        yield "        if failed >= 0:"
        yield "            return -1 - first - failed"
    yield f"    if arrive({given}):"
    yield f"        n_fired = fire({given})"
    yield "        if n_fired < 0:"
    yield "            return n_fired - first"
    if "note" in functions:
        yield f"    note({given})"
    yield "return n_fired"


def _arrays(model: Model, *, equal: bool) -> dict[str, str]:
    """Return the names of what the parts of a kernel are given for a block, and what each is."""

    def cells(whole: str, place: str) -> str:
        return f"{whole}[{place} + first:{place} + first + n]"

    found = {every(DRIVE): cells("drive", "first_row")}
    for k, name in enumerate(values_of(model)):
        found[every(name)] = cells("values", f"first_value + {k} * size")
    for receptor in model.receptors:
        line = X + model.receptor_number(receptor)
        found[every(INPUTS + receptor)] = cells("state", f"{line} * n_rows + first_row")
    for k, name in enumerate(constants_of(model)):
        place = f"first_constant + {k} * size"
        found |= {name: f"constants[{place}]"} if equal else {every(name): cells("constants", place)}
    return found


def _arriving(model: Model, before: Sequence[str]) -> Iterator[str]:
    """Yield the lines for spikes that arrive at the grid point; those onto held variables are lost."""
    yield "due = False"
    yield "for i in range(n):"
    yield from indented(before)
    for receptor, effect in model.receptors.items():
        name, arrived = STATE + effect.variable, f"{every(INPUTS + receptor)}[i]"
        condition = f"{arrived} != 0.0" + (" and not held" if model.variables[effect.variable].held else "")
        yield f"    {name} += {GAIN}{receptor} * {arrived} if {condition} else 0.0"
        yield f"    {arrived} = 0.0"
    yield from indented(stored(_changed(model)))
    yield from indented(_tested(model))
    yield "    due |= met or spiked or not finite"
    yield "return due"


def _changed(model: Model) -> list[str]:
    """Return the names of what the loop over all cells changes."""
    if model.method == EXACT:
        return [*(STATE + name for name in model.variables), *(() if model.lasts else ("until",))]
    return list(dict.fromkeys(STATE + effect.variable for effect in model.receptors.values()))


def _tested(model: Model) -> Iterator[str]:
    """Yield the lines that find whether a cell meets its threshold, and whether its state is finite."""
    yield "t = step * h"
    if model.is_random:
        yield f"{RANDOM} = uniform_at({STREAM}, step)"
        yield f"{STEP} = h"
    yield from needed([model.threshold], model)
    yield f"met = not held and not spiked and ({source_of(model.threshold, model)})"
    yield "finite = " + " and ".join(f"abs({STATE}{name}) < inf" for name in model.variables)


def _firing(model: Model, load: Sequence[str]) -> Iterator[str]:
    """Yield the lines that find the cells that fire, and reset them."""
    method = exact_source if model.method == EXACT else runge_kutta_source
    test = [*load, *method.regime(model), *_tested(model)]
    yield f"for few in range(0, n, {_FEW}):"
    yield "    due = False"
    yield f"    for i in range(uint64(few), uint64(min(few + {_FEW}, n))):"  # not checked for a sign
    yield from indented(indented([*test, "due |= met or spiked or not finite"]))
    yield "    if not due:"
    yield "        continue"
    yield f"    for i in range(few, min(few + {_FEW}, n)):"
    yield from indented(indented(test))
    yield "        if not finite:"
    yield "            return -1 - i"
    yield "        if met:"
    yield from indented(indented(indented([*method.fire(model), *stored(kept(model))])))
    yield "        if met or spiked:"
    yield "            fired[n_fired] = first_row + i"
    yield "            n_fired += 1"
    yield "return n_fired"


def _noting(model: Model, load: Sequence[str]) -> Iterator[str]:
    """Yield the lines that store recorded definitions."""
    yield "t = step * h"
    yield "for i in range(n):"
    yield from indented([*load, *needed(map(ast.Name, model.recorded), model)])
    yield from indented(stored(DEFINITION + name for name in model.recorded))
    yield "return 0"
