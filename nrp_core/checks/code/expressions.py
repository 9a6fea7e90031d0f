"""Shapes of expressions, and the operations of a function's body in source order."""

from __future__ import annotations

import ast
import builtins
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

from nrp_core.checks.code.shapes import (
    NEURONS,
    UNKNOWN,
    Add,
    Call,
    Compute,
    Divide,
    Event,
    Imported,
    Index,
    Instance,
    Items,
    Known,
    Multiply,
    Number,
    Read,
    Rename,
    Return,
    Row,
    Shape,
    Write,
    attribute,
    hints,
    instance_of,
    item_of,
    joined,
    of_hint,
)
from nrp_core.checks.code.syntax import own_nodes

_OPERATIONS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
}  # fmt: skip
_DIVISIONS = (ast.Div, ast.FloorDiv, ast.Mod)
_SAME_UNIT: tuple[Any, ...] = (min, max, abs, float, round, sum)
"""Functions whose result has the unit of their arguments."""
_COUNTS: tuple[Any, ...] = (int, len)
"""Functions whose result is a number for any argument."""


class Expressions:
    """Derives the shapes of expressions from the shapes of names.

    Args:
        names: the shape of each name.

    Attributes:
        divide: the operator ``/``.
    """

    divide: Callable[[Any, Any], Any] = staticmethod(operator.truediv)

    def __init__(self, names: Mapping[str, Shape]) -> None:
        self.names = dict(names)

    def observe(self, event: Event) -> None:
        """Called for each operation in an expression."""

    def shape(self, node: ast.expr | None) -> Shape:
        """Return the shape of an expression."""
        known = None if node is None else getattr(self, f"_{type(node).__name__.lower()}", None)
        if known is not None:
            found: Shape = known(node)
            return found
        for child in ast.iter_child_nodes(node) if node is not None else ():
            if isinstance(child, ast.expr):
                self.shape(child)
        return UNKNOWN

    # -- kinds of expressions

    def _constant(self, node: ast.Constant) -> Shape:
        return Known(node.value)

    def _name(self, node: ast.Name) -> Shape:
        if node.id in self.names:
            return self.names[node.id]
        return Known(getattr(builtins, node.id)) if hasattr(builtins, node.id) else UNKNOWN

    def _attribute(self, node: ast.Attribute) -> Shape:
        owner = self.shape(node.value)
        found = self.attribute_of(owner, node.attr)
        self.observe(Read(node, owner, node.attr, found is not None))
        return UNKNOWN if found is None else found

    def attribute_of(self, owner: Shape, name: str) -> Shape | None:
        """Return the shape of an attribute; None if there is no such attribute."""
        return attribute(owner, name)

    def _subscript(self, node: ast.Subscript) -> Shape:
        owner, index = self.shape(node.value), self.shape(node.slice)
        self.observe(Index(node, owner, index))
        if isinstance(owner, Known) and isinstance(owner.value, NEURONS):
            neurons: Any = owner.value
            match index:
                case Known(value):
                    return Known(neurons[value])
                case Row(items) if all(isinstance(item, Known) for item in items):
                    return Known(neurons[[item.value for item in items if isinstance(item, Known)]])
            return UNKNOWN
        if isinstance(node.slice, ast.Slice):
            return owner if isinstance(owner, Items) else UNKNOWN
        return self.item_of(owner, index)

    def item_of(self, owner: Shape, index: Shape) -> Shape:
        """Return the shape of an item of a sequence."""
        if isinstance(index, Known) and isinstance(index.value, int):
            found = _item_at(owner, index.value)
            if found is not None:
                return found
        return item_of(owner)

    def _slice(self, node: ast.Slice) -> Shape:
        parts = [None if part is None else self.shape(part) for part in (node.lower, node.upper, node.step)]
        if all(part is None or isinstance(part, Known) for part in parts):
            return Known(slice(*(None if part is None else part.value for part in parts)))  # type: ignore[union-attr]
        return UNKNOWN

    def _tuple(self, node: ast.Tuple) -> Shape:
        return self._row(node.elts, tuple)

    def _list(self, node: ast.List) -> Shape:
        return self._row(node.elts, list)

    def _row(self, nodes: list[ast.expr], made: type) -> Shape:
        items = tuple(map(self.shape, nodes))
        if any(isinstance(node, ast.Starred) for node in nodes):
            return UNKNOWN
        if made is tuple and all(isinstance(item, Known) for item in items):
            return Known(tuple(item.value for item in items if isinstance(item, Known)))
        return Row(items)

    def _binop(self, node: ast.BinOp) -> Shape:
        left, right = self.shape(node.left), self.shape(node.right)
        self.observe(Compute(node.left, left))
        self.observe(Compute(node.right, right))
        if isinstance(node.op, _DIVISIONS):
            self.observe(Divide(node, left, right))
        if isinstance(node.op, (ast.Add, ast.Sub)):
            self.observe(Add(node, left, right))
        if isinstance(node.op, ast.Mult):
            self.observe(Multiply(node, left, right))
        match left, right:
            case Known(a), Known(b):
                return _folded(node.op, a, b, self.divide)
            case (Number() as number, Known(int() | float())) if not isinstance(node.op, ast.Pow):
                return number
            case (Known(int() | float()), Number() as number) if not isinstance(
                node.op, (ast.Pow, *_DIVISIONS)
            ):
                return number
            case Number(a), Number(b) if a == b and isinstance(node.op, (ast.Add, ast.Sub)):
                return Number(a)
        return UNKNOWN

    def _unaryop(self, node: ast.UnaryOp) -> Shape:
        operand = self.shape(node.operand)
        if isinstance(node.op, (ast.USub, ast.UAdd)):
            self.observe(Compute(node.operand, operand))
        match node.op, operand:
            case ast.USub(), Known(int() | float() as value):
                return Known(-value)
            case ((ast.USub() | ast.UAdd()), (Number() | Known(int() | float()))):
                return operand
        return UNKNOWN

    def _ifexp(self, node: ast.IfExp) -> Shape:
        self.shape(node.test)
        return joined(self.shape(node.body), self.shape(node.orelse))

    def _namedexpr(self, node: ast.NamedExpr) -> Shape:
        found = self.shape(node.value)
        self.names[node.target.id] = found
        return found

    def _joinedstr(self, node: ast.JoinedStr) -> Shape:
        parts = [
            self.shape(part.value if isinstance(part, ast.FormattedValue) else part) for part in node.values
        ]
        plain = not any(isinstance(part, ast.FormattedValue) and part.format_spec for part in node.values)
        if plain and all(isinstance(part, Known) for part in parts):
            return Known("".join(str(part.value) for part in parts if isinstance(part, Known)))
        return UNKNOWN

    def _lambda(self, node: ast.Lambda) -> Shape:
        hidden = [argument.arg for argument in ast.walk(node.args) if isinstance(argument, ast.arg)]
        with_hidden(self, hidden, lambda: self.shape(node.body))
        return UNKNOWN

    def _comprehension(self, node: ast.ListComp | ast.SetComp | ast.GeneratorExp | ast.DictComp) -> Shape:
        kept = dict(self.names)
        found: Shape = UNKNOWN
        items: Shape = UNKNOWN
        for part in node.generators:
            items = self.shape(part.iter)
            self.bind(part.target, item_of(items))
            for condition in part.ifs:
                self.shape(condition)
        for element in (node.key, node.value) if isinstance(node, ast.DictComp) else (node.elt,):
            found = self.shape(element)
        self.names = kept
        if isinstance(node, ast.DictComp):
            return UNKNOWN
        is_simple = isinstance(node, ast.ListComp) and len(node.generators) == 1
        length = _length(items) if is_simple and not node.generators[0].ifs else None
        return Items(found) if length is None else Row((found,) * length)

    _listcomp = _setcomp = _generatorexp = _dictcomp = _comprehension

    def _call(self, node: ast.Call) -> Shape:
        callee = self.shape(node.func)
        given: list[Shape] = []
        named = {keyword.arg: self.shape(keyword.value) for keyword in node.keywords}
        whole = None not in named
        for argument in node.args:
            spread = _spread(self.shape(argument.value)) if isinstance(argument, ast.Starred) else None
            whole &= spread is not None or not isinstance(argument, ast.Starred)
            given += [self.shape(argument)] if spread is None else spread
        by_name = {name: shape for name, shape in named.items() if name is not None}
        call = Call(node, callee, tuple(given), by_name, whole)
        self.observe(call)
        return self.called(call)

    def called(self, call: Call) -> Shape:
        """Return the shape of the result of a call."""
        if not isinstance(call.callee, Known):
            return UNKNOWN
        callee = call.callee.value
        if isinstance(callee, type):
            made = instance_of(callee)
            if made != UNKNOWN:
                return made
        match call.given:
            case (Known(str() as text),) if callee is float and _is_float(text):  # "nan", "inf"
                return Known(float(text))
        if any(callee is one for one in _SAME_UNIT):
            return _common_unit(call.given)
        if any(callee is one for one in _COUNTS):
            return Number("")
        if str(getattr(callee, "__module__", "")).startswith("nrp_core."):
            return of_hint(hints(callee).get("return"))
        return UNKNOWN

    def bind(self, target: ast.expr, shape: Shape) -> None:
        """Assign a shape to the target of an assignment."""
        match target:
            case ast.Name(name):
                self.names[name] = shape
            case ast.Tuple(targets) | ast.List(targets):
                items = _unpacked(shape, len(targets))
                for one, item in zip(targets, items, strict=True):
                    self.bind(one, item)
            case ast.Starred(value):
                self.bind(value, UNKNOWN)


