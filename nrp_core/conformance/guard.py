"""What a suite may leave out, and what it may not: skips by declaration, no test replaced in silence."""

from __future__ import annotations

from typing import NoReturn

import pytest

KIT = __name__.rpartition(".")[0]


def undeclared(what: str) -> NoReturn:
    """Skip a test because the backend does not declare what it is about; there is no other reason to skip."""
    pytest.skip(f"not declared: {what}")


def refuse_quiet_edits(cls: type) -> None:
    """Refuse a class outside the kit that replaces one of its tests without saying why.

    Raises:
        TypeError: a test is replaced, and its replacement is not marked ``xfail(reason=...)``.
    """
    if cls.__module__.startswith(KIT):
        return
    for name, value in vars(cls).items():
        inherited = any(name in vars(base) for base in cls.__mro__[1:])
        if name.startswith("test") and inherited and not _explained(value):
            raise TypeError(
                f"{cls.__name__}.{name} replaces a test of the conformance kit; if the backend cannot pass "
                f"it yet, call super().{name}() under @pytest.mark.xfail(reason='...')"
            )


def _explained(test: object) -> bool:
    marks = getattr(test, "pytestmark", ())
    return any(mark.name == "xfail" and mark.kwargs.get("reason") for mark in marks)
