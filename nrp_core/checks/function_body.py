"""Walk through the body of a function, statement by statement, and collect its operations."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise

from nrp_core.checks.events import Add, Compute, Event, Index, Rename, Return, Write
from nrp_core.checks.expressions import Expressions, with_hidden
from nrp_core.checks.imported import Imported
from nrp_core.checks.scopes import own_nodes
from nrp_core.checks.shapes import UNKNOWN, Instance, Known, Number, Shape, attribute, item_of, joined

_ENDS = (ast.Return, ast.Raise, ast.Continue, ast.Break)
_ASKS = frozenset({"hasattr", "isinstance", "getattr", "callable"})
"""Functions with which a body tests whether an operation is possible."""
ORDERS = (ast.Lt, ast.LtE, ast.Gt, ast.GtE)
"""Order comparisons."""


class FunctionBody(Expressions):
    """The operations of a function.

    Args:
        names: the shapes of the names that it sees.
        statements: its body.
        imports: returns the names that an import in it binds.

    Attributes:
        events: its operations, in source order. Code in a ``try`` or after a test such as ``hasattr`` is left
            out, because it is meant to fail.
    """

    def __init__(
        self,
        names: Mapping[str, Shape],
        statements: Sequence[ast.stmt],
        imports: Callable[[ast.Import | ast.ImportFrom], Iterable[Imported]],
    ) -> None:
        super().__init__(names)
        self._imports = imports
        self.events: list[Event] = []
        self._guards = 0
        self._inner = 0
        self._walk(statements)

    def observe(self, event: Event) -> None:
        if not self._guards and not (self._inner and isinstance(event, Return)):
            self.events.append(event)

    def bind(self, target: ast.expr, shape: Shape) -> None:
        match target:
            case ast.Attribute(value, name):
                owner = self.shape(value)
                self.observe(Write(target, owner, name, attribute(owner, name) is not None, shape))
            case ast.Subscript(value, index):
                self.shape(value)
                self.shape(index)
            case _:
                super().bind(target, shape)

    def _compare(self, node: ast.Compare) -> Shape:
        sides = [self.shape(side) for side in (node.left, *node.comparators)]
        for left, right in pairwise(sides):
            self.observe(Add(node, left, right))
        nodes = [node.left, *node.comparators]
        for i, operation in enumerate(node.ops):
            if isinstance(operation, ORDERS):
                self.observe(Compute(nodes[i], sides[i]))
                self.observe(Compute(nodes[i + 1], sides[i + 1]))
        return Instance(bool) if all(map(_is_scalar, sides)) else UNKNOWN

    # -- statements

    def _walk(self, statements: Iterable[ast.stmt]) -> None:
        for statement in statements:
            work = getattr(self, f"_do_{type(statement).__name__.lower()}", self._do_parts)
            work(statement)

    def _do_parts(self, statement: ast.stmt) -> None:
        for child in ast.iter_child_nodes(statement):
            if isinstance(child, ast.expr):
                self.shape(child)

    def _do_assign(self, node: ast.Assign) -> None:
        for target in node.targets:
            if isinstance(target, (ast.Tuple, ast.List)) and isinstance(node.value, (ast.Tuple, ast.List)):
                found: Shape = self._row(node.value.elts, list)
            else:
                found = self.shape(node.value)
            if isinstance(target, ast.Name) and not _is_part_of(node.value, target.id):
                self.observe(Rename(target, self.names.get(target.id, UNKNOWN)))
            self.bind(target, found)

    def _do_annassign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.bind(node.target, self.shape(node.value))

    def _do_augassign(self, node: ast.AugAssign) -> None:
        together = ast.BinOp(_loaded(node.target), node.op, node.value)
        self.bind(node.target, self.shape(ast.copy_location(together, node)))

    def _do_return(self, node: ast.Return) -> None:
        is_none = node.value is None or (isinstance(node.value, ast.Constant) and node.value.value is None)
        found = self.shape(node.value)
        self.observe(Return(node, None if is_none else found))

    def _do_if(self, node: ast.If) -> None:
        self.shape(node.test)
        asks = any(map(_asks, ast.walk(node.test)))
        self._guards += asks
        before = dict(self.names)
        self._walk(node.body)
        after, self.names = self.names, before
        self._walk(node.orelse)
        if not _ends(node.body):
            self.names = _merged(after, self.names) if not _ends(node.orelse) else after
        self._guards -= asks

    def _do_for(self, node: ast.For | ast.AsyncFor) -> None:
        items = self.shape(node.iter)
        self.observe(Index(node.iter, items, None))
        self._loop(node, lambda: self.bind(node.target, item_of(items)))

    _do_asyncfor = _do_for

    def _do_while(self, node: ast.While) -> None:
        self._loop(node, lambda: self.shape(node.test))

    def _loop(self, node: ast.For | ast.AsyncFor | ast.While, begin: Callable[[], object]) -> None:
        """Walk through a loop; a later iteration starts with the names as an earlier one left them."""
        changed = dict.fromkeys(assigned(node.body), UNKNOWN)
        self.names.update(changed)
        begin()
        self._walk(node.body)
        self.names.update(changed)
        self._walk(node.orelse)

    def _do_with(self, node: ast.With | ast.AsyncWith) -> None:
        for item in node.items:
            self.shape(item.context_expr)
            if item.optional_vars is not None:
                self.bind(item.optional_vars, UNKNOWN)
        self._walk(node.body)

    _do_asyncwith = _do_with

    def _do_try(self, node: ast.Try) -> None:
        self._guards += bool(node.handlers)
        self._walk(node.body)
        self.names.update(dict.fromkeys(assigned(node.body), UNKNOWN))
        self._guards -= bool(node.handlers)
        for handler in node.handlers:
            if handler.name:
                self.names[handler.name] = UNKNOWN
            before = dict(self.names)
            self._walk(handler.body)
            self.names = _merged(before, self.names)
        self._walk([*node.orelse, *node.finalbody])

    _do_trystar = _do_try

    def _do_match(self, node: ast.Match) -> None:
        self.shape(node.subject)
        self.names.update(dict.fromkeys(assigned([node]), UNKNOWN))
        for case in node.cases:
            before = dict(self.names)
            self._walk(case.body)
            self.names = _merged(before, self.names)

    def _do_functiondef(self, node: ast.FunctionDef | ast.AsyncFunctionDef) -> None:
        arguments = [one.arg for one in ast.walk(node.args) if isinstance(one, ast.arg)]
        self.names[node.name] = UNKNOWN
        self._inner += 1
        with_hidden(self, [*arguments, *assigned(node.body)], lambda: self._walk(node.body))
        self._inner -= 1

    _do_asyncfunctiondef = _do_functiondef

    def _do_import(self, node: ast.Import | ast.ImportFrom) -> None:
        self.names.update({imported.name: imported.shape for imported in self._imports(node)})

    _do_importfrom = _do_import

    def _do_classdef(self, node: ast.ClassDef) -> None:
        self.names[node.name] = UNKNOWN


def _asks(node: ast.AST) -> bool:
    """Return whether code asks for the kind of a value: ``isinstance(value, type(None))`` asks for none."""
    match node:
        case ast.Call(ast.Name("isinstance"), [_, ast.Call(ast.Name("type"), [ast.Constant(None)])]):
            return False
        case ast.Call(ast.Name(name)):
            return name in _ASKS
    return False


def _is_scalar(shape: Shape) -> bool:
    return isinstance(shape, Number) or (isinstance(shape, Known) and isinstance(shape.value, (int, float)))


def _is_part_of(value: ast.expr, name: str) -> bool:
    """Return whether an expression is a name or an attribute of one: ``camera.value``."""
    while isinstance(value, (ast.Attribute, ast.Subscript)):
        value = value.value
    return isinstance(value, ast.Name) and value.id == name


def _loaded(target: ast.expr) -> ast.expr:
    """Return the expression that reads the value set by an assignment target."""
    match target:
        case ast.Name(name):
            return ast.copy_location(ast.Name(name, ast.Load()), target)
        case ast.Attribute(value, name):
            return ast.copy_location(ast.Attribute(value, name, ast.Load()), target)
        case ast.Subscript(value, index):
            return ast.copy_location(ast.Subscript(value, index, ast.Load()), target)
    return target


def _ends(statements: Sequence[ast.stmt]) -> bool:
    return bool(statements) and isinstance(statements[-1], _ENDS)


def _merged(first: Mapping[str, Shape], second: Mapping[str, Shape]) -> dict[str, Shape]:
    names = {*first, *second}
    return {name: joined(first.get(name, UNKNOWN), second.get(name, UNKNOWN)) for name in names}


def assigned(statements: Iterable[ast.stmt]) -> set[str]:
    """Return the names that statements set, those inside functions excepted."""
    found: set[str] = set()
    for node in own_nodes(statements):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
        if isinstance(node, (ast.MatchAs, ast.MatchStar)) and node.name:
            found.add(node.name)
    return found
