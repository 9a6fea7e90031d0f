"""Reads the common parts of cells and synapses in equations: names, parameters, rates, assignments."""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from keyword import iskeyword
from typing import Final, NamedTuple, NoReturn

from nrp_core.errors import did_you_mean
from nrp_core.network.equations.expressions import (
    CONSTANTS,
    RESERVED,
    TIME,
    TRUTH,
    TextOrigin,
    names_in,
    parsed,
    require_ascii,
    require_dimension,
    require_known,
    resolved,
)
from nrp_core.network.equations.model import Variable
from nrp_core.units import (
    NONE,
    SECOND,
    Dimension,
    Unit,
    as_unit,
    times,
    unit_of,
    units,
)

_DERIVATIVE: Final = re.compile(r"d\s*(\w+)\s*/\s*dt\s*=\s*(.*)", re.DOTALL)
_DEFINITION: Final = re.compile(r"(\w+)\s*=(?!=)\s*(.*)", re.DOTALL)
_NAME: Final = re.compile(r"\w+")
_BEGINS: Final = re.compile(r"\s*(d\s*\w+\s*/\s*dt\s*=|\w+\s*=(?!=)|\w+\s*:)")
_UNIT: Final = re.compile(r"([^()#]*?)\s*(?:\(([^()]*)\))?\s*\Z")
_HELD: Final = "unless refractory"
OF_CELLS: Final = (_HELD,)
"""The flags of state variables of cells."""
OF_SYNAPSES: Final = ("event-driven",)
_OTHERS: Final = ("constant", "shared")
_RECORDED: Final = "recorded"


@dataclass(frozen=True, slots=True)
class Line:
    """One equation.

    Args:
        name: the name that it defines.
        unit: its unit.
        place: its place in the source.
        expression: the right side; None for a parameter.
        is_derivative: whether the right side is the derivative.
        held: whether the variable stays while the cell is refractory.
        recorded: whether an expression with a name can be recorded.
    """

    name: str
    unit: Unit
    place: TextOrigin
    expression: str | None = None
    is_derivative: bool = False
    held: bool = False
    recorded: bool = False


def lines_of(text: str, kind: str, flags: tuple[str, ...]) -> list[Line]:
    """Return the equations in a text; the first line that is not empty is line 1.

    Args:
        text: the text.
        kind: the kind of object that it describes, by its name in scripts.
        flags: the valid flags of state variables.

    Raises:
        NetworkError: a line is not an equation with a unit.
    """
    found: list[Line] = []
    pending, begun = "", 0
    for number, row in enumerate(text.strip("\n").splitlines(), 1):
        row = row.partition("#")[0].rstrip()
        if not row.strip():
            continue
        if pending and _BEGINS.match(row):
            _refuse_without_unit(TextOrigin("equations", pending, begun, kind))
        begun = begun if pending else number
        pending = f"{pending} {row.strip()}".strip()
        if ":" in pending:
            found.append(_line(pending, TextOrigin("equations", pending, begun, kind), flags))
            pending = ""
    if pending:
        _refuse_without_unit(TextOrigin("equations", pending, begun, kind))
    return found


def _refuse_without_unit(place: TextOrigin) -> None:
    require_ascii(place)
    place.refuse("its unit is missing at the end, e.g. ': mV', or ': 1' for a number without a unit")


def _line(text: str, place: TextOrigin, of_variables: tuple[str, ...]) -> Line:
    require_ascii(place)
    left, _, right = text.partition(":")
    left = left.strip()
    derivative, definition = _DERIVATIVE.fullmatch(left), _DEFINITION.fullmatch(left)
    matched = derivative or definition
    if matched is None and not _NAME.fullmatch(left):
        place.refuse("it is not an equation, e.g. 'dv/dt = (v_rest - v)/tau : mV' or 'I = ge + gi : nA'")
    of_definitions = (*_OTHERS, _RECORDED) if definition is not None and of_variables is OF_CELLS else _OTHERS
    if derivative is None and _HELD in right:
        place.refuse(
            f"the flag '{_HELD}' is one of a state variable, whose equation begins with its derivative, "
            "e.g. 'dv/dt = ...'"
        )
    unit, flags = _unit(right, place, of_variables if derivative is not None else of_definitions)
    if matched is None:
        return Line(left, unit, place)
    name, expression = matched.groups()
    return Line(name, unit, place, expression, derivative is not None, _HELD in flags, _RECORDED in flags)


