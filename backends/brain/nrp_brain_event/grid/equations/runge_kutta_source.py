"""The part of a kernel that advances equations by the method of Dormand & Prince (1980), order 5(4).

A step of the grid is divided so that the local error stays below the tolerance. A sub-step in which the
threshold is met is shortened until the crossing is located; the cell is reset there and spikes at the next
grid point, at most once in a step of the grid, as the cells of :mod:`nrp_brain_event.grid.on_demand`. Most
cells need one sub-step, as long as the step. So all attempt that first, and the step is divided only for
those which fail.

The part of a kernel that chooses how long the sub-step is in which a crossing of the threshold is sought.

A threshold that compares two values, ``v > v_thresh``, has a distance: it changes its sign at the crossing.
It is followed along chords, and an end of the bracket that stays has half the weight (the Illinois method,
Dowell & Jarratt 1971, BIT 11:168), so a few sub-steps find what halving finds in twenty-five. Other
thresholds are sought by halving.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from typing import Final

from nrp_brain_event.equation_source import PARAMETER, STATE, needed, source_of
from nrp_brain_event.grid.equations.exact_source import driven_step, driven_test, reset
from nrp_brain_event.grid.equations.layout import (
    TOLERANCE,
    Course,
    elements_of,
    every,
    function,
    indented,
    kept,
    product,
    propagated,
    scale_of,
    searched,
    sum_of,
)
from nrp_brain_event.runge_kutta import ERROR, NODES, STAGES, WEIGHTS
from nrp_core.network.equations.expressions import TIME, names_in
from nrp_core.network.equations.model import INPUT, Model, Variable

_LEAST: Final = 1e-4
"""The least part of a bracket that a sub-step takes or leaves."""


def begun(model: Model) -> Iterator[str]:
    """Yield the lines for the ``share`` of the bracket, ``between``, that a new sub-step takes."""
    distance = _distance(model)
    yield "share = 0.5"
    if distance is None:
        return
    yield from needed([distance], model)
    yield f"below = {source_of(distance, model)}"
    yield "if between < inf:"
    yield from (f"    {line}" for line in [*_share(), "above *= 0.5"])


def crossed(model: Model) -> Iterator[str]:
    """Yield the lines for the share after a sub-step that crosses."""
    distance = _distance(model)
    if distance is None:
        yield "share = 0.5"
        return
    yield f"above = {source_of(distance, model, 'y_')}"
    yield from _share()
    yield "below *= 0.5"


def _share() -> Iterator[str]:
    yield "share = below / (below - above)"
    yield f"share = min(max(share, {_LEAST!r}), {1.0 - _LEAST!r}) if below < 0.0 < above else 0.5"


def _distance(model: Model) -> ast.expr | None:
    """Return an expression that is negative below the threshold and positive above it."""
    if model.is_random:
        return None
    match model.threshold:
        case ast.Compare(left=left, ops=[ast.Gt() | ast.GtE()], comparators=[right]):
            return ast.BinOp(left, ast.Sub(), right)
        case ast.Compare(left=left, ops=[ast.Lt() | ast.LtE()], comparators=[right]):
            return ast.BinOp(right, ast.Sub(), left)
    return None


_NARROW: Final = 1e-7
"""Width, in steps of the grid, within which a crossing is located."""
_SHORTEST: Final = 1e-12
_FOLLOWED: Final = 0.9**5
"""The error, in units of the tolerance, after which the next sub-step may be as long."""
_OF_ALL: Final = "slopes"
_OF_FEW: Final = "slopes_of_few"


def slopes(model: Model) -> str:
    """Return the functions that compute derivatives: of the commonly integrated variables, and of all."""
    of_all = {name: model.variables[name] for name in _integrated(model)}
    parts = {_OF_ALL: (of_all, "inlined"), _OF_FEW: (model.variables, "jit")}
    arguments = ["t", "held", *_arguments(model, STATE)]
    return "\n\n" + "\n\n".join(
        function(name, arguments, _slopes(model, variables), kind)
        for name, (variables, kind) in parts.items()
    )


def _slopes(model: Model, variables: Mapping[str, Variable]) -> Iterator[str]:
    model = _without_divisions(model)
    rates = {name: model.variables[name].rate for name in variables}
    yield from needed(rates.values(), model)
    for name, variable in variables.items():
        rate = source_of(rates[name], model)
        yield f"rate_{name} = " + (f"0.0 if held else {rate}" if variable.held else rate)
    yield "return " + ", ".join(f"rate_{name} + 0.0" for name in variables) + ","


def _without_divisions(model: Model) -> Model:
    """Return the equations with factors ``1 / x`` in place of divisions by parameters.

    A division takes as long as ten products, but these are computed once for all cells and stages.
    """
    change = _Reciprocal(model.parameters)
    variables = {name: replace(v, rate=change.of(v.rate)) for name, v in model.variables.items()}
    definitions = {name: change.of(node) for name, node in model.definitions.items()}
    return replace(model, variables=variables, definitions=definitions)


class _Reciprocal(ast.NodeTransformer):
    def __init__(self, parameters: Iterable[str]) -> None:
        self._constant = {*parameters} - {INPUT}

    def of(self, node: ast.expr) -> ast.expr:
        """Return a changed copy of an expression."""
        changed: ast.expr = self.visit(deepcopy(node))
        return changed

    def visit_BinOp(self, node: ast.BinOp) -> ast.BinOp:
        self.generic_visit(node)
        if isinstance(node.op, ast.Div) and self._constant.issuperset(names_in(node.right)):
            return ast.BinOp(node.left, ast.Mult(), ast.BinOp(ast.Constant(1.0), ast.Div(), node.right))
        return node


def _integrated(model: Model) -> list[str]:
    """Return the variables that all cells integrate; the others are linear and have propagators."""
    known = propagated(model).variables
    return [name for name in model.variables if name not in known]


def attempted(model: Model, *, driven: bool) -> Iterator[str]:
    """Yield the lines by which a cell attempts a whole step, and finds whether it has ``done`` that."""
    yield from _begun(model, driven=driven)
    yield from (_driven if driven else _followed)(model)
    if not model.is_random:  # else it is tested once in a step of the grid
        held = "held or " if tested_again(model) else ""
        yield from needed([model.threshold], model, "y_")
        yield f"done = done and ({held}not ({source_of(model.threshold, model, 'y_')}))"
    yield from (f"{STATE}{name} = y_{name} if done else {STATE}{name}" for name in model.variables)
    yield f"later = 0.0 if rest - h < {_SHORTEST} * h else rest - h"
    yield "rest = later if done else rest"
    if not driven:
        yield "wanted = h if done else wanted"
    yield "mark = -1.0 if not done else " + ("0.0" if model.lasts else "2.0 if held else 0.0")
    yield "held = " + ("rest > 0.0" if model.lasts else "mark >= 2.0")
    yield "spiked = False"


def changed(model: Model, *, driven: bool) -> list[str]:
    """Return the names of the variables that an attempt changes."""
    return [name for name in kept(model) if not (driven and name == "wanted")]


def tested_again(model: Model) -> bool:
    """Return whether a cell below threshold at the end of a step can reach it afterwards.

    It cannot if neither an arriving spike nor a refractory cell changes the variables that it depends on.
    """
    waiting, met = [model.threshold], set[str]()
    while waiting:
        names = {*names_in(waiting.pop())} - met
        met |= names
        waiting += [model.definitions[name] for name in names & model.definitions.keys()]
    effects = {effect.variable for effect in model.receptors.values()} | {name for name, _ in model.on_step}
    free = {name for name, variable in model.variables.items() if not variable.held or name in effects}
    return model.is_random or not model.lasts or not met.isdisjoint({TIME, *free})


def regime(model: Model) -> Iterator[str]:
    """Yield the lines that find the regime of a cell at the end of a step; the mark is 1 after a spike.

    With a condition for the refractory period it is also 2 higher if that held in the last sub-step.
    """
    yield "left = 0.0"
    yield "held = " + ("rest > 0.0" if model.lasts else "mark >= 2.0")
    yield "spiked = mark == 1.0 or mark == 3.0"


def fire(model: Model) -> Iterator[str]:
    """Yield the lines for a spike; the cell is refractory at least until the next grid point."""
    yield from reset(model)
    if model.lasts:
        yield from needed([model.refractory], model)
        yield f"rest = max({source_of(model.refractory, model)}, left)"


def _begun(model: Model, *, driven: bool) -> Iterator[str]:
    """Yield the beginning of a sub-step as long as the step."""
    yield "t = step * h - h"
    if model.lasts:
        yield "held = rest > 0.0"
        yield "done = not held or rest >= h"
    else:
        yield from needed([model.refractory], model)
        yield f"held = {source_of(model.refractory, model)}"
        yield "done = True"
    if not driven:
        yield "done = done and (wanted <= 0.0 or wanted >= h)"


def _followed(model: Model) -> Iterator[str]:
    """Yield the lines of Runge-Kutta."""
    integrated, elements = _integrated(model), elements_of(model)
    yield from _slopes_of(1, "t", STATE, model, integrated, _OF_ALL)
    for stage in range(1, STAGES):
        for name, row in elements[Course(float(NODES[stage]))].items():
            yield f"y_{name} = {product(row)}"
        yield from _stage(stage, "h", model, integrated, _OF_ALL)
    for name in integrated:
        variable = model.variables[name]
        yield f"done = done and {_error(name, 'h')} <= {_FOLLOWED!r} * ({_allowed(variable)})"


def _driven(model: Model) -> Iterator[str]:
    """Yield the lines of the Magnus expansion."""
    yield from driven_step(model)
    yield from driven_test(model)


def divide(model: Model, load: Sequence[str], ended: Sequence[str]) -> Iterator[str]:
    """Yield the lines that divide the step of the cells that must.

    Args:
        model: the cell.
        load: the lines that load it.
        ended: the lines for the end of the step, at which spikes arrive.
    """
    mark = f"{every('mark')}[i]"
    skipped = [f"if {mark} >= 0.0:", "    continue"]
    lines = [*skipped, *load, *_divided(model), *regime(model), *ended]
    yield from searched([f"due |= {mark} < 0.0"], lines)
    yield "return n_fired"


def _divided(model: Model) -> Iterator[str]:
    """Yield the lines that advance a cell by a step of the grid; they return a cell that cannot."""
    yield "left, between, above, spiked = h, inf, 0.0, False"
    yield "wanted = h if wanted <= 0.0 else wanted"
    yield "while left > 0.0:"
    yield from indented(_sub_step(model))
    yield "if left < 0.0:"
    yield "    return -1 - i"
    yield "mark = (1.0 if spiked else 0.0)" + ("" if model.lasts else " + (2.0 if held else 0.0)")


def _sub_step(model: Model) -> Iterator[str]:
    yield "t = step * h - left"
    if model.lasts:
        yield "held = rest > 0.0"
        yield "longest = min(left, rest) if held else left"
    else:
        yield from needed([model.refractory], model)
        yield f"held = spiked or ({source_of(model.refractory, model)})"
        yield "longest = left"
    yield "length = min(wanted, longest)"
    yield from begun(model)
    yield "if between < inf:"
    yield f"    length = min(length, between if between < {_NARROW} * h else share * between)"
    yield from _slopes_of(1, "t", STATE, model, model.variables, _OF_FEW)
    yield "while True:"
    yield from indented(_tried(model))
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
    yield "    spiked = True"
    yield from indented(fire(model))


def _tried(model: Model) -> Iterator[str]:
    """Yield a sub-step of a length; it is repeated with a shorter one or leaves the loop."""
    for stage in range(1, STAGES):
        yield from _stage(stage, "length", model, model.variables, _OF_FEW)
    yield "error = 0.0"
    for name, variable in model.variables.items():
        yield f"one = {_error(name, 'length')} / ({_allowed(variable)})"
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
    if not model.is_random:
        yield "if not held and not spiked:"
        yield from indented(needed([model.threshold], model, "y_"))
        yield f"    crossed = {source_of(model.threshold, model, 'y_')}"
    yield f"if crossed and length > {_NARROW} * h:"
    yield "    between = length"
    yield from indented(crossed(model))
    yield "    length *= share"
    yield "    continue"
    yield "break"


def _stage(stage: int, length: str, model: Model, names: Iterable[str], of: str) -> Iterator[str]:
    """Yield a later stage of a sub-step, for variables; the last one is at its end."""
    for name in names:
        yield f"y_{name} = fma({length}, {_sum(WEIGHTS[stage].tolist()[:stage], name)}, {STATE}{name})"
    yield from _slopes_of(stage + 1, f"t + {float(NODES[stage])!r} * {length}", "y_", model, names, of)


def _slopes_of(stage: int, t: str, state: str, model: Model, names: Iterable[str], of: str) -> Iterator[str]:
    into = ", ".join(f"k{stage}_{name}" for name in names)
    yield f"({into},) = {of}({t}, held, {', '.join(_arguments(model, state))})"


def _arguments(model: Model, state: str) -> list[str]:
    return [*(state + name for name in model.variables), *(PARAMETER + name for name in model.parameters)]


def _error(name: str, length: str) -> str:
    return f"abs({length} * ({_sum(ERROR.tolist(), name)}))"


def _allowed(variable: Variable) -> str:
    return f"{TOLERANCE!r} * ({scale_of(variable)!r} + abs(y_{variable.name}))"


def _sum(weights: Sequence[float], name: str) -> str:
    return sum_of((repr(weight), f"k{j + 1}_{name}") for j, weight in enumerate(weights) if weight)
