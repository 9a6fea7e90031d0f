"""A transfer function as it is written."""

from __future__ import annotations

import ast
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from nrp_core.checks.imported import ImportsOf
from nrp_core.checks.scopes import own_nodes
from nrp_core.checks.shapes import Shape
from nrp_core.dsl.functions.decorators import Robot2Neuron
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.dsl.loading.listing import PythonSource
from nrp_core.dsl.parameters.adapter import Adapter
from nrp_core.dsl.parameters.binding import Binding, Mapping
from nrp_core.errors import Instead
from nrp_core.findings import Code, Finding, Level

Function = ast.FunctionDef | ast.AsyncFunctionDef


class Unread(Mapping):
    """A mapping with an unknown target."""

    def __call__(self, function: Any) -> TransferFunction:
        """Return the transfer function with the mapping added."""
        made = function if isinstance(function, TransferFunction) else Robot2Neuron()(function)
        made.add(self)
        return made

    def _do_bind(self, binding: Binding) -> Adapter:
        return Adapter()

    def __str__(self) -> str:
        return "known only when it runs"


@dataclass(slots=True)
class Declared:
    """A transfer function as it is written.

    Args:
        function: the transfer function with an empty body.
        node: its syntax tree.
        source: the file.
        names: the shapes of the names that its body sees, parameters aside.
        nodes: the decorator of each mapping, and the function's own under an empty name.
        imports: returns the names that an import in its body binds.
        is_read: whether all of its decorators are understood.
        is_named: whether its name is known: a decorator or a statement of the file may have changed it.
        adapters: the adapters of its parameters, after binding.

    Attributes:
        own: the nodes of its body, last first, without the bodies of functions and classes in it.
    """

    function: TransferFunction
    node: Function
    source: PythonSource
    names: dict[str, Shape]
    nodes: dict[str, ast.expr]
    imports: ImportsOf
    is_read: bool = True
    is_named: bool = True
    adapters: dict[str, Adapter] = field(default_factory=dict)
    own: tuple[ast.AST, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.own = tuple(own_nodes(self.node.body))

    def finding(
        self,
        code: Code,
        node: ast.AST | None,
        message: str,
        level: Level = Level.ERROR,
        instead: Instead | None = None,
    ) -> Finding:
        """Return a finding about something in it."""
        return found_in(self.source, code, node or self.node, message, level, instead)

    def parameter(self, name: str) -> ast.arg:
        """Return the place of a parameter."""
        return next(one for one in self.node.args.args if one.arg == name)


def found_in(
    source: PythonSource,
    code: Code,
    node: ast.AST,
    message: str,
    level: Level = Level.ERROR,
    instead: Instead | None = None,
) -> Finding:
    """Return a finding about a node of a source."""
    line, column = getattr(node, "lineno", None), getattr(node, "col_offset", 0) + 1
    where = source.path, line, column if source.has_columns else None
    return Finding(code, message, level, *where, instead=instead)


def stub_of(node: Function, path: Path) -> Any:
    """Return a function with the same parameters and an empty body."""
    yields = any(isinstance(one, (ast.Yield, ast.YieldFrom)) for one in own_nodes(node.body))
    body = ast.Expr(ast.Yield(None)) if yields else ast.Pass()
    parameters = ast.arguments(
        posonlyargs=[ast.arg(one.arg) for one in node.args.posonlyargs],
        args=[ast.arg(one.arg) for one in node.args.args],
        vararg=ast.arg(node.args.vararg.arg) if node.args.vararg else None,
        kwonlyargs=[ast.arg(one.arg) for one in node.args.kwonlyargs],
        kw_defaults=[None for _ in node.args.kwonlyargs],
        kwarg=ast.arg(node.args.kwarg.arg) if node.args.kwarg else None,
        defaults=[],
    )
    stub = type(node)(node.name, parameters, [body], [])
    for part in ast.walk(stub):
        ast.copy_location(part, node)
    names: dict[str, Any] = {"__builtins__": {}}
    exec(compile(ast.Module([stub], []), str(path), "exec"), names)
    return names[node.name]
