"""Guard the suites: tests are skipped only by declaration, and never replaced in silence."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NoReturn

import pytest

KIT = __name__.rpartition(".")[0]


def undeclared(what: str) -> NoReturn:
    """Skip a test because the backend does not declare its feature; no other reason to skip is allowed."""
    pytest.skip(f"not declared: {what}")


def refuse_quiet_edits(cls: type) -> None:
    """Refuse a class outside the kit that replaces a test of the kit without a reason.

    A test, or some of its parameters, may be expected to fail: ``xfail(reason=...)``. With parameters, all
    parameters of the kit must remain, and those not expected to fail must still run the kit's test.

    Raises:
        TypeError: a test is replaced in any other way.
    """
    if cls.__module__.startswith(KIT):
        return
    for name, value in vars(cls).items():
        inherited = [vars(base)[name] for base in cls.__mro__[1:] if name in vars(base)]
        if not name.startswith("test") or not inherited:
            continue
        in_part = _explained_in_part(value, inherited[0]) and _calls(value, name)
        if not in_part and not _explained(_marks(value)):
            raise TypeError(
                f"{cls.__name__}.{name} replaces a test of the conformance kit; if the backend cannot pass "
                f"it yet, call super().{name}() under @pytest.mark.xfail(reason='...'), or mark only "
                "the parameters that fail and keep the others"
            )


def _explained_in_part(test: object, original: object) -> bool:
    """Return whether a test has the parameters of the original, with only explained failures."""
    marks = [mark for marks, _ in _parameters(test) for mark in marks]
    same = [values for _, values in _parameters(test)] == [values for _, values in _parameters(original)]
    return same and bool(marks) and all(_explained([mark]) for mark in marks)


def _calls(test: object, name: str) -> bool:
    return name in getattr(getattr(test, "__code__", None), "co_names", ())


def _parameters(test: object) -> Iterator[tuple[list[Any], Any]]:
    """Return the marks of each set of parameters, by its names and values."""
    for mark in _marks(test):
        if mark.name == "parametrize":
            names, sets = mark.args
            several = not isinstance(names, str) or "," in names
            for given in sets:
                parameter = given if isinstance(given, _PARAMETER) else _parameter(given, several)
                yield list(parameter.marks), (names, tuple(parameter.values))


def _parameter(given: Any, several: bool) -> Any:
    return pytest.param(*given) if several else pytest.param(given)


_PARAMETER = type(pytest.param())


def _marks(test: object) -> list[Any]:
    return list(getattr(test, "pytestmark", ()))


def _explained(marks: Iterable[Any]) -> bool:
    return any(mark.name == "xfail" and mark.kwargs.get("reason") for mark in marks)
