"""Follow the statements of a file as far as possible without running it.

Constants, loops over them, and calls of the file's own functions are followed. Of all other statements only
the names that they set are known, not the values.
"""

from __future__ import annotations

import ast
import inspect
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping
from inspect import Parameter, Signature
from itertools import count, islice
from pathlib import Path
from typing import Any

from nrp_core.checks.code.expressions import Expressions, assigned
from nrp_core.checks.code.shapes import NEURONS, UNKNOWN, Call, Known, Row, Shape, joined
from nrp_core.checks.code.syntax import SCOPES, own_nodes
from nrp_core.errors import NrpError, UnreadableError, did_you_mean

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


_DEPTH, _STATEMENTS = 20, 20_000
"""Limits of the depth of calls and of the number of statements that are followed."""
CHANGING = frozenset(
    {"append", "extend", "insert", "remove", "pop", "popitem", "clear", "sort", "reverse", "update", "add",
     "discard", "setdefault", "appendleft", "popleft", "extendleft", "rotate", "fill"}
)  # fmt: skip
"""Methods that change their object."""
_NO_PLAIN_FUNCTION = (ast.Yield, ast.YieldFrom, ast.Await, ast.Global, ast.Nonlocal)


class _Elided:
    """Marks a default value in the signature of a function."""

    def __repr__(self) -> str:
        return "..."


_ELIDED = _Elided()


class _Left(Exception):  # noqa: N818 - nothing is wrong
    """A loop or a function is left; ``value`` is the return value."""

    def __init__(self, way: type[ast.stmt], value: Shape = UNKNOWN) -> None:
        super().__init__()
        self.way, self.value = way, value


class Written:
    """A function of the user, which is read and not executed.

    Args:
        node: its syntax tree.
        reader: the reader of its file.
        names: the names of the enclosing functions.
        defaults: its optional parameters with their default values.

    Attributes:
        is_followed: whether it was called and every call could be followed.
    """

    def __init__(
        self, node: ast.FunctionDef, reader: Statements, names: Mapping[str, Shape],
        defaults: Mapping[str, Shape],
    ) -> None:  # fmt: skip
        self.node, self.names, self.defaults = node, dict(names), dict(defaults)
        self._reader = reader
        self.is_called = self.is_lost = False
        self.__name__ = node.name
        self.__signature__ = _signature_of(node.args, defaults)

    @property
    def is_followed(self) -> bool:
        return self.is_called and not self.is_lost

    def __call__(self, *given: Any, **named: Any) -> Any:
        """Return its result for known arguments.

        Raises:
            UnreadableError: the result is known only when it is executed.
        """
        reader = type(self._reader).__new__(type(self._reader))
        vars(reader).update(vars(self._reader))
        shapes = {name: Known(value) for name, value in named.items()}
        return value_of(reader.run(self, tuple(map(Known, given)), shapes))


