"""Text that may be broken into lines, after Oppen and Wadler (A prettier printer, 2003)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

INDENT = 4


@dataclass(frozen=True, slots=True)
class Line:
    """A possible line break; ``flat`` is the text where the line is not broken."""

    flat: str = ""


@dataclass(frozen=True, slots=True)
class IfBroken:
    """A text that is written only if the group around it is broken."""

    text: str


@dataclass(frozen=True, slots=True)
class Group:
    """A part with all of its lines broken, or none."""

    inner: Document


@dataclass(frozen=True, slots=True)
class Indented:
    """A part whose new lines are indented."""

    inner: Document


Document: TypeAlias = "str | Line | IfBroken | Group | Indented | Sequence[Document]"


def bracketed(left: str, inner: Document, right: str) -> Group:
    """Return a part in brackets, on lines of its own if it does not fit."""
    return Group([left, Indented([Line(), inner]), Line(), right])


def separated(parts: Sequence[Document]) -> Group:
    """Return parts separated by commas; if they do not fit, one a line with a trailing comma."""
    return Group([*_joined(parts), IfBroken("," if len(parts) > 1 else "")])


def collected(left: str, parts: Sequence[Document], right: str) -> Group:
    """Return a literal of parts in brackets; if it does not fit, each part has its own line."""
    return Group([left, Indented([Line(), *_joined(parts), IfBroken(",")]), Line(), right])


def _joined(parts: Sequence[Document]) -> list[Document]:
    joined: list[Document] = []
    for i, part in enumerate(parts):
        joined += [",", Line(" "), part] if i else [part]
    return joined


def rendered(document: Document, width: float, column: int = 0, indent: int = 0) -> str:
    """Return the text of a document.

    Args:
        document: the document.
        width: the maximum length of a line.
        column: the column at which the text begins.
        indent: the indentation of lines.
    """
    out: list[str] = []
    at = column
    todo: list[_Item] = [(indent, True, document)]
    while todo:
        indent, broken, part = todo.pop()
        match part:
            case Group(inner):
                fits = _fits(inner, todo, width - at)
                todo.append((indent, not fits, inner))
            case Line() if broken:
                out.append("\n" + " " * indent)
                at = indent
            case str() | Line() | IfBroken():
                text = _flat(part, broken)
                out.append(text)
                at += len(text)
            case Indented(inner):
                todo.append((indent + INDENT, broken, inner))
            case _:
                todo.extend((indent, broken, one) for one in reversed(part))
    return "".join(out)


_Item: TypeAlias = tuple[int, bool, Document]


def _fits(document: Document, rest: Sequence[_Item], room: float) -> bool:
    """Return whether a document fits on one line, with the text after it up to the next line break."""
    todo: list[tuple[bool, Document]] = [(broken, part) for _, broken, part in rest]
    todo.append((False, document))
    while todo and room >= 0:
        broken, part = todo.pop()
        match part:
            case Line() if broken:
                return True
            case str() | Line() | IfBroken():
                room -= len(_flat(part, broken))
            case Group(inner) | Indented(inner):
                todo.append((broken, inner))
            case _:
                todo.extend((broken, one) for one in reversed(part))
    return room >= 0


def _flat(part: str | Line | IfBroken, broken: bool) -> str:
    match part:
        case Line(flat):
            return flat
        case IfBroken(text):
            return text if broken else ""
        case _:
            return part
