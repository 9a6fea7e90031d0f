"""State that a function keeps outside its variables, which a reset or snapshot leaves as it is."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from types import ModuleType
from typing import Final

from nrp_core.checks.check import checks_function
from nrp_core.checks.code.syntax import CHANGING, own_nodes, root_of
from nrp_core.checks.code.values import Known
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.findings import Code, Finding, Level

_DISPLAYS: Final = (ast.List, ast.Dict, ast.Set, ast.ListComp, ast.DictComp, ast.SetComp)
_MAKERS: Final = frozenset(
    {"list", "dict", "set", "bytearray", "deque", "defaultdict", "OrderedDict", "Counter", "array", "zeros",
     "ones", "empty", "full", "arange", "linspace", "eye"}
)  # fmt: skip
"""Functions and classes that return a container or an array, by the last part of their name."""


@checks_function
def check_state(function: CheckedFunction) -> Iterator[Finding]:
    """Look for globals and for objects of the file that a function changes."""
    objects = _mutable_objects(function.declared.source.tree)
    own = set(function.function.parameters) | {
        node.id
        for node in function.declared.own
        if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load)
    }
    found: dict[str, ast.AST] = {}
    once = set(_loaded_once(function))
    for name, node in (*_rebound(function), *_changed(function, objects - own)):
        if id(node) not in once and name not in found:
            found[name] = node
            message = f"no reset and no snapshot restores '{name}': keep what changes in a MapVariable"
            yield function.declared.finding(Code.NRP301, node, message, Level.WARNING)


def _mutable_objects(tree: ast.Module) -> set[str]:
    """Return the names of objects of a file whose contents or attributes may change."""
    found: set[str] = set()
    classes = {node.name for node in own_nodes(tree.body) if isinstance(node, ast.ClassDef)}
    for node in own_nodes(tree.body):
        match node:
            case ast.Assign([ast.Name(name)], value) | ast.AnnAssign(ast.Name(name), _, ast.expr() as value):
                made = value.func if isinstance(value, ast.Call) else None
                maker = made.attr if isinstance(made, ast.Attribute) else getattr(made, "id", "")
                if isinstance(value, _DISPLAYS) or maker in _MAKERS | classes:
                    found.add(name)
            case ast.FunctionDef(name=name, decorator_list=[]) | ast.ClassDef(name=name):
                found.add(name)
    return found


def _rebound(function: CheckedFunction) -> Iterator[tuple[str, ast.AST]]:
    """Yield the global names, and those of an enclosing function or a module, that a function sets."""
    own = function.declared.own
    shared = {name for one in own if isinstance(one, ast.Global | ast.Nonlocal) for name in one.names}
    for node in reversed(own):
        match node:
            case ast.Name(name, ast.Store() | ast.Del()) if name in shared:
                yield name, node
            case ast.Attribute(value, ctx=ast.Store()):
                owner = function.body.shape(value)
                if isinstance(owner, Known) and isinstance(owner.value, ModuleType):
                    yield ast.unparse(node), node


def _changed(function: CheckedFunction, objects: set[str]) -> Iterator[tuple[str, ast.AST]]:
    """Yield the objects of a file that a function changes in place.

    ``x[:] = ...`` is left out: it replaces all old values.
    """
    replaced = {
        id(target)
        for node in function.declared.own
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Subscript) and ast.unparse(target.slice) in (":", "...")
        if ast.unparse(target.value) not in {ast.unparse(one) for one in ast.walk(node.value)}
    }
    for node in reversed(function.declared.own):
        if id(node) in replaced:
            continue
        match node:
            case ast.Call(ast.Attribute(owner, method)) if method in CHANGING:
                root = root_of(owner)
            case ast.Attribute(ctx=ast.Store() | ast.Del()) | ast.Subscript(ctx=ast.Store() | ast.Del()):
                root = root_of(node)
            case _:
                continue
        if isinstance(root, ast.Name) and root.id in objects:
            yield root.id, node


def _loaded_once(function: CheckedFunction) -> Iterator[int]:
    """Yield the targets of ``if x is None: x = load()``: the value is the same after a reset."""
    for node in function.declared.own:
        if isinstance(node, ast.If):
            asked = {one.id for one in ast.walk(node.test) if isinstance(one, ast.Name)}
            for one in node.body:
                if isinstance(one, ast.Assign) and any(
                    isinstance(part, ast.Call) for part in ast.walk(one.value)
                ):
                    for target in one.targets:
                        root = root_of(target)
                        if isinstance(root, ast.Name) and root.id in asked:
                            yield from (id(target), id(root))
