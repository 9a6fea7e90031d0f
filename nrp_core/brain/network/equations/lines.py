"""Divides equations into lines: derivatives, definitions and parameters, each with its unit."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from nrp_core.brain.network.equations.expressions import TextOrigin, require_ascii
from nrp_core.brain.network.equations.units import Unit, unit_of

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
        place: where it was written.
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
        kind: what it describes, by its name in scripts.
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
