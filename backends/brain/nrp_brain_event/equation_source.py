"""Expressions of equations as source of compiled Python.

Compiles the kernels of equations, each once on a machine.

So a new equation costs the compilation of one small function, which the engine calls by its address.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import sys
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Final

from nrp_brain_event.handles import address_of
from nrp_core._support.cache import mark_used
from nrp_core._support.jit import COMPILED, cache_folder
from nrp_core.network.equations.expressions import RANDOM, STEP, TIME, WEIGHT, names_in
from nrp_core.network.equations.model import Model
from nrp_core.network.equations.synapse import SHARE, SynapseModel

Arguments = tuple[tuple[str, str], ...]
"""Names of arguments, and their types for :func:`nrp_core._support.jit.c_function`."""
_UNBOUNDED: Final = 1 << 59
"""The length of an array behind a pointer, whose length is not known; bytes of it fit into 64 bits."""


@cache
def compiled(source: str, name: str, arguments: Arguments) -> int:
    """Return the argument with which :func:`~nrp_brain_event.handles.call` calls a function.

    Args:
        source: the module of the function.
        name: the name of the function, which returns an integer.
        arguments: its arguments.
    """
    kernel = _imported(source + _entry(name, arguments), name)
    return address_of(kernel, tuple(kind for _, kind in arguments))


def _imported(source: str, function: str) -> Callable[..., int]:
    """Return the function of a module, which is kept as a file because Numba keeps code by files."""
    name = f"nrp_brain_event_equations_{hashlib.blake2b(source.encode(), digest_size=12).hexdigest()}"
    specification = importlib.util.spec_from_file_location(name, _written(source, name))
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module  # Numba restores compiled code by the name of its module
    specification.loader.exec_module(module)
    entry: Callable[..., int] = getattr(module, "entry" if COMPILED else function)
    return entry


def _written(source: str, name: str) -> Path:
    folder = cache_folder() / name
    folder.mkdir(parents=True, exist_ok=True)
    mark_used(folder)
    path = folder / f"{name}.py"
    if not path.exists():
        with NamedTemporaryFile("w", dir=folder, delete=False, encoding="utf-8") as file:
            file.write(source)
        Path(file.name).replace(path)
    return path


def _entry(function: str, arguments: Arguments) -> str:
    """Return the source of the function that is called from outside, with pointers instead of arrays."""
    if not COMPILED:
        return ""
    names = [name for name, _ in arguments]
    passed = [f"carray({name}, {_UNBOUNDED})" if kind.startswith("*") else name for name, kind in arguments]
    return (
        f"\n\nfrom numba import carray\n\n\ndef entry({', '.join(names)}):\n"
        f"    return {function}({', '.join(passed)})\n"
    )


STATE: Final = "x_"
DEFINITION: Final = "d_"
PARAMETER: Final = "p_"
IMPORTS: Final = """
from math import (
    acos, asin, atan, ceil, cos, cosh, exp, expm1, floor, inf, log, log1p, log10, sin, sinh, sqrt, tan, tanh
)

from nrp_brain_event.equation_functions import driven, exprel, sign
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
        state: the prefix of the names of state variables.
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
