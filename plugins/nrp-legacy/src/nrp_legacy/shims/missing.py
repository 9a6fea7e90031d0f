"""Modules that are not installed: they can be imported, and fail only when they are used.

Unknown ROS packages have messages that accept any field.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

from nrp_core.findings import Code
from nrp_legacy.notes import Notes
from nrp_legacy.shims.modules import OpenMessage, ServiceType, open_module

_MESSAGES = ("msg", "action")
_SERVICES = "srv"


class Missing:
    """An object of a module that is not installed.

    Args:
        name: its dotted name.
        why: the reason why it is missing.
    """

    def __init__(self, name: str, why: str) -> None:
        self._name, self._why = name, why

    def __getattr__(self, name: str) -> Missing:
        if name.startswith("_"):
            raise AttributeError(name)
        return Missing(f"{self._name}.{name}", self._why)

    def __repr__(self) -> str:
        return f"<{self._name}, which is not here>"

    def _fail(self, *_values: object, **_fields: object) -> NoReturn:
        raise ImportError(f"{self._why}: {self._name} is needed")

    __call__ = __iter__ = __getitem__ = __len__ = __enter__ = __mro_entries__ = __contains__ = _fail
    __add__ = __radd__ = __sub__ = __mul__ = __rmul__ = __truediv__ = __lt__ = __gt__ = _fail


def with_missing_parts(known: ModuleType) -> None:
    """Make all names of a module importable: missing ones fail when they are used."""
    name = known.__name__

    def attribute(child: str) -> Missing:
        if child.startswith("_"):
            raise AttributeError(child)
        return Missing(f"{name}.{child}", f"'{name}' does not have '{child}'")

    vars(known)["__getattr__"] = attribute


class StandIns:
    """The substitutes for missing modules.

    Args:
        notes: receives a note about each, once.
    """

    def __init__(self, notes: Notes) -> None:
        self._notes = notes
        self._told: set[str] = set()
        self._module = cache(self._made)

    def __call__(self, name: str, importer: Mapping[str, Any]) -> ModuleType | None:
        """Return a module, None if the import may fail because the importing file handles this."""
        if _may_fail(name.partition(".")[0], importer.get("__file__")):
            return None
        return self._module(name)

    def _made(self, name: str) -> ModuleType:
        root, _, rest = name.partition(".")
        if rest in _MESSAGES:
            message = f"the message package '{root}' is not known: its messages accept any field"
            self._notes(Code.NRP286, message, subject=root)
            return open_module(name, lambda child: type(child, (OpenMessage,), {}), {})
        if rest == _SERVICES:
            return open_module(name, ServiceType, {})
        if not rest:
            return open_module(name, lambda child: self._part(name, child), {})
        why = self._tell(root)
        return open_module(name, lambda child: Missing(f"{name}.{child}", why), {})

    def _part(self, package: str, child: str) -> Any:
        if child in (*_MESSAGES, _SERVICES):
            return self._module(f"{package}.{child}")
        return Missing(f"{package}.{child}", self._tell(package))

    def _tell(self, root: str) -> str:
        if root not in self._told:
            self._told.add(root)
            message = f"module '{root}' is not installed: code that uses it fails"
            self._notes(Code.NRP286, message, subject=root)
        return f"the module '{root}' is not installed"


def _may_fail(root: str, file: object) -> bool:
    """Whether a file imports a module within ``try``."""
    path = Path(str(file))
    if not path.is_file():
        return False
    guarded = rf"\btry\s*:[^\n]*\n(?:\s*(?:import|from)\s[^\n]*\n)*\s*(?:import|from)\s+{re.escape(root)}\b"
    return re.search(guarded, path.read_text("utf-8", errors="replace")) is not None
