"""Reads the texts of a cell that is given as equations, in the notation of Brian2."""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from dataclasses import replace
from graphlib import CycleError, TopologicalSorter
from keyword import iskeyword
from typing import Final, NamedTuple, NoReturn

from nrp_core.brain.network.equations import linear
from nrp_core.brain.network.equations.dimensions import ANY, TRUTH, dimension_of, require_dimension
from nrp_core.brain.network.equations.expressions import (
    CONSTANTS,
    RESERVED,
    TIME,
    WEIGHT,
    TextOrigin,
    names_in,
    parsed,
    require_ascii,
    require_known,
    resolved,
)
from nrp_core.brain.network.equations.lines import Line, lines_of
from nrp_core.brain.network.equations.model import (
    EXACT,
    INPUT,
    METHODS,
    RUNGE_KUTTA,
    Effect,
    Model,
    Texts,
    Variable,
)
from nrp_core.brain.network.equations.units import (
    AMPERE,
    NONE,
    SECOND,
    Dimension,
    Unit,
    described,
    quantity,
    times,
    unit_of,
    units,
)
from nrp_core.errors import did_you_mean

RECEPTORS: Final = ("excitatory", "inhibitory")
_ASSIGNMENT: Final = re.compile(r"\s*(\w+)\s*([-+*/]?)=(?!=)\s*(.*)", re.DOTALL)
_OPERATORS: Final = {"+": ast.Add(), "-": ast.Sub(), "*": ast.Mult(), "/": ast.Div()}


class _Names(NamedTuple):
    """The dimension of every name, and the names that spikes and equations define."""

    dimensions: Mapping[str, Dimension]
    constant: frozenset[str]
    """Those whose value does not change while a cell runs."""


def read(texts: Texts) -> Model:
    """Return the meaning of the texts of a cell.

    Raises:
        NetworkError: a mistake, with its line.
    """
    lines = lines_of(texts.equations)
    parameters = _parameters(texts, lines)
    names = _names(lines, parameters, texts)
    own = {*parameters, *(line.name for line in lines)}
    variables = {
        line.name: Variable(line.name, line.unit, resolved(_rate(line, names), own), line.held, line.place)
        for line in lines
        if line.is_derivative
    }
    if not variables:
        TextOrigin("equations", texts.equations).refuse(
            "there is no state variable, e.g. 'dv/dt = -v/tau : mV'"
        )
    definitions = {name: resolved(node, own) for name, node in _definitions(lines, names).items()}
    if not texts.threshold.strip():
        TextOrigin("threshold", "").refuse("a cell needs a threshold, e.g. threshold='v > v_thresh'")
    threshold = _expression(
        texts.threshold, TextOrigin("threshold", texts.threshold), names, TRUTH, "a threshold"
    )
    refractory, lasts = _refractory(texts.refractory, names)
    reset = tuple((name, resolved(value, own)) for name, value in _reset(texts.reset, variables, names))
    effects = _receptors(texts.receptors, variables, names)
    receptors = {name: replace(one, factor=resolved(one.factor, own)) for name, one in effects.items()}
    model = Model(
        variables, definitions, parameters, resolved(threshold, own), reset, resolved(refractory, own), lasts,
        receptors, RUNGE_KUTTA,
    )  # fmt: skip
    return replace(model, method=_method(texts.method, model))