def _unit(text: str, place: TextOrigin, valid: tuple[str, ...]) -> tuple[Unit, list[str]]:
    match = _UNIT.fullmatch(text.strip())
    if match is None:
        place.refuse(f"'{text.strip()}' is not a unit, and flags in parentheses")
    written, flags = match.group(1), [one.strip() for one in (match.group(2) or "").split(",") if one.strip()]
    for flag in flags:
        if flag not in valid:
            place.refuse(f"the flag '{flag}' has no meaning here; valid: {', '.join(valid)}")
    try:
        return unit_of(written), flags
    except ValueError as error:
        place.refuse(str(error))


_ASSIGNMENT: Final = re.compile(r"\s*(\w+)\s*([-+*/]?)=(?!=)\s*(.*)", re.DOTALL)
_OPERATORS: Final = {"+": ast.Add(), "-": ast.Sub(), "*": ast.Mult(), "/": ast.Div()}
Assignments = tuple[tuple[str, ast.expr], ...]
"""Names and their new values, one after the other."""


class Names(NamedTuple):
    """The dimension of every name, and the names that spikes and equations define."""

    dimensions: Mapping[str, Dimension]
    constant: frozenset[str]
    """Those whose value does not change while the network runs."""


def parameters_of(given: Mapping[str, str], lines: list[Line], kind: str) -> dict[str, Unit]:
    """Return the units of all parameters, those of `parameters` and those declared among the equations.

    Args:
        given: the units as written, by name.
        lines: the equations.
        kind: the kind of object that they describe, by its name in scripts.

    Raises:
        NetworkError: a unit is wrong, or a parameter has no value.
    """
    found = {}
    for name, text in given.items():
        place = TextOrigin("parameters", f"{name}: {text}", kind=kind)
        require_ascii(place)
        try:
            found[name] = unit_of(text)
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
                f"parameter '{line.name}' is declared in {as_unit(line.unit.dimension)}, but its value in "
                f"`parameters` is in {as_unit(found[line.name].dimension)}"
            )
    return found


def names_of(lines: list[Line], parameters: Mapping[str, Unit], given: Mapping[str, str], kind: str) -> Names:
    """Return the names in equations.

    Args:
        lines: the equations.
        parameters: the units of parameters.
        given: these as written.
        kind: the kind of object that the equations describe, by its name in scripts.

    Raises:
        NetworkError: a name is reserved or defined twice.
    """
    dimensions = {name: unit.dimension for name, unit in units().items() if len(name) > 1}
    dimensions |= dict.fromkeys(("pi", "e"), NONE) | {
        "inf": NONE,
        "True": TRUTH,
        "False": TRUTH,
        TIME: SECOND,
    }
    for name, unit in parameters.items():
        _require_free(name, TextOrigin("parameters", f"{name}: {given[name]}", kind=kind))
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
    return Names(dimensions, frozenset(dimensions.keys() - own.keys() - {TIME}))


def _require_free(name: str, place: TextOrigin) -> None:
    if name in RESERVED:
        meaning = "a constant" if name in CONSTANTS else "the time" if name == TIME else "a name of equations"
        place.refuse(f"'{name}' is reserved, it is {meaning}; choose another name")
    if not name.isidentifier() or iskeyword(name):
        place.refuse(f"'{name}' cannot be a name; names have letters, digits and _, as in tau_m")


