"""The numbers in files of transfer functions: constants of Python, gains of BIBI models."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from xml.parsers.expat import ExpatError, ParserCreate

from nrp_cockpit.session.functions import LANGUAGES


@dataclass(frozen=True, slots=True)
class Number:
    """A number that can be changed.

    Args:
        name: its name.
        value: its value; None: cells have different ones.
        low, high: the ends of its slider; values beyond them are possible.
        whole: whether it is an integer.
        note: its unit, or the text of its comment.
    """

    name: str
    value: float | None
    low: float
    high: float
    whole: bool = False
    note: str = ""

    @classmethod
    def around(cls, name: str, value: float, *, whole: bool = False, note: str = "") -> Number:
        """Return a number with its present value in the middle of the slider, and 0 at one end."""
        half = abs(value) or 1.0
        return cls(name, value, value - half, value + half, whole, note)


@dataclass(frozen=True, slots=True)
class Constant:
    """A number in a file, and its place.

    Args:
        number: the number.
        line: its line, counted from 0.
        begin, end: the bytes of the line in which it is.
    """

    number: Number
    line: int
    begin: int
    end: int

    def with_value(self, text: str, value: float) -> str:
        """Return the text with another value."""
        lines = text.split("\n")
        line = lines[self.line].encode()
        written = str(round(value)) if self.number.whole else repr(float(value))
        lines[self.line] = (line[: self.begin] + written.encode() + line[self.end :]).decode()
        return "\n".join(lines)


def constants_of(file: str, text: str) -> Iterator[Constant]:
    """Yield the numbers of a file: those that Python names at its top level, or the gains of a model.

    Args:
        file: its name; the suffix gives the language.
        text: its text; a broken one has no numbers.
    """
    return _of_python(text) if LANGUAGES.get(Path(file).suffix) == "python" else _of_model(text)


def _of_python(text: str) -> Iterator[Constant]:
    try:
        body = ast.parse(text).body
    except (SyntaxError, ValueError):
        return
    lines = text.split("\n")
    for statement in body:
        match statement:
            case (
                ast.Assign(targets=[ast.Name(id=name)], value=node)
                | ast.AnnAssign(target=ast.Name(id=name), value=ast.expr() as node)
            ):
                value = _number(node)
                if value is None or node.end_lineno != node.lineno:
                    continue
                at = node.lineno - 1
                begin, end = node.col_offset, node.end_col_offset or 0
                note = lines[at].encode()[end:].decode().strip().removeprefix("#").strip()
                number = Number.around(name, value, whole=isinstance(value, int), note=note)
                yield Constant(number, at, begin, end)


def _number(node: ast.expr) -> float | int | None:
    """Return the number that an expression is, with or without a sign."""
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return value
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=int() | float() as value)):
            return None if isinstance(value, bool) else -value
    return None


_GAINS = {"Scale": "factor", "Constant": "value"}
"""The attribute with the number, by the type of an expression."""
_TYPE = "http://www.w3.org/2001/XMLSchema-instance}type"


def _of_model(text: str) -> Iterator[Constant]:
    """Yield the gains and the constants other than 0 of a BIBI model, named by the part that they are in."""
    found: list[tuple[str, str, str, int]] = []
    names: list[str] = []
    data = text.encode()
    parser = ParserCreate("utf-8", namespace_separator="}")

    def begin(_tag: str, attributes: dict[str, str]) -> None:
        names.append(attributes.get("name", ""))
        kind = attributes.get(_TYPE, "")
        if kind in _GAINS:
            owner = ".".join(dict.fromkeys(filter(None, names[:-1])))
            found.append((owner, _GAINS[kind], attributes.get(_GAINS[kind], ""), parser.CurrentByteIndex))

    parser.StartElementHandler = begin
    parser.EndElementHandler = lambda _tag: names.pop()
    with suppress(ExpatError):
        parser.Parse(data, True)
        counts = Counter[str]()
        for owner, attribute, written, tag in found:
            place = re.compile(rb"""\b%s\s*=\s*["']""" % attribute.encode()).search(data, tag)
            value = _float(written)
            if place is None or not value:
                continue
            counts[owner] += 1
            name = owner if counts[owner] == 1 else f"{owner} {counts[owner]}"
            line = data.count(b"\n", 0, place.end())
            begins = place.end() - (data.rfind(b"\n", 0, place.end()) + 1)
            number = Number.around(name, value, note=attribute)
            yield Constant(number, line, begins, begins + len(written.encode()))


def _float(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
