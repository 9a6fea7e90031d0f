"""Follow the statements of a file as far as they are known without running it.

Constants, loops over them, branches that they decide, and calls of the file's own functions are followed. Of
all other statements only the names that they set are known, not the values.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any, Final

from nrp_core.checks.code.syntax import CHANGING, assigned_names, own_nodes, stub_of
from nrp_core.checks.code.values import (
    NEURONS,
    PLAIN,
    Expressions,
    Instance,
    Known,
    Shape,
    item_of,
    value_of,
    values_of,
)
from nrp_core.dsl.selection import ProjectionSelector
from nrp_core.errors import NrpError, UnreadableError, did_you_mean

FAILURES: Final = (
    NrpError,
    TypeError,
    ValueError,
    LookupError,
    AttributeError,
    ArithmeticError,
    RecursionError,
)
"""The exceptions of our constructors for invalid arguments."""
_PLAIN: Final[tuple[Any, ...]] = (
    slice, range, int, float, str, bool, list, tuple, dict, len, min, max, sum, abs, round, enumerate, zip,
    sorted, reversed,
)  # fmt: skip
_TEXT_METHODS: Final = ("upper", "lower", "title", "capitalize", "replace", "split", "strip", "join")
_MAX_ITEMS: Final = 100_000
"""Items of a range or list that is evaluated, and statements that are followed."""
_MAX_DEPTH: Final = 20


class MisfitError(TypeError):
    """A call of a class with arguments that it does not take."""


class _Returned(Exception):  # noqa: N818 - nothing is wrong
    """A function ends."""

    def __init__(self, value: Shape) -> None:
        super().__init__()
        self.value = value


class Written:
    """A function of the user, which is read and not executed.

    Args:
        node: its syntax tree; that of a lambda returns its expression.
        reader: the reader of its file.
        names: the names of the enclosing functions.
    """

    def __init__(self, node: ast.FunctionDef, reader: Statements, names: Mapping[str, Shape]) -> None:
        self.node, self.names, self._reader = node, names, reader
        self.__name__ = node.name
        self.__signature__ = inspect.signature(stub_of(node, reader.path))

    def __call__(self, *given: Any, **named: Any) -> Any:
        """Return its result for known arguments.

        Raises:
            UnreadableError: the result is known only when it is executed.
        """
        found = self._reader.run(
            self, list(map(Known, given)), {name: Known(one) for name, one in named.items()}
        )
        if not isinstance(found, Known):
            raise UnreadableError("it is known only when the file is executed")
        return found.value


class Statements(Expressions):
    """Follows statements, and evaluates expressions of our objects and constants.

    Args:
        names: the shape of each name.
        ours: the objects that may be called.
        path: the file, for errors.
        changed: names whose values change while the file or its functions run.
    """

    def __init__(
        self, names: Mapping[str, Shape], ours: Iterable[Any], path: Path, changed: Iterable[str] = ()
    ) -> None:
        super().__init__(names)
        self._ours = {id(one): one for one in (*ours, *_PLAIN)}
        self.path = path
        self._changed = frozenset(changed)
        self._module = self.names
        self._depth, self._count = 0, 0

    # -- statements

    def follow_file(self, statements: Iterable[ast.stmt]) -> None:
        """Follow the statements of a file, each as far as possible."""
        for statement in statements:
            self._count = 0
            try:
                self.statement(statement)
            except (UnreadableError, _Returned):
                self._skip(statement)

    def _follow(self, statements: Iterable[ast.stmt]) -> None:
        for statement in statements:
            self._count += 1
            if self._count > _MAX_ITEMS:
                raise UnreadableError("it has too many steps")
            self.statement(statement)

    def statement(self, node: ast.stmt) -> None:
        """Follow a statement.

        Raises:
            UnreadableError: it is known only when the file is executed.
        """
        match node:
            case ast.Pass():
                pass
            case ast.Expr(value):
                self.quietly(value)
            case ast.Assign(targets, value):
                found = self.quietly(value)
                for target in targets:
                    self.bind(target, found)
            case ast.AnnAssign(target, _, value):
                self.bind(target, self.quietly(value))
            case ast.AugAssign(ast.Name(name) as target, operation, value):
                whole = ast.BinOp(ast.Name(name, ast.Load()), operation, value)
                self.bind(target, self.quietly(ast.copy_location(whole, node)))
            case ast.FunctionDef(decorator_list=[]):
                self.names[node.name] = Known(Written(node, self, self.local))
            case ast.Return(value):
                raise _Returned(Known(None) if value is None else self.shape(value))
            case _:
                self._follow_parts(node)

    def _follow_parts(self, node: ast.stmt) -> None:
        """Follow a branch or a loop that constants decide."""
        match node:
            case ast.If(test, body, orelse) if (decided := self._truth(test)) is not None:
                self._follow(body if decided else orelse)
            case ast.For(target, iterable, body, orelse) if (items := self._items(iterable)) is not None:
                if any(isinstance(one, ast.Break | ast.Continue) for one in own_nodes(body)):
                    raise UnreadableError("it may end early")
                for item in items:
                    self.bind(target, item)
                    self._follow(body)
                self._follow(orelse)
            case _:
                self._skip(node)

    def _skip(self, node: ast.stmt) -> None:
        """Forget the names that a statement sets whose effect is known only when it is executed."""
        self.names.update(dict.fromkeys(assigned_names(node)))
        if self._depth and any(isinstance(one, ast.Return) for one in own_nodes([node])):
            raise UnreadableError("it may end here")

    def bind(self, target: ast.expr, shape: Shape) -> None:
        """Assign a shape to the target of an assignment."""
        match target:
            case ast.Name(name):
                self.names[name] = None if name in self._changed else shape
            case ast.Tuple(targets) | ast.List(targets):
                values = value_of(shape, list | tuple)
                is_whole = values is not None and len(values) == len(targets)
                items = list(map(Known, values)) if is_whole else [item_of(shape)] * len(targets)
                for one, item in zip(targets, items, strict=True):
                    self.bind(one, item)
            case ast.Starred(value):
                self.bind(value, None)

    @property
    def local(self) -> dict[str, Shape]:
        """The names of the function that is followed; empty outside functions."""
        return self.names if self._depth else {}

    def run(self, written: Written, given: list[Shape], named: Mapping[str, Shape]) -> Shape:
        """Return the result of a function of the user.

        Raises:
            TypeError: it does not take these arguments.
            UnreadableError: it cannot be followed.
        """
        bound = written.__signature__.bind(*given, **named)
        if self._depth >= _MAX_DEPTH:
            raise UnreadableError("it calls itself too deeply")
        outer = self.names
        self._module = self._module if self._depth else outer
        defaults = {one: self.quietly(value) for one, value in _defaults(written.node.args)}
        arguments = {
            name: shape if isinstance(shape, Known | Instance) else None
            for name, shape in bound.arguments.items()
        }
        self.names = {**self._module, **written.names, **defaults, **arguments}
        self._depth += 1
        try:
            self._follow(written.node.body)
        except _Returned as returned:
            return returned.value
        finally:
            self._depth -= 1
            self.names = outer
        return Known(None)

    # -- expressions

    def quietly(self, node: ast.expr | None) -> Shape:
        """Return the shape of an expression; unknown if it fails."""
        try:
            return self.shape(node)
        except FAILURES:
            return None

    def shape(self, node: ast.AST | None) -> Shape:
        match node:
            case ast.Lambda(arguments, body):
                returned = ast.copy_location(ast.Return(body), body)
                function = ast.FunctionDef("lambda", arguments, [returned], [])
                return Known(Written(ast.copy_location(function, node), self, dict(self.names)))
            case ast.ListComp(element, loops) | ast.GeneratorExp(element, loops):
                before, found = dict(self.names), list[Shape]()
                is_known = self._gather(element, loops, found)
                self.names = before
                known = values_of(found) if is_known else None
                return None if known is None else Known(known)
            case ast.Dict(keys, values):
                known = values_of([self.shape(one) for one in (*keys, *values)])
                return None if known is None else Known(dict(zip(known, known[len(keys) :], strict=False)))
            case ast.IfExp(test, body, orelse) if (decided := self._truth(test)) is not None:
                return self.shape(body if decided else orelse)
        return super().shape(node)

    def _gather(self, element: ast.expr, loops: list[ast.comprehension], found: list[Shape]) -> bool:
        """Append the items that loops make, the first outermost; return whether all are known."""
        if not loops:
            found.append(self.shape(element))
            return len(found) <= _MAX_ITEMS
        items = self._items(loops[0].iter)
        for item in items or ():
            self.bind(loops[0].target, item)
            decided = [self._truth(condition) for condition in loops[0].ifs]
            if None in decided or (all(decided) and not self._gather(element, loops[1:], found)):
                return False
        return items is not None

    def _items(self, node: ast.expr) -> list[Shape] | None:
        values = value_of(self.quietly(node), range | list | tuple | str | dict)
        return None if values is None or len(values) > _MAX_ITEMS else list(map(Known, values))

    def _truth(self, node: ast.expr) -> bool | None:
        found = self.quietly(node)
        return bool(found.value) if isinstance(found, Known) and isinstance(found.value, PLAIN) else None

    def is_ours(self, value: Any) -> bool:
        """Return whether an object may be called."""
        owner = getattr(value, "__self__", None)
        if isinstance(owner, NEURONS) or isinstance(value, ProjectionSelector):
            return True
        if isinstance(owner, str):  # a width of a format may be of any size
            return value.__name__ in _TEXT_METHODS or (value.__name__ == "format" and ":" not in owner)
        if isinstance(owner, dict):
            return value.__name__ in ("items", "keys", "values", "get")
        return id(value) in self._ours or (isinstance(value, type) and hasattr(value, "__msgtype__"))

    def call(self, node: ast.Call) -> Shape:
        """Call one of our objects as the file would.

        Raises:
            NrpError, TypeError, ValueError: the exceptions of the called object.
        """
        callee = self.shape(node.func)
        if not isinstance(callee, Known):
            return None
        called = callee.value
        if not callable(called):
            meant = "; neurons are selected in brackets: [0]" if isinstance(called, NEURONS) else ""
            raise TypeError(f"{ast.unparse(node.func)} cannot be called{meant}")
        given: list[Shape] = []
        for argument in node.args:
            if not isinstance(argument, ast.Starred):
                given.append(self.shape(argument))
            elif (items := value_of(self.shape(argument.value), list | tuple)) is not None:
                given += map(Known, items)
            else:
                return None
        if any(one.arg is None for one in node.keywords):
            return None
        named = {str(one.arg): self.shape(one.value) for one in node.keywords}
        if isinstance(called, Written):
            return self.run(called, given, named)
        return self._called(node, called, given, named) if self.is_ours(called) else None

    def _called(self, node: ast.Call, called: Any, given: list[Shape], named: dict[str, Shape]) -> Shape:
        known, known_named = values_of(given), values_of(list(named.values()))
        if known is None or known_named is None:
            return self.call_in_part(node, called, given, named)
        if any(isinstance(one, range) and len(one) > _MAX_ITEMS for one in known):
            return None
        arguments = dict(zip(named, known_named, strict=True))
        if isinstance(called, type) and called not in _PLAIN:
            _require_fit(node, called, known, arguments)
        found = self.call_at(node, called, *known, **arguments)
        return Known(tuple(islice(found, _MAX_ITEMS)) if isinstance(found, Iterator) else found)

    def call_in_part(self, node: ast.Call, called: Any, given: list[Shape], named: dict[str, Shape]) -> Shape:
        """Return the result of a call with some unknown arguments."""
        return None

    def call_at(
        self, node: ast.expr | ast.stmt, function: Callable[..., Any], *given: Any, **named: Any
    ) -> Any:
        """Call an object, with the line of a node of the file as the place of the call."""
        call = ast.parse("function(*given, **named)", mode="eval")
        for part in ast.walk(call):
            if isinstance(part, ast.expr | ast.keyword):
                ast.copy_location(part, node)
        code = compile(call, str(self.path), "eval")
        return eval(code, {"function": function, "given": given, "named": named, "__builtins__": {}})


def _require_fit(node: ast.Call, callee: type, given: list[Any], named: Mapping[str, Any]) -> None:
    """Compare the arguments of a call with the signature of a class.

    Raises:
        MisfitError: they do not fit; with the parameters of the class.
    """
    taken = inspect.signature(callee)
    try:
        taken.bind(*given, **named)
    except TypeError as error:
        unknown = next((name for name in named if name not in taken.parameters), None)
        valid = list(taken.parameters)
        hint = f"; it takes {', '.join(valid)}" if unknown is None else did_you_mean(unknown, valid)
        raise MisfitError(f"{ast.unparse(node.func)}: {error}{hint}") from None


def _defaults(arguments: ast.arguments) -> Iterator[tuple[str, ast.expr]]:
    last = [*arguments.posonlyargs, *arguments.args][::-1]
    yield from ((one.arg, value) for one, value in zip(last, arguments.defaults[::-1], strict=False))
    pairs = zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)
    yield from ((one.arg, value) for one, value in pairs if value is not None)


def changed_names(tree: ast.Module) -> set[str]:
    """Return the names of a module whose values change after they are set."""
    found: set[str] = set()
    for node in ast.walk(tree):
        match node:
            case ast.Global(names):
                found.update(names)
            case ast.Call(func=ast.Attribute(ast.Name(name), method)) if method in CHANGING:
                found.add(name)
            case ast.Subscript(value=ast.Name(name), ctx=ast.Store() | ast.Del()):
                found.add(name)
    return found
