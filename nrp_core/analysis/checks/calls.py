"""Calls of functions that ship with the language."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from types import FunctionType, MethodType

from nrp_core.analysis.events import Call
from nrp_core.analysis.registry import checks_function
from nrp_core.analysis.shapes import Known
from nrp_core.analysis.study import Examined
from nrp_core.findings import Code, Finding, Level


@checks_function(Code.NRP240)
def calls_fit(function: Examined) -> Iterator[Finding]:
    """Compare the arguments of our own functions and methods with what they take."""
    for event in function.events:
        match event:
            case Call(node, Known(FunctionType() | MethodType() as callee), given, named, True):
                if not str(callee.__module__).startswith("nrp_core."):
                    continue
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


@checks_function(Code.NRP243)
def nothing_depends_on_chance(function: Examined) -> Iterator[Finding]:
    """Look for the wall clock and for generators that all share."""
    for event in function.events:
        if isinstance(event, Call) and isinstance(event.callee, Known):
            callee = event.callee.value
            module = str(getattr(getattr(callee, "__self__", None), "__class__", type(None)).__module__)
            if module.startswith("numpy.random") and not isinstance(callee, type):
                message = f"'numpy.random.{callee.__name__}' draws from a generator that all share"
                yield function.declared.finding(Code.NRP243, event.node, message, Level.NOTE)
