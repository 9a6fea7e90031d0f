"""What is known of the values in a transfer function, whatever the order of its statements."""

from __future__ import annotations

import ast
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from functools import reduce
from typing import Final

from nrp_core.checks.code.declarations import Declared
from nrp_core.checks.code.values import Expressions, Instance, Shape, item_of, joined, value_of

_GUARDS: Final = frozenset({"hasattr", "isinstance", "getattr", "callable"})
"""Functions with which a body tests whether an operation is possible."""


class FunctionBody(Expressions):
    """The values of a function's body.

    A name has a shape if everything that is assigned to it has the same. A parameter to which something else
    is assigned has none.

    Args:
        declared: the function.
        parameters: the shapes of its parameters.

    Attributes:
        nodes: its nodes, in source order, without those that are meant to fail: in a ``try``, or after a test
            such as ``hasattr``.
    """

    def __init__(self, declared: Declared, parameters: Mapping[str, Shape]) -> None:
        super().__init__({**declared.names, **parameters})
        self._declared = declared
        self._assigned: dict[str, list[tuple[ast.expr, bool]]] = defaultdict(list)
        self._n_stores = Counter[str]()
        self._shapes: dict[str, Shape] = {}
        for statement in declared.node.body:
            for node in ast.walk(statement):
                self._collect(node)
        guarded = {id(one) for part in _guarded(declared.node) for one in ast.walk(part)}
        own = (
            one for statement in declared.node.body for one in ast.walk(statement) if id(one) not in guarded
        )
        self.nodes = sorted(own, key=lambda one: (getattr(one, "lineno", 0), getattr(one, "col_offset", 0)))

    def _collect(self, node: ast.AST) -> None:
        """Note what a node assigns to names: an expression, or an item of one."""
        match node:
            case ast.Name(name, ast.Store() | ast.Del()):
                self._n_stores[name] += 1
            case ast.Assign(targets=targets, value=value):
                for target in targets:
                    self._assign(target, value)
            case ast.AnnAssign(target, _, ast.expr() as value) | ast.NamedExpr(target, value):
                self._assign(target, value)
            case ast.AugAssign(ast.Name(name), operation, value):
                # with a parameter it is reported as a computation
                self._n_stores[name] -= name in self._declared.function.mappings
                self._assigned[name].append((ast.BinOp(ast.Name(name, ast.Load()), operation, value), False))
            case ast.For(ast.Name(name), iterable) | ast.comprehension(ast.Name(name), iterable):
                self._assigned[name].append((iterable, True))
            case ast.Global(names) | ast.Nonlocal(names):
                self._shapes.update(dict.fromkeys(names))
            case ast.Import() | ast.ImportFrom():
                found = self._declared.imports.of(node, self._declared.source.path)
                self._shapes.update({one.name: one.shape for one in found})
            case ast.arg() | ast.ExceptHandler() | ast.MatchAs() | ast.FunctionDef() | ast.ClassDef():
                self._shapes[str(getattr(node, "name", None) or getattr(node, "arg", ""))] = None

    def _assign(self, target: ast.expr, value: ast.expr) -> None:
        match target, value:
            case ast.Name(name), _:
                self._assigned[name].append((value, False))
            case ast.Tuple(targets) | ast.List(targets), ast.Tuple(values) | ast.List(values):
                for one, part in zip(targets, values, strict=False):
                    self._assign(one, part)

    def name(self, name: str) -> Shape:
        if name not in self._shapes:
            self._shapes[name] = None  # for names that depend on themselves
            self._shapes[name] = self._shape_of_name(name)
        return self._shapes[name]

    def _shape_of_name(self, name: str) -> Shape:
        n_stores, assigned = self._n_stores[name], self._assigned[name]
        if not n_stores:
            return super().name(name)
        if name in self._declared.function.parameters or len(assigned) != n_stores:
            return None
        shapes = [item_of(self.shape(node)) if is_item else self.shape(node) for node, is_item in assigned]
        found = reduce(joined, shapes)
        return found if value_of(found, list) is None else Instance(list, item_of(found))

    def is_local(self, name: str) -> bool:
        """Return whether a name is a parameter, or the body sets it."""
        return name in self._declared.function.parameters or self._n_stores[name] > 0

    def assigned(self, name: str) -> ast.expr | None:
        """Return the expression that a name stands for; None if it is set more than once, or by a loop."""
        match self._assigned[name], self._n_stores[name]:
            case [(value, False)], 1 if name not in self._declared.function.parameters:
                return value
        return None

    def constant(self, node: ast.expr) -> float | None:
        """Return the number that an expression always is; None if it may be another."""
        value = value_of(self.shape(node), int | float)
        return None if value is None or isinstance(value, bool) else float(value)


def _guarded(function: ast.AST) -> Iterator[ast.AST]:
    """Yield the statements that are meant to fail."""
    for node in ast.walk(function):
        match node:
            case ast.Try(body, [_, *_]):
                yield from body
            case ast.If(test, body, orelse) if any(map(_asks, ast.walk(test))):
                yield from (*body, *orelse)


def _asks(node: ast.AST) -> bool:
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _GUARDS
