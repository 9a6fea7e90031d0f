"""The backend under test, its options, and the level of the suite."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from traceback import extract_tb
from typing import Any

from pydantic import BaseModel, ValidationError

from nrp_conformance.base import BackendTests
from nrp_conformance.brain import BrainBackendTests, BrainContractTests, FullBrainTests
from nrp_conformance.report import KitReport, KitResult
from nrp_conformance.run import run_tests
from nrp_conformance.world import FullWorldTests, WorldBackendTests, WorldContractTests
from nrp_core import brains, worlds
from nrp_core.errors import BackendError, CapabilityError, ExperimentError, did_you_mean
from nrp_core.experiment import describe_fault
from nrp_core.registry import Registry
from nrp_core.utilities import describe_machine, to_jsonable

SUITES: dict[str, dict[str, type[BackendTests]]] = {
    "brain": {"contract": BrainContractTests, "core": BrainBackendTests, "full": FullBrainTests},
    "world": {"contract": WorldContractTests, "core": WorldBackendTests, "full": FullWorldTests},
}
"""The suites by kind of backend and level; each level contains the one before it."""


@dataclass(frozen=True, slots=True)
class Proof:
    """A suite for an installed backend.

    Args:
        kind: ``brain`` or ``world``.
        name: its entry-point name.
        options: the backend's options, as text.
        level: ``contract``, ``core`` or ``full``.
    """

    kind: str
    name: str
    options: Mapping[str, str]
    level: str

    @property
    def tests(self) -> type[BackendTests]:
        """The suite."""
        given = {"backend_name": self.name, "options": dict(self.options)}
        return type("Installed", (SUITES[self.kind][self.level],), given)

    def report(self, results: list[KitResult]) -> KitReport:
        """Run the suite and return the report.

        Raises:
            BackendError: the backend does not exist, does not load, or cannot state its capabilities.
            ExperimentError: an option does not exist or has a wrong value.
            CapabilityError: the world has its own scene, so the suite does not apply.
        """
        registry: Registry[Any] = brains() if self.kind == "brain" else worlds()
        backend = registry.load(self.name)
        try:
            chosen = backend.options.model_validate(dict(self.options))
        except ValidationError as error:
            assumed = None
            with suppress(Exception):  # a missing option need not be given to learn that nothing applies
                assumed = backend.capabilities(backend.options.model_construct())
            self._require_scene(assumed)
            wrong = _wrong_option(error, backend.options)
            raise ExperimentError(f"{self.kind} '{self.name}': {wrong}") from None
        try:
            declared = backend.capabilities(chosen)
        except Exception as error:
            place = extract_tb(error.__traceback__)[-1]
            raise BackendError(
                f"{self.kind} '{self.name}' cannot state its capabilities: {type(error).__name__}: {error} "
                f"({place.filename}:{place.lineno})"
            ) from error
        self._require_scene(declared)
        return KitReport(
            self.kind, self.name, to_jsonable(registry.provider(self.name)), self.options, self.level,
            to_jsonable(declared), describe_machine(), results,
        )  # fmt: skip

    def _require_scene(self, declared: Any) -> None:
        if getattr(declared, "own_scene", False):
            raise CapabilityError(
                f"the tests do not apply to {self.kind} '{self.name}', and none was run: they put robots and "
                "rooms into a world and compare how these move with formulas, but this world has its own "
                "scene. Compare its topics with what it wraps instead"
            )

    def run(self) -> KitReport:
        """Run the suite in this process."""
        self.report([])  # report errors of the backend or its options before the tests
        return self.report(run_tests(self.tests))


def _wrong_option(error: ValidationError, model: type[BaseModel]) -> str:
    first = error.errors()[0]
    option = ".".join(map(str, first["loc"]))
    if first["type"] == "extra_forbidden":
        return f"no option '{option}'{did_you_mean(option, model.model_fields)}"
    return f"option '{option}': {describe_fault(first)}"
