"""How functions that users give can be called."""

from __future__ import annotations

from collections.abc import Callable
from inspect import signature


def takes(function: Callable[..., object], number: int) -> bool:
    """Return whether a function can be called with a number of arguments; functions in C may not say."""
    try:
        signature(function).bind(*[None] * number)
    except ValueError:
        return True
    except TypeError:
        return False
    return True
