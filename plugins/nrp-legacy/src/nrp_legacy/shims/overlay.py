"""Modules with additional names over those of a real one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from types import ModuleType
from typing import Any

from nrp_legacy.shims.modules import module


def overlay(
    name: str,
    own: Mapping[str, Any] | None = None,
    old: Callable[[ModuleType, str], Any] | None = None,
    *,
    real: str | None = None,
) -> ModuleType:
    """Return a module with the names of a real one, which is imported when one of them is used.

    Args:
        name: its name.
        own: names that replace those of the real one.
        old: returns the object for a removed name; raises ``AttributeError`` or ``KeyError`` if there is
            none.
        real: the name of the real one, if it differs.
    """
    made = module(name, **(own or {}))

    def attribute(child: str) -> Any:
        here = import_module(real or name)
        try:
            return getattr(here, child)
        except AttributeError:
            if old is None:
                raise
        try:
            return old(here, child)
        except KeyError:
            raise AttributeError(f"module '{name}' has no attribute '{child}'") from None

    vars(made)["__getattr__"] = attribute
    vars(made)["__dir__"] = lambda: sorted({*vars(made), *dir(import_module(real or name))})
    return made


def renamed(**names: str) -> Callable[[ModuleType, str], Any]:
    """Return a function that finds objects by old names."""
    return lambda here, name: getattr(here, names[name])


def nothing(*_values: Any, **_fields: Any) -> None:
    """Do nothing, because it is not needed here."""
