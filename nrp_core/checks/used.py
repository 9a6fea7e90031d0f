"""The functions of a file that a transfer function uses."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from nrp_core.checks.declared import Declared, Function
from nrp_core.checks.function_body import assigned
from nrp_core.checks.scopes import own_nodes


def used_functions(declared: Declared) -> Iterator[Function]:
    """Yield a transfer function, and the functions of its file that it calls, directly or through others."""
    written = {
        node.name: node
        for node in own_nodes(declared.source.tree.body)
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and not node.decorator_list
    }
    waiting: list[Function] = [declared.node]
    while waiting:
        function = waiting.pop()
        yield function
        named = {node.id for node in ast.walk(function) if isinstance(node, ast.Name)}
        waiting += [written.pop(name) for name in sorted(named & set(written) - local_names(function))]


def local_names(function: Function) -> set[str]:
    """Return the parameters of a function and the names that it assigns, with those of functions in it."""
    found: set[str] = set()
    shared: set[str] = set()
    for node in ast.walk(function):
        match node:
            case ast.arg(name):
                found.add(name)
            case ast.FunctionDef(name=name, body=body) | ast.AsyncFunctionDef(name=name, body=body):
                found |= assigned(body) if node is function else {name, *assigned(body)}
            case ast.Global(names) | ast.Nonlocal(names):
                shared.update(names)
    return found - shared


def root_of(node: ast.expr) -> ast.expr:
    """Return the innermost object of attributes and items: ``a`` of ``a.b[0].c``."""
    while isinstance(node, (ast.Attribute, ast.Subscript)):
        node = node.value
    return node
