"""Pages of the API reference: one for each public module, made from its ``__all__``."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator
from pathlib import PurePosixPath
from types import ModuleType
from typing import Any

from pages import write_page
from roles import to_markdown

MODULES = ("nrp_core", "nrp_core.brain", "nrp_core.world")


def write_reference() -> list[str]:
    """Write the pages.

    Returns:
        Their paths.
    """
    written = []
    for name in MODULES:
        module = importlib.import_module(name)
        if not hasattr(module, "__all__"):
            print(f"{name} has no __all__, so the reference has no page of it")
            continue
        page = PurePosixPath("reference", "python", f"{name}.md")
        write_page(page, _page(module))
        written.append(str(page))
    return written


def _page(module: ModuleType) -> str:
    about = to_markdown(inspect.cleandoc(module.__doc__ or ""))
    parts = [f"# {module.__name__}\n\n{about}\n"]
    for kind, names in _by_kind(module):
        parts.append(f"## {kind}\n")
        parts += [f"::: {_source(module, name)}\n" for name in names]
    return "\n".join(parts)


def _by_kind(module: ModuleType) -> Iterator[tuple[str, list[str]]]:
    """Yield the public names of a module: functions, classes, errors and values."""
    rest = sorted(module.__all__)
    groups: dict[str, list[str]] = {"Functions": [], "Classes": [], "Errors": [], "Modules": [], "Values": []}
    for name in rest:
        groups[_kind(getattr(module, name))].append(name)
    yield from ((kind, names) for kind, names in groups.items() if names)


def _kind(value: Any) -> str:
    if inspect.isclass(value):
        return "Errors" if issubclass(value, BaseException) else "Classes"
    if inspect.ismodule(value):
        return "Modules"
    return "Functions" if callable(value) and hasattr(value, "__qualname__") else "Values"


def _source(module: ModuleType, name: str) -> str:
    """Return the path at which a name is defined."""
    value = getattr(module, name)
    if inspect.ismodule(value):
        return value.__name__
    if getattr(value, "__qualname__", None) == name and getattr(value, "__module__", None):
        return f"{value.__module__}.{name}"
    return f"{module.__name__}.{name}"
