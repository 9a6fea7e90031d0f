"""The backend that simulates a body, and its options."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from nrp_core import worlds
from nrp_core.errors import ExperimentError
from nrp_core.world import Scene, World, WorldBackend, WorldCapabilities, WorldOptions
from pydantic import ValidationError


@dataclass(frozen=True, slots=True)
class Simulator:
    """A world backend and its options."""

    backend: WorldBackend
    options: WorldOptions

    @classmethod
    def named(cls, name: str, options: Mapping[str, Any]) -> Simulator:
        """Find the backend.

        Args:
            name: its entry-point name.
            options: as in an experiment file.

        Raises:
            BackendError: there is no such backend, or it does not load.
            ExperimentError: an option is wrong, or the backend runs in real time.
        """
        backend = worlds().load(name)
        try:
            simulator = cls(backend, backend.options.model_validate(dict(options)))
        except ValidationError as error:
            first = error.errors()[0]
            option = ".".join(map(str, first["loc"]))
            raise ExperimentError(f"option '{option}' of the body '{name}': {first['msg']}") from None
        if simulator.capabilities.real_time:
            raise ExperimentError(f"'{name}' runs in real time, but a simulated body must wait for the loop")
        return simulator

    @property
    def capabilities(self) -> WorldCapabilities:
        """Its capabilities."""
        return self.backend.capabilities(self.options)

    def open(self, scene: Scene, seed: int) -> World:
        """Open a scene."""
        return self.backend.open(scene, seed=seed, options=self.options)
