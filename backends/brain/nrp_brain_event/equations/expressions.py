"""Expressions of equations as source of compiled Python."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from typing import Final

from nrp_core.brain.network.equations.expressions import RANDOM, STEP, TIME, WEIGHT, names_in
from nrp_core.brain.network.equations.model import Model
from nrp_core.brain.network.equations.synapse import SHARE, SynapseModel

STATE: Final = "x_"
DEFINITION: Final = "d_"
PARAMETER: Final = "p_"
IMPORTS: Final = """
from math import (
    acos, asin, atan, ceil, cos, cosh, exp, expm1, floor, inf, log, log1p, log10, sin, sinh, sqrt, tan, tanh
)

from nrp_brain_event.equations.functions import driven, exprel, sign
from nrp_brain_event.random_numbers import uniform_at
from nrp_core._support.jit import fma, jit
"""
"""The names in the source of a kernel."""
_UNCHANGED: Final = frozenset({TIME, WEIGHT, RANDOM, STEP})
_OTHER_NAMES: Final = {"arcsin": "asin", "arccos": "acos", "arctan": "atan"}


def source_of(node: ast.expr, model: Model | SynapseModel, state: str = STATE) -> str:
    """Return the source of an expression.

    Args:
        node: the expression.
        model: the cell or synapse.
        state: what the names of state variables begin with.
    """
    return ast.unparse(ast.fix_missing_locations(_Renamed(model, state).visit(ast.parse(ast.unparse(node)))))


def needed(nodes: Iterable[ast.expr], model: Model | SynapseModel, state: str = STATE) -> Iterator[str]:
    """Yield the assignments of the definitions that expressions need, in order."""
    wanted: set[str] = set()
    waiting = list(nodes)
    while waiting:
        for name in names_in(waiting.pop()):
            if name in model.definitions and name not in wanted:
                wanted.add(name)
                waiting.append(model.definitions[name])
    for name, node in model.definitions.items():
        if name in wanted:
            yield f"{DEFINITION}{name} = {source_of(node, model, state)}"


class _Renamed(ast.NodeTransformer):
    def __init__(self, model: Model | SynapseModel, state: str) -> None:
        self._model, self._state = model, state

    def visit_Name(self, node: ast.Name) -> ast.Name:
        if node.id in _UNCHANGED or (node.id == SHARE and isinstance(self._model, SynapseModel)):
            return node
        kinds = {self._state: self._model.variables, DEFINITION: self._model.definitions}
        prefix = next((prefix for prefix, names in kinds.items() if node.id in names), PARAMETER)
        return ast.Name(prefix + node.id, node.ctx)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        assert isinstance(node.func, ast.Name)
        arguments = [self.visit(argument) for argument in node.args]
        if node.func.id == "clip":
            lowest = ast.Call(ast.Name("max"), arguments[:2], [])
            return ast.Call(ast.Name("min"), [lowest, arguments[2]], [])
        name = node.func.id
        return ast.Call(ast.Name(_OTHER_NAMES.get(name, name)), arguments, [])