def with_hidden(expressions: Expressions, hidden: list[str], work: Callable[[], object]) -> None:
    """Run a block in which some names are unknown."""
    kept = dict(expressions.names)
    expressions.names.update(dict.fromkeys(hidden, UNKNOWN))
    work()
    expressions.names = kept


def _unpacked(shape: Shape, count: int) -> list[Shape]:
    match shape:
        case Row(items) if len(items) == count:
            return list(items)
        case Known(tuple() | list() as values) if len(values) == count:
            return [Known(value) for value in values]
    return [item_of(shape)] * count


def _spread(shape: Shape) -> list[Shape] | None:
    """Return the items that ``*`` makes arguments of; None if their number is unknown."""
    match shape:
        case Row(items):
            return list(items)
        case Known(tuple() | list() as values):
            return list(map(Known, values))
    return None


def _length(shape: Shape) -> int | None:
    match shape:
        case Row(items):
            return len(items)
        case Known(tuple() | range() as values):
            return len(values)
    return None


def _item_at(owner: Shape, index: int) -> Shape | None:
    match owner:
        case Row(items) if -len(items) <= index < len(items):
            return items[index]
        case Known(tuple() as values) if -len(values) <= index < len(values):
            return Known(values[index])
    return None


def _folded(
    operation: ast.operator, left: Any, right: Any, divide: Callable[[Any, Any], Any] = operator.truediv
) -> Shape:
    """Return the result of an operation on our objects, or on two numbers or strings."""
    work = divide if isinstance(operation, ast.Div) else _OPERATIONS.get(type(operation))
    plain = isinstance(left, (int, float)) and isinstance(right, (int, float))
    texts = isinstance(left, str) and isinstance(right, str) and isinstance(operation, ast.Add)
    if work is None or not (plain or texts or isinstance(left, NEURONS) or isinstance(right, NEURONS)):
        return UNKNOWN
    try:
        return Known(work(left, right))
    except (ArithmeticError, TypeError, ValueError):
        return UNKNOWN


def _is_float(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _common_unit(given: tuple[Shape, ...]) -> Shape:
    shapes = [item_of(shape) if isinstance(shape, (Items, Row)) else shape for shape in given]
    units = {shape.unit for shape in shapes if isinstance(shape, Number)}
    plain = all(isinstance(shape, (Number, Known)) for shape in shapes)
    return Number(*units) if plain and len(units) == 1 else UNKNOWN


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
