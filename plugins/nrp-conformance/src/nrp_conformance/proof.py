"""The backend under test, its options, and the level of the suite."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from traceback import extract_tb
from typing import Any

from pydantic import BaseModel, ValidationError

from nrp_conformance.base import BackendTests
from nrp_conformance.brain import BrainBackendTests, BrainContractTests, FullBrainTests
from nrp_conformance.report import KitReport, KitResult
from nrp_conformance.run import run_tests
from nrp_conformance.world import (
    FullOwnSceneTests,
    FullWorldTests,
    OwnSceneTests,
    WorldBackendTests,
    WorldContractTests,
)
from nrp_conformance.world.own_scene import command_topics
from nrp_core import brains, worlds
from nrp_core.errors import BackendError, CapabilityError, ExperimentError, did_you_mean
from nrp_core.experiment import describe_fault
from nrp_core.registry import Registry
from nrp_core.utilities import describe_machine, to_jsonable
from nrp_core.world import Scene, read_scene

SUITES: dict[str, dict[str, type[BackendTests]]] = {
    "brain": {"contract": BrainContractTests, "core": BrainBackendTests, "full": FullBrainTests},
    "world": {"contract": WorldContractTests, "core": WorldBackendTests, "full": FullWorldTests},
    "own scene": {"contract": OwnSceneTests, "core": OwnSceneTests, "full": FullOwnSceneTests},
}
"""The suites by kind of backend and level; each level contains the one before it."""


@dataclass(frozen=True, slots=True)
class Proof:
    """A suite for an installed backend.

    Args:
        kind: ``brain`` or ``world``.
        name: its entry-point name.
        options: the backend's options, as an experiment file gives them.
        level: ``contract``, ``core`` or ``full``.
        scene: the file of the scene, for a world that has its own.
    """

    kind: str
    name: str
    options: Mapping[str, Any]
    level: str
    scene: str = ""

    @property
    def tests(self) -> type[BackendTests]:
        """The suite."""
        given = {"backend_name": self.name, "options": dict(self.options), "scene": self.scene}
        return type("Installed", (SUITES[self._suite][self.level],), given)

    @property
    def _suite(self) -> str:
        if self.kind == "brain":
            return self.kind
        backend = worlds().load(self.name)
        declared = backend.capabilities(backend.options.model_validate(dict(self.options)))
        return "own scene" if declared.own_scene else self.kind

    def report(self, results: list[KitResult]) -> KitReport:
        """Run the suite and return the report.

        Raises:
            BackendError: the backend does not exist, does not load, or cannot state its capabilities.
            ExperimentError: an option does not exist or has a wrong value.
            CapabilityError: the world cannot be tested, because it is a machine, or without its scene.
        """
        registry: Registry[Any] = brains() if self.kind == "brain" else worlds()
        backend = registry.load(self.name)
        try:
            chosen = backend.options.model_validate(dict(self.options))
        except ValidationError as error:
            with suppress(
                ValidationError
            ):  # a missing option need not be given to learn that nothing applies
                self._require_simulated(backend.capabilities(backend.options.model_construct()))
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
        self._require_simulated(declared)
        self._require_scene(backend, chosen, declared)
        return KitReport(
            self.kind, self.name, to_jsonable(registry.provider(self.name)), self.options, self.level,
            to_jsonable(declared), describe_machine(), results, Path(self.scene).name,
        )  # fmt: skip

    def _require_simulated(self, declared: Any) -> None:
        if getattr(declared, "own_scene", False) and declared.real_time:
            raise CapabilityError(
                f"the tests do not apply to {self.kind} '{self.name}', and none was run: they reset and "
                "repeat a simulated world, but this one is a machine with its own scene"
            )

    def _require_scene(self, backend: Any, chosen: Any, declared: Any) -> None:
        """Require a scene where the world needs one, and none where the tests bring theirs."""
        if not getattr(declared, "own_scene", False):
            if self.scene:
                raise ExperimentError(
                    f"the tests of {self.kind} '{self.name}' bring their own scenes, so that '{self.scene}' "
                    "is not used; only a world that declares 'own_scene' is tested with one"
                )
            return
        scene = read_scene(Path(self.scene)) if self.scene else Scene(())
        with backend.open(scene, seed=1, options=chosen) as world:
            if not command_topics(world):
                at = f"in '{self.scene}' " if self.scene else ""
                raise CapabilityError(
                    f"world '{self.name}' has nothing {at}that can be commanded with numbers, so that no "
                    "test applies; name a file with robots as the scene"
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
