"""Names of a package that are imported when they are first used (PEP 562)."""

from __future__ import annotations

import sys
from importlib import import_module

from nrp_core._support.collector import CollectorPaused

# does not import typing or collections.abc: every program that imports nrp_core would pay for them
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any


def lazily(package: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return ``__getattr__``, ``__dir__`` and ``__all__`` of a package.

    Its names are those that its file imports for type checkers, each in a line of its own,
    ``from module import name as name``; a submodule counts as a name.

    Args:
        package: its ``__name__``.
    """
    home_of = _homes(package)
    public = sorted(home_of)

    def get(name: str) -> Any:
        home = home_of.get(name)
        if home is None:
            raise AttributeError(
                f"module '{package}' has no attribute '{name}'", name=name, obj=sys.modules[package]
            )
        with CollectorPaused():
            module = import_module(home)
            value = vars(module)[name] if name in vars(module) else import_module(f"{home}.{name}")
        setattr(sys.modules[package], name, value)
        return value

    def names() -> list[str]:
        return sorted({*vars(sys.modules[package]), *public})

    return get, names, public


def _homes(package: str) -> dict[str, str]:
    """Return the module of each name that a package imports for type checkers."""
    spec: Any = sys.modules[package].__spec__
    lines = spec.loader.get_data(spec.origin).decode().splitlines()
    imports = [line.split() for line in lines if line.startswith("    from ") and " as " in line]
    return {name: home for _, home, _, name, _, _ in imports}
