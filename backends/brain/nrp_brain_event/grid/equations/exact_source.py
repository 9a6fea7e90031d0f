"""The part of a kernel that advances linear equations by their propagators.

The part of a kernel that advances variables with conductances, ``x' = a(t) x + b(t)``, by a whole step.

The fourth-order Magnus expansion with the exact integrals of a and b, as the built-in cells of
:mod:`nrp_brain_event.grid.spiking`, with a Pade approximant of order (2, 2) of the exponential. A bound of
its local error is met in each step, see :mod:`nrp_brain_event.grid.equations.blocks`; a cell for which
it is not divides the step by Runge-Kutta.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from nrp_brain_event.equation_source import STATE, needed, source_of
from nrp_brain_event.grid.equations.layout import (
    LIMITS,
    Course,
    elements_of,
    factor,
    factors_of,
    product,
    sum_of,
)
from nrp_core.network.equations.model import Model

MOST_CHANGE: Final = 0.1
"""The share by which coefficients may change in a step; above it, the bound is seldom met."""


def driven_step(model: Model) -> Iterator[str]:
    """Yield the lines for the state at the end of a step, prefixed ``y_``."""
    for name, row in elements_of(model)[Course(1.0)].items():
        yield f"y_{name} = {product(row)}"
    for name, factors in factors_of(model).items():
        x = STATE + name
        yield f"a_0 = {product(factors.whole_a) or '0.0'}"
        yield f"a_1 = {product(factors.moment_a) or '0.0'}"
        yield f"b_0 = {product(factors.whole_b) or '0.0'}"
        yield f"b_1 = {product(factors.moment_b) or '0.0'}"
        yield "b_0 = fma(-a_0, b_1, fma(a_1, b_0, b_0))"
        yield f"y_{name} = {x} + fma(a_0, {x}, b_0) / fma(a_0, fma(a_0, {1.0 / 12.0!r}, -0.5), 1.0)"
        if model.variables[name].held:
            yield f"y_{name} = {x} if held else y_{name}"


def driven_test(model: Model) -> Iterator[str]:
    """Yield the lines that find whether the errors of a whole step are below the tolerance."""
    for name, factors in factors_of(model).items():
        least, slope, reach = (factors.bound[key] for key in LIMITS)
        sizes = {key: size for key, size in factors.bound.items() if key not in LIMITS}
        total = sum_of((size, f"abs({factor(key)})") for key, size in sizes.items()) or "0.0"
        yield f"near = {reach} if abs({STATE}{name}) > {reach} else abs({STATE}{name})"
        yield f"done = done and {total} < fma({slope}, near, {least})"


def bounded(model: Model) -> set[str]:
    """Return the variables that are finite if the errors are below the tolerance."""
    factors = factors_of(model)
    changed = {effect.variable for effect in model.receptors.values()} | {name for name, _ in model.on_step}
    return {*(factors.keys() - changed), *(key for one in factors.values() for key in one.bound)}


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
    """Return the names of the variables that a step changes."""
    return [*(STATE + name for name in model.variables), *(() if model.lasts else ("until",))]


def regime(model: Model) -> Iterator[str]:
    """Yield the lines that find the regime of a cell at the end of a step, when a period may be over."""
    yield f"held = step {'<' if model.lasts else '<='} until"
    yield "spiked = False"


def fire(model: Model) -> Iterator[str]:
    """Yield the lines for a spike."""
    yield from reset(model)
    if model.lasts:
        yield from needed([model.refractory], model)
        yield f"until = float(step + ceil(({source_of(model.refractory, model)}) / h - {_ROUNDING!r}))"


def reset(model: Model) -> Iterator[str]:
    """Yield the lines of the reset."""
    for name, value in model.reset:
        yield from needed([value], model)
        yield f"{STATE}{name} = {source_of(value, model)}"
