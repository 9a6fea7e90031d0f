"""The part of a kernel that advances linear equations by their propagators."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from nrp_brain_event.equations.expressions import PARAMETER, STATE, needed, source_of
from nrp_core.brain.network.equations.linear import ONE
from nrp_core.brain.network.equations.model import INPUT, Model
from nrp_core.brain.network.equations.propagators import columns_of, pattern

HIDDEN: Final = ("until",)
"""The last step in which the cell is refractory."""
HELD: Final = "step <= until"
ROUNDING: Final = 1e-6
"""Steps by which a refractory period may exceed a whole number of steps."""


def advanced(model: Model) -> Iterator[str]:
    """Yield the lines that advance a cell by a step."""
    yield "t = (step - 1) * h"
    yield from () if model.lasts else needed([model.refractory], model)
    yield f"held = {HELD if model.lasts else source_of(model.refractory, model)}"
    first = len(model.parameters)
    if not any(variable.held for variable in model.variables.values()):
        yield from _moved(model, first, held=False)
        return
    yield "if held:"
    yield from (
        f"    {line}" for line in _moved(model, first + int(pattern(model, held=False).sum()), held=True)
    )
    yield "else:"
    yield from (f"    {line}" for line in _moved(model, first, held=False))


def _moved(model: Model, first: int, *, held: bool) -> Iterator[str]:
    """Yield the multiplication by a propagator, whose elements begin at a constant."""
    nonzero, columns = pattern(model, held=held), columns_of(model)
    factors = {ONE: "", INPUT: f" * {PARAMETER}{INPUT}"}
    rows = []
    number = first
    for row, name in enumerate(model.variables):
        terms = []
        for column in nonzero[row].nonzero()[0].tolist():
            key = columns[column]
            factor = factors.get(key, f" * {STATE}{key}")
            terms.append(f"constants[first_constant + {number} * size + i]{factor}")
            number += 1
        rows.append((f"y_{name}", " + ".join(terms)))
    yield from (f"{name} = {value}" for name, value in rows)
    yield from (f"{STATE}{name} = y_{name}" for name in model.variables)


def fire(model: Model) -> list[str]:
    """Return the lines for a spike."""
    lasts = [f"until = step + ceil(({source_of(model.refractory, model)}) / h - {ROUNDING!r})"]
    return [
        "fired[n_fired] = first_row + i",
        "n_fired += 1",
        *reset(model),
        *([*needed([model.refractory], model), *lasts] if model.lasts else []),
    ]


def reset(model: Model) -> Iterator[str]:
    """Yield the lines of the reset, one after the other."""
    for name, value in model.reset:
        yield from needed([value], model)
        yield f"{STATE}{name} = {source_of(value, model)}"
