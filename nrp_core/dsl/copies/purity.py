"""Which functions may be called once for all copies: those that only compute, as their code shows."""

from __future__ import annotations

import dis
import math
import sys
from collections.abc import Iterator, Sequence
from types import CodeType, FunctionType, ModuleType
from typing import Any, Final

import numpy as np

from nrp_core.dsl import tf_lib
from nrp_core.dsl.across import BUILTINS
from nrp_core.world.messages.base import message_classes, type_name

_REFUSED: Final = {
    "STORE_GLOBAL": "it sets a global variable",
    "DELETE_GLOBAL": "it deletes a global variable",
    "STORE_SUBSCR": "it sets items of an object",
    "DELETE_SUBSCR": "it deletes items of an object",
    "DELETE_ATTR": "it deletes an attribute",
    "IMPORT_NAME": "it imports a module",
    "MAKE_FUNCTION": "it makes a function",
    "LOAD_BUILD_CLASS": "it makes a class",
    "LOAD_DEREF": "it uses variables of another function",
    "STORE_DEREF": "it sets variables of another function",
}
_CHANGING: Final = frozenset(
    {"add", "append", "at", "cam", "copyto", "fill", "fill_diagonal", "fromfile", "insert", "load", "loadtxt",
     "partition", "place", "put", "putmask", "random", "resize", "save", "savetxt", "savez", "setbufsize",
     "seterr", "seterrcall", "setflags", "sort", "tofile"}
)  # fmt: skip
"""Names in NumPy and ``tf_lib`` that have state or change an object, or do so as methods of others."""
_METHODS: Final = frozenset(
    {"astype", "copy", "flatten", "item", "ravel", "reshape", "send_message", "tolist"}
)
_CONSTANTS: Final = (bool, int, float, str, type(None))
_PURE: Final = (np, math, tf_lib)
_PACKAGES: Final = ("numpy", "math", "nrp_core", "hbp_nrp_client")


def obstacle(functions: Sequence[FunctionType]) -> str:
    """Return why a function cannot be called once for all copies, empty if it may be.

    Args:
        functions: the function in each copy, whose file was executed for each.
    """
    code = functions[0].__code__
    if any(function.__code__ != code for function in functions):
        return "it differs between copies"
    return _in_code(code) or next(_in_globals(functions), "")


def _in_code(code: CodeType) -> str:
    if code.co_exceptiontable:
        return "it catches errors or has a 'with' block"
    if code.co_flags & (0x20 | 0x80 | 0x200):
        return "it is a generator"
    before = None
    for step in dis.get_instructions(code):
        if step.opname in _REFUSED:
            return _REFUSED[step.opname]
        if step.opname == "STORE_ATTR" and (before is None or not before.opname.startswith("LOAD_FAST")):
            return f"it sets the attribute '{step.argval}' within an object"
        if step.opname == "IS_OP" and (
            before is None or (before.opname, before.argval) != ("LOAD_CONST", None)
        ):
            return "it compares objects by 'is'"
        if _is_of_method(step) and not _only_computes(step.argval):
            return f"it calls '{step.argval}', which may change something"
        before = step
    return ""


def _is_of_method(step: dis.Instruction) -> bool:
    """Return whether an instruction reads an attribute to call it."""
    return step.opname == "LOAD_METHOD" or (  # since Python 3.12 both are one, with a flag
        sys.version_info >= (3, 12) and step.opname == "LOAD_ATTR" and bool((step.arg or 0) & 1)
    )


def _only_computes(name: str) -> bool:
    if name in _CHANGING:
        return False
    messages = {kind.__name__ for kind in message_classes()}
    return name in _METHODS or name in messages or any(hasattr(module, name) for module in _PURE)


def _in_globals(functions: Sequence[FunctionType]) -> Iterator[str]:
    """Yield why the global names that a function uses do not allow it."""
    first = functions[0]
    for step in dis.get_instructions(first.__code__):
        if step.opname not in ("LOAD_GLOBAL", "LOAD_NAME"):
            continue
        name = step.argval
        values = [function.__globals__.get(name, _MISSING) for function in functions]
        if values[0] is _MISSING:
            if name not in BUILTINS:
                yield f"it uses '{name}'"
        elif isinstance(values[0], FunctionType):
            if values[0] in (first, *_known(name)):
                continue
            if not all(isinstance(value, FunctionType) for value in values):
                yield f"'{name}' differs between copies"
            elif reason := obstacle(values):
                yield f"its function '{name}': {reason}"
        elif reason := _in_value(name, values):
            yield reason


def _known(name: str) -> tuple[Any, ...]:
    return (getattr(tf_lib, name),) if name in tf_lib.__all__ else ()


def _in_value(name: str, values: Sequence[Any]) -> str:
    first = values[0]
    if isinstance(first, _CONSTANTS):
        same = all(type(value) is type(first) and value == first for value in values)
        return "" if same else f"'{name}' differs between copies"
    if isinstance(first, ModuleType):  # the language makes its modules for each file anew
        alike = all(isinstance(value, ModuleType) and value.__name__ == first.__name__ for value in values)
        return "" if alike and _is_safe(first) else f"it uses the module '{name}'"
    if not all(value is first for value in values):
        return f"'{name}' is an object of each copy"
    if isinstance(first, np.ufunc) or first in message_classes() or _is_of_numpy(first):
        return ""
    return f"it uses the object '{name}'"


def _is_safe(module: ModuleType) -> bool:
    """Return whether nothing in a module has state, but for names that are refused anyway."""
    package = module.__name__.partition(".")[0]
    return package in _PACKAGES or package in {
        type_name(kind).partition("/")[0] for kind in message_classes()
    }


def _is_of_numpy(value: Any) -> bool:
    name = getattr(value, "__name__", "")
    return bool(name) and name not in _CHANGING and getattr(np, name, None) is value


_MISSING: Final = object()
