"""Nodes, names and texts of Python code."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, Final, TypeAlias

Function: TypeAlias = ast.FunctionDef | ast.AsyncFunctionDef
_LONGEST: Final = 60
"""Characters of code that a message quotes."""
SCOPES: Final = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)
"""Nodes that open a scope."""
CHANGING: Final = frozenset(
    {"append", "extend", "insert", "remove", "pop", "popitem", "clear", "sort", "reverse", "update", "add",
     "discard", "setdefault", "appendleft", "popleft", "extendleft", "rotate", "fill"}
)  # fmt: skip
"""Methods that change their object."""


def excerpt(node: ast.AST, longest: int = _LONGEST) -> str:
    """Return the text of an expression or a statement, which ends with '...' if it is cut."""
    text = ast.unparse(node)
    return text if len(text) <= longest else f"{text[: longest - 3]}..."


def own_nodes(nodes: Iterable[ast.AST]) -> Iterator[ast.AST]:
    """Yield nodes and their descendants, last first, without the bodies of functions and classes."""
    waiting = list(nodes)
    while waiting:
        node = waiting.pop()
        yield node
        if not isinstance(node, SCOPES):
            waiting += ast.iter_child_nodes(node)


def assigned_names(node: ast.AST) -> set[str]:
    """Return the names that a statement sets, those inside functions excepted."""
    found: set[str] = set()
    for one in own_nodes([node]):
        match one:
            case (
                ast.Name(name, ast.Store() | ast.Del())
                | ast.MatchAs(name=str(name))
                | ast.MatchStar(str(name))
            ):
                found.add(name)
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                found.add(name)
            case ast.Import(aliases) | ast.ImportFrom(names=aliases):
                found |= {alias.asname or alias.name.partition(".")[0] for alias in aliases}
    return found


def root_of(node: ast.expr) -> ast.expr:
    """Return the innermost object of attributes and items: ``a`` of ``a.b[0].c``."""
    while isinstance(node, ast.Attribute | ast.Subscript):
        node = node.value
    return node


def root_name(node: ast.expr) -> str:
    """Return the name of the innermost object; empty if it is something else than a name."""
    return getattr(root_of(node), "id", "")


def names_in(node: ast.AST) -> set[str]:
    """Return all names in a node."""
    return {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}


def full_names(tree: ast.Module) -> dict[str, str]:
    """Return the full names of imported modules and of the names imported from them."""
    found: dict[str, str] = {}
    for node in ast.walk(tree):
        match node:
            case ast.Import(names):
                found |= {alias.asname or alias.name: alias.name for alias in names}
            case ast.ImportFrom(module=str(module), names=names, level=0):
                found |= {alias.asname or alias.name: f"{module}.{alias.name}" for alias in names}
    return found


def stub_of(node: Function, path: Path) -> Any:
    """Return a function with the same parameters and an empty body; ``...`` stands for default values."""
    yields = any(isinstance(one, ast.Yield | ast.YieldFrom) for one in own_nodes(node.body))
    parts = node.args
    parameters = ast.arguments(
        posonlyargs=[ast.arg(one.arg) for one in parts.posonlyargs],
        args=[ast.arg(one.arg) for one in parts.args],
        vararg=ast.arg(parts.vararg.arg) if parts.vararg else None,
        kwonlyargs=[ast.arg(one.arg) for one in parts.kwonlyargs],
        kw_defaults=[None if one is None else ast.Constant(...) for one in parts.kw_defaults],
        kwarg=ast.arg(parts.kwarg.arg) if parts.kwarg else None,
        defaults=[ast.Constant(...) for _ in parts.defaults],
    )
    stub = type(node)(node.name, parameters, [ast.Expr(ast.Yield(None)) if yields else ast.Pass()], [])
    for part in ast.walk(stub):
        ast.copy_location(part, node)
    names: dict[str, Any] = {"__builtins__": {}}
    exec(compile(ast.Module([stub], []), str(path), "exec"), names)
    return names[node.name]