class Statements(Evaluation):
    """Follows statements.

    Args:
        names: the shape of each name.
        ours: the objects that may be called.
        path: the file, for errors.
        changed: names whose values change while the file or its functions run.
    """

    def __init__(
        self, names: Mapping[str, Shape], ours: Iterable[Any], path: Path, changed: Iterable[str] = ()
    ) -> None:
        super().__init__(names, ours, path)
        self.written: list[Written] = []
        self._hidden = frozenset(changed)
        self._module: dict[str, Shape] = self.names
        self._depth, self._count = 0, 0

    def follow_file(self, statements: Iterable[ast.stmt]) -> None:
        """Follow the statements of a file, each as far as possible."""
        for statement in statements:
            self._count = 0
            try:
                self.follow([statement])
            except UnreadableError:
                self.skip(statement)

    def follow(self, statements: Iterable[ast.stmt]) -> None:
        """Follow statements in order.

        Raises:
            UnreadableError: the next statement is known only when they are executed.
        """
        for statement in statements:
            self._count += 1
            if self._count > _STATEMENTS:
                raise UnreadableError("it has too many steps")
            self.statement(statement)

    def statement(self, node: ast.stmt) -> None:
        """Follow a statement."""
        getattr(self, f"_do_{type(node).__name__.lower()}", self.skip)(node)

    def _do_pass(self, node: ast.Pass) -> None:
        pass

    def _do_expr(self, node: ast.Expr) -> None:
        self.quietly(node.value)

    def _do_assign(self, node: ast.Assign) -> None:
        found = self.quietly(node.value)
        for target in node.targets:
            self.bind(target, found)

    def _do_annassign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.bind(node.target, self.quietly(node.value))

    def _do_augassign(self, node: ast.AugAssign) -> None:
        if isinstance(node.target, ast.Name):
            before = ast.copy_location(ast.Name(node.target.id, ast.Load()), node)
            together = ast.copy_location(ast.BinOp(before, node.op, node.value), node)
            self.bind(node.target, self.quietly(together))

    def _do_functiondef(self, node: ast.FunctionDef) -> None:
        self.names[node.name] = UNKNOWN if node.decorator_list else self._defined(node)

    def _do_asyncfunctiondef(self, node: ast.AsyncFunctionDef | ast.ClassDef) -> None:
        self.names[node.name] = UNKNOWN

    _do_classdef = _do_asyncfunctiondef

    def _do_if(self, node: ast.If) -> None:
        decided = truth_of(self.quietly(node.test))
        if decided is None:
            self.skip(node)
        else:
            self.follow(node.body if decided else node.orelse)

    def _do_return(self, node: ast.Return) -> None:
        raise _Left(ast.Return, Known(None) if node.value is None else self.shape(node.value))

    def _do_break(self, node: ast.Break | ast.Continue) -> None:
        raise _Left(type(node))

    _do_continue = _do_break

    def bind(self, target: ast.expr, shape: Shape) -> None:
        if isinstance(target, ast.Name) and target.id in self._hidden:
            shape = UNKNOWN
        super().bind(target, shape)

    def skip(self, node: ast.stmt) -> None:
        """Skip a statement whose effect is known only when it is executed.

        Raises:
            UnreadableError: the next statement is also known only then.
        """
        for one in ast.walk(node):
            if isinstance(one, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
                self.names[one.name] = UNKNOWN
            if isinstance(one, (ast.Import, ast.ImportFrom)):
                names = [alias.asname or alias.name.partition(".")[0] for alias in one.names]
                self.names.update(dict.fromkeys(names, UNKNOWN))
        self.names.update(dict.fromkeys(assigned([node]), UNKNOWN))
        if _may_leave(node):
            raise UnreadableError("it may end here")

    def quietly(self, node: ast.expr) -> Shape:
        """Return the shape of an expression; unknown if it fails."""
        try:
            return self.shape(node)
        except FAILURES:
            return UNKNOWN

    def _do_for(self, node: ast.For) -> None:
        items = items_of(self.quietly(node.iter))
        if items is None:
            self.skip(node)
            return
        try:
            for item in items:
                self.bind(node.target, item)
                try:
                    self.follow(node.body)
                except _Left as left:
                    if left.way is not ast.Continue:
                        raise
        except _Left as left:
            if left.way is not ast.Break:
                raise
            return
        except UnreadableError:
            self.skip(node)
            return
        self.follow(node.orelse)

    # -- functions of the user

    def _defined(self, node: ast.FunctionDef) -> Shape:
        if any(isinstance(one, _NO_PLAIN_FUNCTION) for one in own_nodes(ast.iter_child_nodes(node))):
            return UNKNOWN
        parts = node.args
        last = [*parts.posonlyargs, *parts.args][::-1]
        defaults = {
            one.arg: self.quietly(value) for one, value in zip(last, parts.defaults[::-1], strict=False)
        }
        for one, value in zip(parts.kwonlyargs, parts.kw_defaults, strict=True):
            if value is not None:
                defaults[one.arg] = self.quietly(value)
        made = Written(node, self, self.local, defaults)
        self.written.append(made)
        return Known(made)

    def called(self, call: Call) -> Shape:
        written = call.callee.value if isinstance(call.callee, Known) else None
        if not isinstance(written, Written) or not call.is_whole:
            return super().called(call)
        try:
            return self.run(written, call.given, call.named)
        except (UnreadableError, _Left):
            written.is_lost = True
            return UNKNOWN

    def run(self, written: Written, given: tuple[Shape, ...], named: Mapping[str, Shape]) -> Shape:
        """Return the result of a function.

        Raises:
            TypeError: it does not take these arguments.
            UnreadableError: it cannot be followed.
        """
        arguments = _arguments(written, given, named)
        if self._depth >= _DEPTH:
            raise UnreadableError("it calls itself too deeply")
        outer = self.names
        self._module = self._module if self._depth else outer
        self.names = {**self._module, **written.names, **arguments}
        self._depth += 1
        try:
            self.follow(written.node.body)
            found: Shape = Known(None)
        except _Left as left:
            if left.way is not ast.Return:
                raise
            found = left.value
        finally:
            self._depth -= 1
            self.names = outer
        written.is_called = True
        return found

    @property
    def local(self) -> dict[str, Shape]:
        """The names of the function that is followed, which may still grow; empty outside functions."""
        return self.names if self._depth else {}


def changed_in(tree: ast.Module) -> set[str]:
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


def _arguments(written: Written, given: tuple[Shape, ...], named: Mapping[str, Shape]) -> dict[str, Shape]:
    bound = written.__signature__.bind(*given, **named).arguments
    kinds = {one.name: one.kind for one in written.__signature__.parameters.values()}
    found: dict[str, Shape] = dict(written.defaults)
    for name, kind in kinds.items():
        if kind is Parameter.VAR_POSITIONAL:
            found[name] = Row(tuple(bound.get(name, ())))
        elif kind is Parameter.VAR_KEYWORD:
            found[name] = UNKNOWN
        elif name in bound:
            found[name] = bound[name]
    return found


def _signature_of(arguments: ast.arguments, defaults: Mapping[str, Shape]) -> Signature:
    def parameter(one: ast.arg, kind: Any) -> Parameter:
        return Parameter(one.arg, kind, default=_ELIDED if one.arg in defaults else Parameter.empty)

    made = [parameter(one, Parameter.POSITIONAL_ONLY) for one in arguments.posonlyargs]
    made += [parameter(one, Parameter.POSITIONAL_OR_KEYWORD) for one in arguments.args]
    if arguments.vararg:
        made.append(parameter(arguments.vararg, Parameter.VAR_POSITIONAL))
    made += [parameter(one, Parameter.KEYWORD_ONLY) for one in arguments.kwonlyargs]
    if arguments.kwarg:
        made.append(parameter(arguments.kwarg, Parameter.VAR_KEYWORD))
    return Signature(made)


def _may_leave(node: ast.AST, in_loop: bool = False) -> bool:
    """Return whether statements may leave the enclosing loop or function."""
    if isinstance(node, SCOPES):
        return False
    if isinstance(node, (ast.Break, ast.Continue)):
        return not in_loop
    in_loop = in_loop or isinstance(node, (ast.For, ast.AsyncFor, ast.While))
    return isinstance(node, ast.Return) or any(
        _may_leave(child, in_loop) for child in ast.iter_child_nodes(node)
    )
