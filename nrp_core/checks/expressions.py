"""Derive the shapes of expressions without running them."""

from __future__ import annotations

import ast
import builtins
import operator
from collections.abc import Callable, Mapping
from typing import Any

from nrp_core.checks.events import Add, Call, Compute, Divide, Event, Index, Multiply, Read
from nrp_core.checks.shapes import (
    NEURONS,
    UNKNOWN,
    Items,
    Known,
    Number,
    Row,
    Shape,
    attribute,
    hints,
    instance_of,
    item_of,
    joined,
    of_hint,
)

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
