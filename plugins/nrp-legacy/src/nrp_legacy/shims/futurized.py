"""``past`` and ``future``: code that a tool converted from Python 2 imports them; Python 3 needs neither."""

from __future__ import annotations

from functools import reduce
from numbers import Integral
from types import ModuleType
from typing import Any

from nrp_legacy import builtins2
from nrp_legacy.shims.modules import module
from nrp_legacy.shims.overlay import nothing, overlay

_OF_PAST = ("basestring", "cmp", "long", "raw_input", "reload", "unichr", "unicode", "xrange")
_OF_MAPPINGS = ("items", "keys", "values")


def old_div(left: Any, right: Any) -> Any:
    """Divide as Python 2: of two integers, the quotient rounded down; arrays are divided as in Python 3."""
    are_whole = isinstance(left, Integral) and isinstance(right, Integral)
    return left // right if are_whole else left / right


def futurized_modules() -> dict[str, ModuleType]:
    """Return the modules by their names."""
    past = {name: getattr(builtins2, name) for name in _OF_PAST}
    utils = module(
        "future.utils",
        PY2=False,
        PY3=True,
        native_str=str,
        string_types=(str,),
        text_type=str,
        binary_type=bytes,
        integer_types=(int,),
        old_div=old_div,
        lrange=lambda *bounds: list(range(*bounds)),
        lmap=lambda *values: list(map(*values)),
        lzip=lambda *items: list(zip(*items, strict=False)),
        lfilter=lambda *values: list(filter(*values)),
        **{f"iter{name}": lambda one, name=name: iter(getattr(one, name)()) for name in _OF_MAPPINGS},
        **{f"view{name}": lambda one, name=name: getattr(one, name)() for name in _OF_MAPPINGS},
        **{f"list{name}": lambda one, name=name: list(getattr(one, name)()) for name in _OF_MAPPINGS},
    )
    return {
        "past": module("past"),
        "past.utils": module("past.utils", old_div=old_div, PY2=False, PY3=True),
        "past.builtins": overlay("past.builtins", {**past, "reduce": reduce}, real="builtins"),
        "future": module("future"),
        "future.standard_library": module(
            "future.standard_library", install_aliases=nothing, install_hooks=nothing
        ),
        "future.utils": utils,
        "future.builtins": overlay("future.builtins", real="builtins"),
    }