def _parameters(texts: Texts, lines: list[Line]) -> dict[str, Unit]:
    """Return the units of all parameters, those of `parameters` and those declared among the equations."""
    found = {}
    for name, text in texts.units.items():
        place = TextOrigin("parameters", f"{name}: {text}")
        require_ascii(place)
        try:
            found[name] = unit_of(text) if text != "1" else Unit("1", 1.0, NONE)
        except ValueError as error:
            place.refuse(str(error))
    for line in lines:
        if line.expression is None and line.name not in found:
            line.place.refuse(
                f"parameter '{line.name}' has no value; write it in `parameters`, e.g. "
                f"'{line.name}': '20 {line.unit.text}'"
            )
        if line.expression is None and found[line.name].dimension != line.unit.dimension:
            line.place.refuse(
                f"parameter '{line.name}' is declared in {described(line.unit.dimension)}, but its value in "
                f"`parameters` is in {described(found[line.name].dimension)}"
            )
    if INPUT in found and found[INPUT].dimension != AMPERE:
        TextOrigin("parameters", f"{INPUT}: {found[INPUT].text}").refuse(
            f"'{INPUT}' is the injected current, in A; give another parameter another name"
        )
    return found


def _names(lines: list[Line], parameters: Mapping[str, Unit], texts: Texts) -> _Names:
    dimensions = {name: unit.dimension for name, unit in units().items() if len(name) > 1}
    dimensions |= dict.fromkeys(("pi", "e"), NONE) | {
        "inf": NONE,
        "True": TRUTH,
        "False": TRUTH,
        TIME: SECOND,
    }
    for name, unit in parameters.items():
        _require_free(name, TextOrigin("parameters", f"{name}: {texts.units[name]}"))
        dimensions[name] = unit.dimension
    own: dict[str, TextOrigin] = {}
    for line in lines:
        if line.expression is None:
            continue
        _require_free(line.name, line.place)
        if line.name in own or line.name in parameters:
            line.place.refuse(f"'{line.name}' is defined twice")
        own[line.name] = line.place
        dimensions[line.name] = line.unit.dimension
    return _Names(dimensions, frozenset(dimensions.keys() - own.keys() - {TIME}))


def _require_free(name: str, place: TextOrigin) -> None:
    if name in RESERVED:
        meaning = "a constant" if name in CONSTANTS else "the time" if name == TIME else "a name of equations"
        place.refuse(f"'{name}' is reserved, it is {meaning}; choose another name")
    if not name.isidentifier() or iskeyword(name):
        place.refuse(f"'{name}' cannot be a name; names have letters, digits and _, as in tau_m")


def _expression(text: str, place: TextOrigin, names: _Names, dimension: Dimension, what: str) -> ast.expr:
    found = parsed(text, place)
    require_known(found, names.dimensions, place)
    require_dimension(found, names.dimensions, place, dimension, what)
    return found


def _rate(line: Line, names: _Names) -> ast.expr:
    assert line.expression is not None
    rate = times(line.unit.dimension, SECOND, -1)
    return _expression(line.expression, line.place, names, rate, f"d{line.name}/dt")


def _definitions(lines: list[Line], names: _Names) -> dict[str, ast.expr]:
    """Return the expressions with a name, each after those that it needs."""
    found, places = {}, {}
    for line in lines:
        if line.expression is not None and not line.is_derivative:
            found[line.name] = _expression(
                line.expression, line.place, names, line.unit.dimension, f"'{line.name}'"
            )
            places[line.name] = line.place
    needs = {name: [other for other in names_in(node) if other in found] for name, node in found.items()}
    try:
        return {name: found[name] for name in TopologicalSorter(needs).static_order()}
    except CycleError as error:
        circle = error.args[1]
        places[circle[0]].refuse(f"'{circle[0]}' needs its own value: {' <- '.join(circle)}")


def _refractory(text: str, names: _Names) -> tuple[ast.expr, bool]:
    """Return the refractory time or condition, and whether it is a time."""
    place = TextOrigin("refractory", text)
    try:
        number, unit = quantity(text)
    except ValueError:
        node = parsed(text or "0", place)
        require_known(node, names.dimensions, place)
        found = dimension_of(node, names.dimensions, place)
        if found != TRUTH:
            require_dimension(node, names.dimensions, place, SECOND, "a refractory time")
        return node, found != TRUTH
    if unit.dimension != SECOND and number != 0.0:
        place.refuse(f"a refractory period is a time, e.g. '2 ms', not in {described(unit.dimension)}")
    if number < 0.0:
        place.refuse("a refractory period is 0 or more")
    return ast.Constant(number * unit.scale), True


