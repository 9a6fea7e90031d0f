"""The tables of a page in Markdown as LaTeX, for a manuscript with the package ``booktabs``."""

from __future__ import annotations

import re
from collections.abc import Iterator

_ESCAPED = re.compile(r"[&%$#_{}~^\\]")
_SPECIAL = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
_TABLE = re.compile(r"^(\|.+\|)\n\|[-:| ]+\|\n((?:\|.+\|\n?)+)", re.MULTILINE)
_HEADING = re.compile(r"^(?:#+ |\*\*)(.+?)(?:\*\*.*)?$", re.MULTILINE)
"""A heading, or the bold text at the start of a line."""


def latex_tables(page: str) -> str:
    """Return the tables of a document, each with the heading above it as its caption."""
    return "\n".join(_tables(page))


def _tables(page: str) -> Iterator[str]:
    for table in _TABLE.finditer(page):
        above = _HEADING.findall(page, 0, table.start())
        head, *rows = (_cells(line) for line in (table[1], *table[2].splitlines()))
        lines = [" & ".join(cells) + r" \\" for cells in rows]
        yield "\n".join([
            r"\begin{table}", rf"\caption{{{_escaped(above[-1]) if above else ''}}}",
            rf"\begin{{tabular}}{{{'l' * len(head)}}}", r"\toprule", " & ".join(head) + r" \\", r"\midrule",
            *lines, r"\bottomrule", r"\end{tabular}", r"\end{table}", "",
        ])  # fmt: skip


def _cells(line: str) -> list[str]:
    return [_escaped(cell.strip().strip("`")) for cell in line.strip().strip("|").split("|")]


def _escaped(text: str) -> str:
    return _ESCAPED.sub(lambda found: _SPECIAL.get(found[0], f"\\{found[0]}"), text)
