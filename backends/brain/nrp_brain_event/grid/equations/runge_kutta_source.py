"""The part of a kernel that advances equations by the method of Dormand & Prince (1980), order 5(4).

A step of the grid is divided so that the local error stays below the tolerance. A sub-step in which the
threshold is met is halved until the crossing is located; the cell is reset there and spikes at the next grid
point, at most once in a step of the grid, as the cells of :mod:`nrp_brain_event.grid.curved`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from nrp_brain_event.equations.expressions import PARAMETER, STATE, needed, source_of
from nrp_brain_event.grid.equations.exact_source import reset
from nrp_brain_event.runge_kutta import ERROR, NODES, STAGES, WEIGHTS
from nrp_core.brain.network.equations.model import Model, Variable
from nrp_core.brain.network.equations.units import AMPERE, NONE, SECOND, SIEMENS, VOLT

HIDDEN: Final = ("rest", "wanted")
"""The remaining refractory period and the length of the next sub-step, s; 0 for the first."""
HELD: Final = "rest > 0.0"
TOLERANCE: Final = 1e-7
"""The largest local error of a sub-step, in units of a variable's scale and value together."""
_SCALES: Final = {VOLT: 1e-3, AMPERE: 1e-9, SIEMENS: 1e-9, SECOND: 1e-3, NONE: 1e-2}
"""Sizes of variables by dimension, in SI units: mV, nA, nS, ms and percent."""
_NARROW: Final = 1e-7
"""Width, in steps of the grid, within which a crossing is located."""
_SHORTEST: Final = 1e-12


def slopes(model: Model) -> str:
    """Return the function that computes the derivatives of the state variables."""
    names = [f"{STATE}{name}" for name in model.variables] + [
        f"{PARAMETER}{name}" for name in model.parameters
    ]
    rates = [variable.rate for variable in model.variables.values()]
    lines = list(needed(rates, model))
    for name, variable in model.variables.items():
        rate = source_of(variable.rate, model)
        lines.append(f"rate_{name} = " + (f"0.0 if held else {rate}" if variable.held else rate))
    lines.append("return " + ", ".join(f"rate_{name} + 0.0" for name in model.variables) + ",")
    body = "\n".join(f"    {line}" for line in lines)
    return f"\n@jit\ndef slopes(t, held, {', '.join(names)}):\n{body}\n\n"


def advanced(model: Model) -> Iterator[str]:
    """Yield the lines that advance a cell by a step of the grid."""
    yield "left, between, spiked = h, inf, False"
    yield "wanted = h if wanted <= 0.0 else wanted"
    yield "while left > 0.0:"
    yield from _indented(_sub_step(model))
    yield "if left < 0.0:"
    yield "    return -1 - i"


def _sub_step(model: Model) -> Iterator[str]:
    yield "t = step * h - left"
    if model.lasts:
        yield f"held = {HELD}"
        yield "longest = min(left, rest) if held else left"
    else:
        yield from needed([model.refractory], model)
        yield f"held = spiked or ({source_of(model.refractory, model)})"
        yield "longest = left"
    yield f"if between < {_NARROW} * h:"
    yield "    length = min(min(wanted, longest), between)"
    yield "else:"
    yield "    length = min(min(wanted, longest), 0.5 * between)"
    yield from _slopes_of(1, "t", STATE, model)
    yield "while True:"
    yield from _indented(_attempt(model))
    yield "if left < 0.0:"
    yield "    break"
    yield "between = between - length if between > length else inf"
    yield "left = 0.0 if length >= left else left - length"
    yield f"rest = 0.0 if rest - length < {_SHORTEST} * h else rest - length"
    yield "growth = 5.0 if error < 1e-4 else max(0.2, 0.9 * error ** -0.2)"
    yield "wanted = max(growth * length, wanted if length < wanted else 0.0)"
    yield from (f"{STATE}{name} = y_{name}" for name in model.variables)
    yield "if crossed:"
    yield "    between = inf"
    yield from _indented(fire(model))


def _attempt(model: Model) -> Iterator[str]:
    """Yield a sub-step of a length; it is repeated with a shorter one or leaves the loop."""
    for stage in range(1, STAGES):
        for name in model.variables:
            terms = [
                f"{weight!r} * k{j + 1}_{name}"
                for j, weight in enumerate(WEIGHTS[stage].tolist()[:stage])
                if weight
            ]
            yield f"y_{name} = {STATE}{name} + length * ({' + '.join(terms)})"
        yield from _slopes_of(stage + 1, f"t + {float(NODES[stage])!r} * length", "y_", model)
    yield "error = 0.0"
    for name, variable in model.variables.items():
        terms = [f"{weight!r} * k{j + 1}_{name}" for j, weight in enumerate(ERROR.tolist()) if weight]
        allowed = f"{TOLERANCE!r} * ({_scale(variable)!r} + abs(y_{name}))"
        yield f"one = abs(length * ({' + '.join(terms)})) / ({allowed})"
        yield "if not one <= error:"
        yield "    error = one if one < inf else inf"
    yield "if error > 1.0:"
    yield "    length *= max(0.2, 0.9 * error ** -0.2) if error < inf else 0.2"
    yield "    wanted = length"
    yield f"    if length < {_SHORTEST} * h:"
    yield "        left = -1.0"
    yield "        break"
    yield "    continue"
    yield "crossed = False"
    if not model.is_random:  # else it is tested once in a step of the grid
        yield "if not held and not spiked:"
        yield from _indented(needed([model.threshold], model, "y_"))
        yield f"    crossed = {source_of(model.threshold, model, 'y_')}"
    yield f"if crossed and length > {_NARROW} * h:"
    yield "    between = length"
    yield "    length *= 0.5"
    yield "    continue"
    yield "break"


def fire(model: Model) -> list[str]:
    """Return the lines for a spike; the cell is refractory at least until the next grid point."""
    lasts = [*needed([model.refractory], model), f"rest = max({source_of(model.refractory, model)}, left)"]
    return ["spiked = True", *reset(model), *(lasts if model.lasts else [])]


def _slopes_of(stage: int, t: str, state: str, model: Model) -> Iterator[str]:
    names = [f"{state}{name}" for name in model.variables] + [
        f"{PARAMETER}{name}" for name in model.parameters
    ]
    into = ", ".join(f"k{stage}_{name}" for name in model.variables)
    yield f"({into},) = slopes({t}, held, {', '.join(names)})"


def _scale(variable: Variable) -> float:
    return min(variable.unit.scale, _SCALES.get(variable.unit.dimension, variable.unit.scale))


def _indented(lines: Iterable[str]) -> Iterator[str]:
    return (f"    {line}" for line in lines)