def _reset(text: str, variables: Mapping[str, Variable], names: _Names) -> list[tuple[str, ast.expr]]:
    found = []
    for number, row in enumerate(re.split(r"[;\n]", text), 1):
        row = row.partition("#")[0].strip()
        if row:
            place = TextOrigin("reset", row, number if "\n" in text.strip() else 0)
            name, value = _assignment(row, place, variables, names)
            require_dimension(value, names.dimensions, place, variables[name].unit.dimension, f"'{name}'")
            found.append((name, value))
    return found


def _assignment(
    text: str, place: TextOrigin, variables: Mapping[str, Variable], names: _Names
) -> tuple[str, ast.expr]:
    """Return the variable that an assignment changes, and its new value."""
    require_ascii(place)
    match = _ASSIGNMENT.fullmatch(text)
    if match is None:
        place.refuse("it is not an assignment, e.g. 'v = v_reset' or 'w += b'")
    name, sign, right = match.groups()
    if name not in variables:
        _refuse_target(name, place, variables, names)
    value = parsed(right, place)
    require_known(value, names.dimensions, place)
    return name, ast.BinOp(ast.Name(name), _OPERATORS[sign], value) if sign else value


def _refuse_target(
    name: str, place: TextOrigin, variables: Mapping[str, Variable], names: _Names
) -> NoReturn:
    if name in names.dimensions:
        place.refuse(
            f"'{name}' is not a state variable, so it does not change; one that only changes at spikes is "
            f"'d{name}/dt = 0*... : ...'"
        )
    place.refuse(f"unknown name '{name}'{did_you_mean(name, variables)}")


def _receptors(
    texts: Mapping[str, str], variables: Mapping[str, Variable], names: _Names
) -> dict[str, Effect]:
    found = {}
    for receptor, text in texts.items():
        place = TextOrigin(f"receptor '{receptor}'", text)
        if receptor not in RECEPTORS:
            place.refuse(f"there is no receptor '{receptor}'{did_you_mean(receptor, RECEPTORS)}")
        written = text if "=" in text else f"{text} += {WEIGHT}"
        found[receptor] = _effect(written, place, variables, names)
    return found


def _effect(text: str, place: TextOrigin, variables: Mapping[str, Variable], names: _Names) -> Effect:
    target = text.partition("+")[0].strip()
    known = {**names.dimensions, WEIGHT: NONE}
    name, value = _assignment(text, place, variables, _Names(known, names.constant))
    parts = linear.coefficients_of(value, {*variables, WEIGHT}, {})
    if parts is None or WEIGHT not in parts or ast.unparse(parts.get(target, ast.Constant(0))) != "1.0":
        place.refuse(f"a spike adds to a variable in proportion to its weight, e.g. '{target} += {WEIGHT}'")
    factor = parts[WEIGHT]
    if parts.keys() != {target, WEIGHT} or not names.constant.issuperset(names_in(factor)):
        place.refuse("the effect of a spike depends on its weight and on parameters only")
    of = dimension_of(factor, known, place)
    unit = variables[name].unit
    if of not in (NONE, ANY):
        own = times(unit.dimension, of, -1)
        unit = Unit(described(own), 1.0, own)
    return Effect(name, factor, unit)


def _method(text: str, model: Model) -> str:
    if text not in ("", *METHODS):
        TextOrigin("method", text).refuse(f"there is no method '{text}'{did_you_mean(text, METHODS)}")
    curved = linear.first_curved(model)
    if text == EXACT and curved is not None:
        curved.place.refuse(
            f"d{curved.name}/dt is not linear in the state variables, so there is no exact method; leave out "
            f"`method`, or write method='{RUNGE_KUTTA}'"
        )
    return text or (EXACT if curved is None else RUNGE_KUTTA)
