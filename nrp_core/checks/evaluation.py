"""Evaluate the arguments of decorators: our constructors, constants and selectors, no code of the user."""

from __future__ import annotations

import ast
import inspect
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import count, islice
from pathlib import Path
from typing import Any

from nrp_core.checks.events import Call
from nrp_core.checks.expressions import Expressions
from nrp_core.checks.shapes import NEURONS, UNKNOWN, Known, Row, Shape, joined
from nrp_core.errors import NrpError, did_you_mean

_PLAIN: tuple[Any, ...] = (
    slice, range, int, float, str, bool, list, tuple, dict, len, min, max, sum, abs, round, enumerate, zip,
    sorted, reversed,
)  # fmt: skip
_METHODS: dict[type, tuple[str, ...]] = {
    str: ("format", "upper", "lower", "title", "capitalize", "replace", "split", "strip", "join"),
    dict: ("items", "keys", "values", "get"),
}
"""Methods of constants without side effects."""
FAILURES = (
    NrpError, TypeError, ValueError, LookupError, AttributeError, ArithmeticError, RecursionError,
)  # fmt: skip
"""The exceptions of our constructors for invalid arguments."""
_LIMIT = 100_000
"""Maximum number of items in a range, list or map that is evaluated here."""

_COMPARISONS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.Lt: operator.lt, ast.LtE: operator.le,
    ast.Gt: operator.gt, ast.GtE: operator.ge, ast.Is: operator.is_, ast.IsNot: operator.is_not,
    ast.In: lambda left, right: left in right, ast.NotIn: lambda left, right: left not in right,
}  # fmt: skip
_DECIDING = (int, float, str, tuple, list, dict, type(None))
"""Types of constants whose equality and truth value are known."""


class UnreadableError(NrpError):
    """A value that is only known when the file is executed."""


class MisfitError(TypeError):
    """A call of a class with arguments that it does not take."""


class Evaluation(Expressions):
    """Evaluates expressions that consist of our objects and constants.

    Args:
        names: the shape of each name.
        ours: the objects that may be called.
        path: the file, for errors.
    """

    def __init__(self, names: Mapping[str, Shape], ours: Iterable[Any], path: Path) -> None:
        super().__init__(names)
        self._ours = {id(one): one for one in (*ours, *_PLAIN)}
        self.path = path

    def is_ours(self, value: Any) -> bool:
        """Return whether an object may be called."""
        owner = getattr(value, "__self__", None)
        if isinstance(owner, NEURONS):
            return True
        if isinstance(owner, str) and value.__name__ == "format":
            return ":" not in owner  # a width may be of any size
        if type(owner) in _METHODS:
            return value.__name__ in _METHODS[type(owner)]
        return id(value) in self._ours or (isinstance(value, type) and hasattr(value, "__msgtype__"))

    def called(self, call: Call) -> Shape:
        """Call one of our objects as the file would.

        Raises:
            NrpError, TypeError, ValueError: the exceptions of the called object.
        """
        if isinstance(call.callee, Known) and not callable(call.callee.value):
            raise TypeError(f"{ast.unparse(call.node.func)} cannot be called{_meant(call.callee.value)}")
        if not (isinstance(call.callee, Known) and self.is_ours(call.callee.value)):
            return UNKNOWN
        try:
            given = [value_of(shape) for shape in call.given]
            named = {name: value_of(shape) for name, shape in call.named.items()}
        except UnreadableError:
            return self.called_in_part(call)
        if not call.is_whole:
            return UNKNOWN
        _require_fit(call.node, call.callee.value, given, named)
        found = self.at(call.node, call.callee.value, *given, **named)
        return Known(tuple(islice(found, _LIMIT)) if isinstance(found, Iterator) else found)

    def called_in_part(self, call: Call) -> Shape:
        """Return the result of a call with some unknown arguments."""
        return UNKNOWN

    def at(self, node: ast.expr | ast.stmt, function: Callable[..., Any], *given: Any, **named: Any) -> Any:
        """Call an object, with the line of a node of the file as the place of the call."""
        call = ast.Call(
            ast.Name("function", ast.Load()),
            [ast.Starred(ast.Name("given", ast.Load()), ast.Load())],
            [ast.keyword(None, ast.Name("named", ast.Load()))],
        )
        for part in ast.walk(call):
            ast.copy_location(part, node)
        code = compile(ast.Expression(call), str(self.path), "eval")
        return eval(code, {"function": function, "given": given, "named": named, "__builtins__": {}})

    # -- expressions that have a value here and only a shape in function bodies

    def attribute_of(self, owner: Shape, name: str) -> Shape | None:
        if isinstance(owner, Known) and name in _METHODS.get(type(owner.value), ()):
            return Known(getattr(owner.value, name))
        return super().attribute_of(owner, name)

    def item_of(self, owner: Shape, index: Shape) -> Shape:
        match owner, index:
            case Known(dict() | list() | str() | range() as value), Known(key):
                return Known(value[key])
        return super().item_of(owner, index)

    def _compare(self, node: ast.Compare) -> Shape:
        sides = [self.shape(side) for side in (node.left, *node.comparators)]
        work = _COMPARISONS.get(type(node.ops[0])) if len(node.ops) == 1 else None
        match sides:
            case [Known(left), Known(right)] if work and isinstance(left, _DECIDING):
                return Known(work(left, right))
        return UNKNOWN

    def _ifexp(self, node: ast.IfExp) -> Shape:
        decided = truth_of(self.shape(node.test))
        if decided is None:
            return joined(self.shape(node.body), self.shape(node.orelse))
        return self.shape(node.body if decided else node.orelse)

    def _dict(self, node: ast.Dict) -> Shape:
        keys, values = map(self.shape, node.keys), [self.shape(value) for value in node.values]
        try:
            return Known({value_of(key): value_of(one) for key, one in zip(keys, values, strict=True)})
        except (UnreadableError, TypeError):
            return UNKNOWN

    def _lambda(self, node: ast.Lambda) -> Shape:
        names = [argument.arg for argument in node.args.args]
        outer = dict(self.names)
        rounds = count(1)

        def function(*given: Any) -> Any:
            if next(rounds) > _LIMIT:
                raise UnreadableError(f"it selects more than {_LIMIT} times")
            inner = type(self).__new__(type(self))
            vars(inner).update(vars(self))
            inner.names = {**outer, **{n: Known(value) for n, value in zip(names, given, strict=False)}}
            return value_of(inner.shape(node.body))

        function.__name__ = "lambda"
        # it has the lambda's signature, because some selectors inspect the number of arguments
        function.__signature__ = _signature(names)  # type: ignore[attr-defined]
        return Known(function)

    def _items(self, node: ast.ListComp | ast.SetComp | ast.GeneratorExp | ast.DictComp) -> Shape:
        if isinstance(node, ast.DictComp):
            return self._comprehension(node)
        kept = dict(self.names)
        found: list[Shape] = []
        is_known = self._gather(node.elt, node.generators, found)
        self.names = kept
        return Row(tuple(found)) if is_known else self._comprehension(node)

    def _gather(self, element: ast.expr, loops: list[ast.comprehension], found: list[Shape]) -> bool:
        """Append the items that loops make, the first outermost; return whether all are known."""
        if not loops:
            found.append(self.shape(element))
            return len(found) <= _LIMIT
        items = items_of(self.shape(loops[0].iter))
        for item in items or ():
            self.bind(loops[0].target, item)
            decided = [truth_of(self.shape(condition)) for condition in loops[0].ifs]
            if None in decided or (all(decided) and not self._gather(element, loops[1:], found)):
                return False
        return items is not None

    _listcomp = _generatorexp = _items


