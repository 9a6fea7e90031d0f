"""Text that may be broken into lines, after Oppen and Wadler (A prettier printer, 2003)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

INDENT = 4


@dataclass(frozen=True, slots=True)
class Line:
    """A place where a line may end; else ``flat`` stands there."""

    flat: str = ""


@dataclass(frozen=True, slots=True)
class IfBroken:
    """A text that stands only where the group around it is broken."""

    text: str


@dataclass(frozen=True, slots=True)
class Group:
    """A part whose lines are broken all or not at all."""

    inner: Document


@dataclass(frozen=True, slots=True)
class Indented:
    """A part whose new lines begin deeper."""

    inner: Document


Document: TypeAlias = "str | Line | IfBroken | Group | Indented | Sequence[Document]"


def bracketed(left: str, inner: Document, right: str) -> Group:
    """Return a part in brackets, on lines of its own where it does not fit."""
    return Group([left, Indented([Line(), inner]), Line(), right])


def separated(parts: Sequence[Document]) -> Group:
    """Return parts with commas between; where they do not fit, one a line and a comma after the last."""
    return Group([*_joined(parts), IfBroken("," if len(parts) > 1 else "")])


def collected(left: str, parts: Sequence[Document], right: str) -> Group:
    """Return a literal of parts in brackets; where it does not fit, each part has its line."""
    return Group([left, Indented([Line(), *_joined(parts), IfBroken(",")]), Line(), right])


def _joined(parts: Sequence[Document]) -> list[Document]:
    joined: list[Document] = []
    for i, part in enumerate(parts):
        joined += [",", Line(" "), part] if i else [part]
    return joined


def rendered(document: Document, width: float, column: int = 0, indent: int = 0) -> str:
    """Return the text of a document.

    Args:
        document: what to write.
        width: the longest line there should be.
        column: where the text begins.
        indent: where lines begin.
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
    """Return whether a document fits flat, with what follows up to the next end of a line."""
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
