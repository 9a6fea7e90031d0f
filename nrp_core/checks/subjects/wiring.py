"""Unset sources, topics with two publishers, waiting functions, and latencies.

The first and the third are found in the source of functions, because five steps of a dry run do not show
them.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Final

from nrp_core.checks.examined import ExaminedExperiment, ExaminedFunction, checks_function, checks_functions
from nrp_core.cle.latency import paths
from nrp_core.clock import milliseconds
from nrp_core.dsl.functions import TransferFunction
from nrp_core.dsl.mappings import MapSpikeSource
from nrp_core.findings import Code, Finding, Level

_WIRING: Final = {"connector", "weight", "delay", "receptor_type", "synapse_type"}
"""Settings of a source that make no spikes."""
_WAITING: Final = {
    "time.sleep": "stops the whole loop: simulated time stands still meanwhile",
    "rospy.sleep": "returns at once: simulated time stands still while a transfer function runs",
}


@checks_functions
def report_latency(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report the latency of each path from a sensor to an actuator."""
    timestep_ms = milliseconds(examined.experiment.timestep)
    for path in paths([one.function for one in examined.functions if one.function.active]):
        last = next(one for one in examined.functions if one.function.name == path.via[-1])
        message = f"{path} of {timestep_ms:g} ms, {path.steps * timestep_ms:g} ms in all"
        yield last.finding(Code.NRP238, message, Level.NOTE)


@checks_functions
def check_publishers(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report topics that two functions publish on, or one function twice."""
    first: dict[str, tuple[TransferFunction, str]] = {}
    for one in examined.functions:
        function = one.function
        for topic, parameter in sorted(one.written) if function.active else ():
            other, _ = found = first.setdefault(topic, (function, parameter))
            if found != (function, parameter):
                twice = f"'{function.name}' publishes on '{topic}' twice"
                also = f"'{function.name}' publishes on '{topic}', as '{other.name}' does"
                yield one.finding(Code.NRP229, twice if other is function else also, parameter=parameter)


@checks_function
def check_sources(function: ExaminedFunction) -> Iterator[Finding]:
    """Report sources that a body never sets, and sources whose spikes have no effect."""
    body = body_of(function.function)
    only_read = set() if body is None else _only_read(body, function.function.parameters)
    for name, mapping in function.function.mappings.items():
        if not isinstance(mapping, MapSpikeSource):
            continue
        weight = mapping.options.get("weight")
        is_silent = not (name in function.function.triggers or set(mapping.options) - _WIRING)
        if name in only_read and is_silent:
            message = f"nothing sets the source '{name}': it stays silent"
        elif isinstance(weight, int | float) and weight == 0:
            message = f"the weight of the source '{name}' is 0: its spikes have no effect"
        else:
            continue
        yield function.finding(Code.NRP231, message, parameter=name)


@checks_function
def check_waiting(function: ExaminedFunction) -> Iterator[Finding]:
    """Report calls that wait."""
    body = body_of(function.function)
    for node in () if body is None else ast.walk(body):
        match node:
            case ast.Call(ast.Attribute(ast.Name(module), "sleep")) if f"{module}.sleep" in _WAITING:
                name = f"{module}.sleep"
                message = f"'{name}' {_WAITING[name]}"
                yield function.finding(Code.NRP357, message, line=node.lineno)


def body_of(function: TransferFunction) -> ast.Module | None:
    """Return the statements of a function in a Python file; None if they are written in another language."""
    path = Path(function.place.path)
    try:
        found = _functions_in(path, path.stat().st_mtime_ns) if path.suffix == ".py" else {}
    except (OSError, SyntaxError, ValueError):  # it has changed since, or is in an older Python
        return None
    return found.get(function.place.line)


@lru_cache(maxsize=1)
def _functions_in(path: Path, _changed_ns: int) -> dict[int, ast.Module]:
    """Return the statements of each function of a file, by the line of its first decorator."""
    tree = ast.parse(path.read_bytes())
    nodes = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    return {
        min([node.lineno, *(one.lineno for one in node.decorator_list)]): ast.Module(node.body, [])
        for node in nodes
    }


def _only_read(body: ast.Module, parameters: tuple[str, ...]) -> set[str]:
    """Return the parameters whose attributes the body at most reads; a method call may set them."""
    parents = {id(child): node for node in ast.walk(body) for child in ast.iter_child_nodes(node)}
    others: set[str] = set()
    for node in ast.walk(body):
        if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Store):
            parent = parents.get(id(node))
            reads = isinstance(parent, ast.Attribute) and isinstance(parent.ctx, ast.Load)
            if not reads or isinstance(parents.get(id(parent)), ast.Call | ast.Subscript):
                others.add(node.id)
    return set(parameters) - others
