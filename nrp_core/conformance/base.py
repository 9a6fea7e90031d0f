"""The base of all tests: the backend and its options, the opened simulations, and skips."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from functools import cached_property
from typing import Any, ClassVar, Generic, TypeVar

import pytest

from nrp_core.brain.backend import BrainBackend
from nrp_core.brain.interface import BrainCapabilities
from nrp_core.conformance.guard import refuse_quiet_edits, undeclared
from nrp_core.simulation import Determinism
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.interface import WorldBackend

Backend = TypeVar("Backend", bound=BrainBackend | WorldBackend)
Capabilities = TypeVar("Capabilities", bound=BrainCapabilities | WorldCapabilities)


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
        refuse_quiet_edits(cls)

    @pytest.fixture(autouse=True)
    def _close_what_was_opened(self) -> Iterator[None]:
        with ExitStack() as self.opened:
            yield

    @pytest.fixture(autouse=True)
    def _take_notes(self, record_property: Callable[[str, object], None]) -> None:
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
            undeclared("snapshot")

    def require_repeatable(self) -> None:
        """Skip the test if two runs with one seed may differ."""
        if self.capabilities.determinism is Determinism.STATISTICAL:
            undeclared("repeatable runs")
