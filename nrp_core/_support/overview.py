"""Objects of which a shell shows one line, and a notebook a table."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from itertools import islice
from typing import TypeAlias

_MAX_ROWS = 50
Row: TypeAlias = tuple[object, ...]


class Overview:
    """Has a short text for shells and a table for notebooks."""

    __slots__ = ()

    def _overview(self) -> tuple[str, Iterable[Row]]:
        """Return a line about the object, and the rows of a table of its parts, the titles first."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._overview()[0]}>"

    def _repr_html_(self) -> str:
        line, rows = self._overview()
        shown = list(islice(rows, _MAX_ROWS + 2))
        more = "".join(_row(("...",), "td") for _ in shown[_MAX_ROWS + 1 :])
        body = "".join(_row(row, "td") for row in shown[1 : _MAX_ROWS + 1])
        head = "".join(_row(row, "th") for row in shown[:1])
        return (
            f"<div><b>{type(self).__name__}</b> {escape(line)}"
            f"<table><thead>{head}</thead><tbody>{body}{more}</tbody></table></div>"
        )


def _row(cells: Row, tag: str) -> str:
    return f"<tr>{''.join(f'<{tag}>{escape(str(cell))}</{tag}>' for cell in cells)}</tr>"


def counted(n: int, noun: str) -> str:
    """Return a number with its noun."""
    return f"{n} {noun}{'' if n == 1 else 's'}"