def _meant(value: Any) -> str:
    """Return the correct form of a call."""
    return "; neurons are selected in brackets: [0]" if isinstance(value, NEURONS) else ""


def value_of(shape: Shape) -> Any:
    """Return the value of a shape.

    Raises:
        UnreadableError: the value is unknown.
    """
    match shape:
        case Known(range() as value):
            return _few(value)
        case Known(value):
            return value
        case Row(items):
            return [value_of(item) for item in items]
    raise UnreadableError("it is known only when the file is executed")


def items_of(shape: Shape) -> list[Shape] | None:
    """Return the items of a constant; None if it is not a constant."""
    match shape:
        case Row(items):
            return list(items)
        case Known(range() | list() | tuple() | str() | dict() as values):
            return list(map(Known, _few(values)))
    return None


def truth_of(shape: Shape) -> bool | None:
    """Return the truth value of a constant; None if it is not a constant."""
    match shape:
        case Row(items):
            return bool(items)
        case Known(value) if isinstance(value, _DECIDING):
            return bool(value)
    return None


def _few(values: Any) -> Any:
    if len(values) > _LIMIT:
        raise UnreadableError(f"it has more than {_LIMIT} items")
    return values


def _require_fit(node: ast.Call, callee: Any, given: list[Any], named: Mapping[str, Any]) -> None:
    """Compare the arguments of a call with the signature of a class.

    Raises:
        MisfitError: they do not fit; with the parameters of the class.
    """
    if not isinstance(callee, type) or callee in _PLAIN:
        return
    taken = inspect.signature(callee)
    try:
        taken.bind(*given, **named)
    except TypeError as error:
        unknown = next((name for name in named if name not in taken.parameters), None)
        valid = list(taken.parameters)
        hint = f"; it takes {', '.join(valid)}" if unknown is None else did_you_mean(unknown, valid)
        raise MisfitError(f"{ast.unparse(node.func)}: {error}{hint}") from None


def _signature(names: list[str]) -> Any:
    from inspect import Parameter, Signature

    return Signature([Parameter(name, Parameter.POSITIONAL_OR_KEYWORD) for name in names])
