"""Follow the statements of a file as far as possible without running it.

Constants, loops over them, and calls of the file's own functions are followed. Of all other statements only
the names that they set are known, not the values.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from inspect import Parameter, Signature
from pathlib import Path
from typing import Any

from nrp_core.checks.evaluation import FAILURES, Evaluation, UnreadableError, items_of, truth_of, value_of
from nrp_core.checks.events import Call
from nrp_core.checks.function_body import assigned
from nrp_core.checks.scopes import SCOPES, own_nodes
from nrp_core.checks.shapes import UNKNOWN, Known, Row, Shape

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
        self.__signature__ = _signature(node.args, defaults)

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


def _signature(arguments: ast.arguments, defaults: Mapping[str, Shape]) -> Signature:
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
