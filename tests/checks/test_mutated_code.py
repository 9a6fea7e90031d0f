"""Files of functions that work, broken by machine at one place each: no slip of writing is silent."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Level

Edit = tuple[ast.AST, str]
"""A part of a file and the text in its place."""


def swapped(word: str) -> str:
    """Return a word with two letters exchanged, or with one letter more."""
    for i, (one, other) in enumerate(pairwise(word)):
        if one != other and (one + other).isalpha():
            return word[:i] + other + one + word[i + 2 :]
    return word + "x"


def edits(tree: ast.Module) -> Iterator[tuple[str, Edit]]:
    """Yield misspelt names, attributes, arguments and texts, calls without parentheses, and None."""
    for node in ast.walk(tree):
        match node:
            case ast.Name(name):
                yield "name", (node, swapped(name))
            case ast.Attribute(value, name):
                yield "attribute", (node, f"({ast.unparse(value)}).{swapped(name)}")
            case ast.Constant(str(text)) if text:
                yield "text", (node, repr(swapped(text)))
            case ast.Call(function, arguments, keywords):
                yield "call", (node, ast.unparse(function))
                for place, keyword in enumerate(keywords):
                    others = [*keywords[:place], ast.keyword(swapped(str(keyword.arg)), keyword.value)]
                    yield "keyword", (node, ast.unparse(ast.Call(function, arguments, others)))
        if isinstance(node, ast.BinOp):
            for side in (node.left, node.right):
                yield "None", (side, "None")


def changed(text: str, node: ast.AST, new: str) -> str:
    """Return a text with a part of its tree replaced."""
    lines = text.splitlines(keepends=True)
    starts = [sum(map(len, lines[:i])) for i in range(len(lines))]
    first = starts[node.lineno - 1] + node.col_offset
    last = starts[node.end_lineno - 1] + node.end_col_offset
    return f"{text[:first]}{new}{text[last:]}"


@pytest.mark.parametrize("file", ["listing1.py", "listing2.py"])
def test_no_slip_of_writing_is_silent(functions: Path, file: str) -> None:
    path = functions.parent / file
    text = path.read_text()
    known = {str(one) for one in validate_file(functions)}
    tried, silent = 0, []
    for number, (kind, (node, new)) in enumerate(edits(ast.parse(text))):
        if number % 3:  # a third of them takes seconds
            continue
        path.write_text(changed(text, node, new))
        tried += 1
        found = [one for one in validate_file(functions) if one.level is not Level.NOTE]
        if not any(str(one) not in known for one in found):
            silent.append((kind, node.lineno, new))
    assert (silent, tried >= 20) == ([], True)
