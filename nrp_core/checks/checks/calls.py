"""Calls of functions that ship with the language, of the user's own, and of mathematics."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from types import BuiltinFunctionType, FunctionType, MethodType
from typing import Any

from nrp_core.checks.events import Call
from nrp_core.checks.imported import full_names
from nrp_core.checks.registry import checks_function
from nrp_core.checks.shapes import Instance, Items, Known, Number, Row
from nrp_core.checks.statements import Written
from nrp_core.checks.static_experiment import CheckedFunction
from nrp_core.findings import Code, Finding, Level

_PLAIN = ("math", "builtins")
"""Modules whose functions have known signatures."""
_SEEDED = ("random.Random", "random.seed")
_CLOCKS = frozenset(
    {f"time.{name}" for name in ("time", "clock", "perf_counter", "monotonic", "process_time", "time_ns")}
    | {"datetime.datetime.now", "datetime.now", "datetime.datetime.today"}
)


@checks_function(Code.NRP240)
def calls_fit(function: CheckedFunction) -> Iterator[Finding]:
    """Compare the arguments of functions and methods with their signatures."""
    for event in function.events:
        match event:
            case Call(node, Known(callee), given, named, True) if _is_checked(callee):
                signature = inspect.signature(callee)
                try:
                    signature.bind(*given, **named)
                except TypeError as error:
                    plain = signature.replace(
                        parameters=[
                            one.replace(annotation=one.empty) for one in signature.parameters.values()
                        ],
                        return_annotation=signature.empty,
                    )
                    message = f"{callee.__name__}{plain}: {error}"
                    yield function.declared.finding(Code.NRP240, node, message)


def _is_checked(callee: Any) -> bool:
    """Return whether the arguments of calls of something are checked."""
    if isinstance(callee, Written):
        return True
    if isinstance(callee, (FunctionType, MethodType)):
        return str(callee.__module__).startswith("nrp_core.")
    return isinstance(callee, BuiltinFunctionType) and callee.__module__ in _PLAIN and _has_signature(callee)


def _has_signature(callee: Any) -> bool:
    try:
        return bool(inspect.signature(callee).parameters)
    except ValueError:
        return False


@checks_function(Code.NRP240)
def only_functions_are_called(function: CheckedFunction) -> Iterator[Finding]:
    """Look for calls of numbers, messages and devices."""
    for event in function.events:
        match event:
            case Call(node, Number() | Items() | Row()):
                pass
            case Call(node, Instance(cls)) if not any("__call__" in vars(kind) for kind in cls.__mro__):
                pass
            case Call(node, Known(value)) if not callable(value):
                pass
            case _:
                continue
        message = f"'{ast.unparse(node.func)}' is not a function and cannot be called"
        yield function.declared.finding(Code.NRP240, node, message)


@checks_function(Code.NRP243)
def nothing_depends_on_the_clock(function: CheckedFunction) -> Iterator[Finding]:
    """Look for the wall clock, and for functions that sleep."""
    imported = full_names(function.declared.source.tree)
    decisive = set(_deciding_calls(function.declared.node))
    for node in ast.walk(ast.Module(function.declared.node.body, [])):
        if not isinstance(node, ast.Call):
            continue
        name = ast.unparse(node.func)
        if not re.fullmatch(r"[\w.]+", name):
            continue  # of a result, such as a generator with its own seed
        root, _, rest = name.partition(".")
        called = ".".join(part for part in (imported.get(root, ""), rest) if part)
        if isinstance(function.declared.names.get(root), Known):
            continue  # this name is not a clock but a substitute of ours
        if called == "time.sleep":
            message = f"'{name}' stops the whole loop: simulated time stands still meanwhile"
            yield function.declared.finding(Code.NRP243, node, message, Level.WARNING)
        elif called in _CLOCKS or (called.startswith("random.") and called not in _SEEDED):
            message, level = f"'{name}' differs between runs", Level.NOTE
            if node in decisive:
                message, level = f"{message}, and what is returned depends on it", Level.WARNING
            yield function.declared.finding(Code.NRP243, node, message, level)


def _deciding_calls(node: ast.AST) -> Iterator[ast.Call]:
    """Yield the calls in conditions under which a function returns a value."""
    for one in ast.walk(node):
        if isinstance(one, ast.If) and any(
            isinstance(inner, ast.Return) and inner.value is not None for inner in ast.walk(one)
        ):
            yield from (call for call in ast.walk(one.test) if isinstance(call, ast.Call))


@checks_function(Code.NRP357)
def functions_do_not_wait(function: CheckedFunction) -> Iterator[Finding]:
    """Look for functions that sleep in simulated time, which passes between their calls only."""
    imported = full_names(function.declared.source.tree)
    for node in function.declared.own:
        if not isinstance(node, ast.Call):
            continue
        name = ast.unparse(node.func)
        root, _, rest = name.partition(".")
        if f"{imported.get(root, root)}.{rest}".strip(".") == "rospy.sleep":
            message = f"'{name}' returns at once: simulated time stands still while a transfer function runs"
            yield function.declared.finding(Code.NRP357, node, message, Level.WARNING)


@checks_function(Code.NRP243)
def nothing_depends_on_chance(function: CheckedFunction) -> Iterator[Finding]:
    """Look for the global random generators."""
    for event in function.events:
        if isinstance(event, Call) and isinstance(event.callee, Known):
            callee = event.callee.value
            module = str(getattr(getattr(callee, "__self__", None), "__class__", type(None)).__module__)
            if module.startswith("numpy.random") and not isinstance(callee, type):
                message = f"'numpy.random.{callee.__name__}' draws from a generator that all share"
                yield function.declared.finding(Code.NRP243, event.node, message, Level.NOTE)
