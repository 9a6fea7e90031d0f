"""The base of all tests: the backend, its options, open simulations, and a guard.

Tests are skipped only if the backend does not declare a feature, and are never replaced without a reason.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from functools import cached_property
from typing import Any, ClassVar, Generic, NoReturn, TypeVar

import pytest

from nrp_core.brain import BrainBackend, BrainCapabilities
from nrp_core.simulation import Determinism
from nrp_core.world import WorldBackend, WorldCapabilities

KIT = __name__.rpartition(".")[0]
_PARAMETER = type(pytest.param())
Backend = TypeVar("Backend", bound=BrainBackend | WorldBackend)
Capabilities = TypeVar("Capabilities", bound=BrainCapabilities | WorldCapabilities)


def skip_undeclared(what: str) -> NoReturn:
    """Skip a test because the backend does not declare its feature; no other reason to skip is allowed."""
    pytest.skip(f"not declared: {what}")


def refuse_replaced_tests(cls: type) -> None:
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
        if not in_part and not _has_reason(_marks(value)):
            raise TypeError(
                f"{cls.__name__}.{name} replaces a test of the conformance kit; if the backend cannot pass "
                f"it yet, call super().{name}() under @pytest.mark.xfail(reason='...'), or mark only "
                "the parameters that fail and keep the others"
            )


def _explained_in_part(test: object, original: object) -> bool:
    """Return whether a test has the parameters of the original, with only explained failures."""
    marks = [mark for marks, _ in _parameters(test) for mark in marks]
    same = [values for _, values in _parameters(test)] == [values for _, values in _parameters(original)]
    return same and bool(marks) and all(_has_reason([mark]) for mark in marks)


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


def _marks(test: object) -> list[Any]:
    return list(getattr(test, "pytestmark", ()))


def _has_reason(marks: Iterable[Any]) -> bool:
    return any(mark.name == "xfail" and mark.kwargs.get("reason") for mark in marks)


class BackendTests:
    """The base of all tests of the kit; a third party derives from one of its public subclasses.

    Attributes:
        backend_name: the entry-point name of the backend under test.
        options: its options, as an experiment file gives them.
        level: the level of a class's tests: contract, capability, accuracy, ...
    """

    backend_name: ClassVar[str] = ""
    options: ClassVar[Mapping[str, Any]] = {}
    level: ClassVar[str] = "contract"

    opened: ExitStack
    note: Callable[[str, object], None]

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        refuse_replaced_tests(cls)

    @pytest.fixture(autouse=True)
    def _close_simulations(self) -> Iterator[None]:
        with ExitStack() as self.opened:
            yield

    @pytest.fixture(autouse=True)
    def _set_note(self, record_property: Callable[[str, object], None]) -> None:
        """Add measurements of a test to the report, by ``self.note(name, value)``."""
        self.note = record_property


class SimulatorTests(BackendTests, Generic[Backend, Capabilities]):
    """Access to the backend under test, shared by the tests of brains and worlds."""

    @classmethod
    def make_backend(cls) -> Backend:
        """Return the backend under test; override this for a backend that is not installed."""
        raise NotImplementedError

    @cached_property
    def backend(self) -> Backend:
        """The backend under test."""
        return self.make_backend()

    @cached_property
    def chosen(self) -> Any:
        """The options, as an instance of the backend's options class."""
        return self.backend.options.model_validate(dict(self.options))

    @cached_property
    def capabilities(self) -> Capabilities:
        """The capabilities that the backend declares with these options."""
        backend: Any = self.backend
        declared: Capabilities = backend.capabilities(self.chosen)
        return declared

    def require_snapshot(self) -> None:
        """Skip the test if snapshots are not declared."""
        if not self.capabilities.snapshot:
            skip_undeclared("snapshot")

    def require_repeatable(self) -> None:
        """Skip the test if two runs with one seed may differ."""
        if self.capabilities.determinism is Determinism.STATISTICAL:
            skip_undeclared("repeatable runs")