def variables_of(lines: list[Line], names: Names, own: set[str]) -> dict[str, Variable]:
    """Return the state variables.

    Raises:
        NetworkError: a derivative is wrong.
    """
    return {
        line.name: Variable(line.name, line.unit, resolved(_rate(line, names), own), line.held, line.place)
        for line in lines
        if line.is_derivative
    }


def expression(
    text: str, place: TextOrigin, names: Names, dimension: Dimension, what: str, *, random: bool = False
) -> ast.expr:
    """Return an expression of known names that has a dimension.

    Args:
        text: the expression.
        place: its place in the source.
        names: the known names.
        dimension: its dimension.
        what: its kind, for the message.
        random: whether it may have a random number.

    Raises:
        NetworkError: it is not one.
    """
    found = parsed(text, place, random=random)
    require_known(found, names.dimensions, place)
    require_dimension(found, names.dimensions, place, dimension, what)
    return found


def _rate(line: Line, names: Names) -> ast.expr:
    assert line.expression is not None
    rate = times(line.unit.dimension, SECOND, -1)
    return expression(line.expression, line.place, names, rate, f"d{line.name}/dt")


def definitions_of(lines: list[Line], names: Names) -> dict[str, ast.expr]:
    """Return the expressions with a name, each after those that it needs.

    Raises:
        NetworkError: one is wrong, or needs its own value.
    """
    found, places = {}, {}
    for line in lines:
        if line.expression is not None and not line.is_derivative:
            found[line.name] = expression(
                line.expression, line.place, names, line.unit.dimension, f"'{line.name}'"
            )
            places[line.name] = line.place
    needs = {name: [other for other in names_in(node) if other in found] for name, node in found.items()}
    try:
        return {name: found[name] for name in TopologicalSorter(needs).static_order()}
    except CycleError as error:
        circle = error.args[1]
        places[circle[0]].refuse(f"'{circle[0]}' needs its own value: {' <- '.join(circle)}")


def assignments_of(
    text: str, where: str, kind: str, targets: Mapping[str, Dimension], names: Names
) -> list[tuple[str, ast.expr]]:
    """Return assignments on lines or divided by ``;``.

    Args:
        text: the text.
        where: the argument that has it.
        kind: the kind of its owner, by its name in scripts.
        targets: the names that may change, and their dimensions.
        names: all names.

    Raises:
        NetworkError: one is wrong.
    """
    found = []
    for number, row in enumerate(re.split(r"[;\n]", text), 1):
        row = row.partition("#")[0].strip()
        if row:
            place = TextOrigin(where, row, number if "\n" in text.strip() else 0, kind)
            name, value = assignment(row, place, targets, names)
            require_dimension(value, names.dimensions, place, targets[name], f"'{name}'")
            found.append((name, value))
    return found


def assignment(
    text: str, place: TextOrigin, targets: Mapping[str, object], names: Names
) -> tuple[str, ast.expr]:
    """Return the name that an assignment changes, and its new value.

    Raises:
        NetworkError: it is wrong.
    """
    require_ascii(place)
    match = _ASSIGNMENT.fullmatch(text)
    if match is None:
        place.refuse("it is not an assignment, e.g. 'v = v_reset' or 'w += b'")
    name, sign, right = match.groups()
    if name not in targets:
        _refuse_target(name, place, targets, names)
    value = parsed(right, place)
    require_known(value, names.dimensions, place)
    return name, ast.BinOp(ast.Name(name), _OPERATORS[sign], value) if sign else value


def _refuse_target(name: str, place: TextOrigin, targets: Mapping[str, object], names: Names) -> NoReturn:
    if name in names.dimensions:
        place.refuse(
            f"'{name}' is not a state variable, so it does not change; one that only changes at spikes is "
            f"'d{name}/dt = 0*... : ...'"
        )
    place.refuse(f"unknown name '{name}'{did_you_mean(name, targets)}")
