"""Replace imported names by full names, which the model needs."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from copy import deepcopy

from nrp_bibi.generation.expressions import in_framework
from nrp_bibi.reverse.refusal import NotExpressibleError


def imported(tree: ast.Module) -> dict[str, str]:
    """Return the full names of a file's imported names: ``geometry_msgs.msg.Twist`` for ``Twist``."""
    return {name: full for statement in tree.body for name, full in bound_by(statement)}


def bound_by(statement: ast.stmt) -> Iterator[tuple[str, str]]:
    """Yield the names that an import binds, each with its full name; nothing for other statements."""
    match statement:
        case ast.Import(aliases):
            for alias in aliases:
                root = alias.name.partition(".")[0]
                yield (root, root) if alias.asname is None else (alias.asname, alias.name)
        case ast.ImportFrom(module=str(module), names=aliases, level=0):
            yield from ((alias.asname or alias.name, f"{module}.{alias.name}") for alias in aliases)


def written_out(function: ast.FunctionDef, known: Mapping[str, str]) -> ast.FunctionDef:
    """Return a function with full names in place of imported names.

    Raises:
        NotExpressibleError: a name of its own hides an imported name.
    """
    own = {one.arg for one in ast.walk(function) if isinstance(one, ast.arg)}
    own |= {
        one.id for one in ast.walk(function) if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store)
    }
    if own & known.keys():
        raise NotExpressibleError(", ".join(sorted(own & known.keys())))
    made: ast.FunctionDef = _WrittenOut(known).visit(deepcopy(function))
    return made


def with_full_names(node: ast.expr, known: Mapping[str, str]) -> ast.expr:
    """Return an expression with full names in place of imported names."""
    made: ast.expr = _WrittenOut(known).visit(deepcopy(node))
    return made


class _WrittenOut(ast.NodeTransformer):
    def __init__(self, known: Mapping[str, str]) -> None:
        self._known = known

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id not in self._known:
            return node
        short = in_framework(f"{self._known[node.id]}.").rstrip(".")
        return ast.parse("Topic" if short == "nrp.Topic" else short, mode="eval").body

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        self.generic_visit(node)
        is_topic = node.attr == "Topic" and isinstance(node.value, ast.Name) and node.value.id == "nrp"
        return ast.Name("Topic", ast.Load()) if is_topic else node
