"""Names that a file gives one text or number, as in ``ERROR = 'ERROR'``."""

from __future__ import annotations

import ast
from collections import Counter
from copy import deepcopy
from typing import Final

_IS_IMPORT: Final = (ast.Import, ast.ImportFrom)


def with_constants(tree: ast.Module) -> ast.Module:
    """Return a copy of a tree with texts and numbers in the place of the names that are given them once."""
    given = Counter(_names(tree))
    known: dict[str, ast.Constant] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                known |= {name: value for name, value in _pairs(target, node.value) if given[name] == 1}
    copied: ast.Module = _Constants(known).visit(deepcopy(tree))
    return copied


def _names(tree: ast.Module) -> list[str]:
    """Return each name as often as something gives it a value."""
    nodes = list(ast.walk(tree))
    return [
        *(node.id for node in nodes if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load)),
        *(node.arg for node in nodes if isinstance(node, ast.arg)),
        *(
            alias.asname or alias.name
            for node in nodes
            if isinstance(node, _IS_IMPORT)
            for alias in node.names
        ),
    ]


def _pairs(target: ast.expr, value: ast.expr) -> list[tuple[str, ast.Constant]]:
    match target, value:
        case ast.Tuple(names), ast.Tuple(values):
            return [pair for one, its in zip(names, values, strict=False) for pair in _pairs(one, its)]
        case ast.Name(name), ast.Constant(str() | int() | float()):
            return [(name, value)]
    return []


class _Constants(ast.NodeTransformer):
    def __init__(self, known: dict[str, ast.Constant]) -> None:
        self._known = known

    def visit_Name(self, node: ast.Name) -> ast.expr:
        known = self._known.get(node.id) if isinstance(node.ctx, ast.Load) else None
        return node if known is None else ast.copy_location(ast.Constant(known.value), node)
