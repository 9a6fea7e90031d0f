"""The part of a kernel that advances linear equations by their propagators."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from nrp_brain_event.equations.expressions import STATE, needed, source_of
from nrp_brain_event.grid.equations.layout import elements_of, product
from nrp_core.brain.network.equations.model import Model

_ROUNDING: Final = 1e-6
"""Steps by which a refractory period may exceed a whole number of steps."""


def advanced(model: Model) -> Iterator[str]:
    """Yield the lines that advance a cell by a step."""
    yield "t = (step - 1) * h"
    if not model.lasts:  # a condition holds for the step that begins with it
        yield from needed([model.refractory], model)
        yield f"until = float(step) if {source_of(model.refractory, model)} else 0.0"
    yield "held = step <= until"
    elements = elements_of(model)  # of a cell that is not held, and of one that is
    for name, variable in model.variables.items():
        free, clamped = (product(rows[name]) for rows in elements.values())
        clamped = STATE + name if variable.held else clamped
        yield f"y_{name} = " + (f"{clamped} if held else {free}" if clamped else free)
    yield from (f"{STATE}{name} = y_{name}" for name in model.variables)
    yield from regime(model)


def changed(model: Model) -> list[str]:
    """Return the names of what a step changes."""
    return [*(STATE + name for name in model.variables), *(() if model.lasts else ("until",))]


def regime(model: Model) -> Iterator[str]:
    """Yield the lines that find what a cell is in at the end of a step, when a period may be over."""
    yield f"held = step {'<' if model.lasts else '<='} until"
    yield "spiked = False"


def fire(model: Model) -> Iterator[str]:
    """Yield the lines for a spike."""
    yield from reset(model)
    if model.lasts:
        yield from needed([model.refractory], model)
        yield f"until = float(step + ceil(({source_of(model.refractory, model)}) / h - {_ROUNDING!r}))"


def reset(model: Model) -> Iterator[str]:
    """Yield the lines of the reset, one after the other."""
    for name, value in model.reset:
        yield from needed([value], model)
        yield f"{STATE}{name} = {source_of(value, model)}"
