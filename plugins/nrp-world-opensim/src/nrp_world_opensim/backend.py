"""The entry point: options and capabilities. Importing it does not load OpenSim."""

from __future__ import annotations

from importlib.metadata import version
from importlib.util import find_spec
from typing import Annotated, ClassVar, Literal

from nrp_core.clock import NS_PER_MS
from nrp_core.errors import BackendLoadError
from nrp_core.quantities import DurationNs
from nrp_core.world import (
    Diagnosis,
    Engine,
    Scene,
    WorldBackend,
    WorldCapabilities,
    WorldOptions,
)
from pydantic import Field

_INSTALL = "pip install nrp-world-opensim"


class OpensimOptions(WorldOptions):
    """Options of the ``opensim`` backend."""

    timestep: Annotated[
        DurationNs,
        Field(gt=0, description="the time after which the integrator begins anew; excitations hold for it"),
    ] = 2 * NS_PER_MS
    integrator: Annotated[
        Literal[
            "RungeKuttaMerson",
            "RungeKuttaFeldberg",
            "RungeKutta3",
            "RungeKutta2",
            "SemiExplicitEuler2",
            "Verlet",
            "CPodes",
        ],
        Field(description="the integrator, by OpenSim's name; its steps adapt to the accuracy"),
    ] = "RungeKuttaMerson"
    accuracy: Annotated[float, Field(gt=0, lt=1, description="the accuracy of the integrator")] = 1e-4
    renderer: Annotated[
        Literal["auto", "raster", "realistic"],
        Field(
            description="of cameras: raster (auto) draws flat colours on the CPU, realistic light and shadows"
        ),
    ] = "auto"


class OpensimBackend(WorldBackend):
    """The bodies are those of files of OpenSim, which the engine reads itself."""

    interface_version = 2
    options: ClassVar[type[WorldOptions]] = OpensimOptions

    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        assert isinstance(options, OpensimOptions)
        renderers = ("raster", "realistic") if options.renderer == "auto" else (options.renderer,)
        return WorldCapabilities(
            step_ns=options.timestep,
            renderers=renderers,
            snapshot=True,
            links=True,
            joint_control=True,
            own_actuators=True,
            own_scene=True,
        )

    def diagnose(self) -> list[Diagnosis]:
        present = find_spec("opensim") is not None
        found = f"version {version('opensim')}" if present else "it is not installed"
        return [Diagnosis("OpenSim", present, found, _INSTALL)]

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        assert isinstance(options, OpensimOptions)
        try:
            from nrp_world_opensim.engine import OpensimEngine
        except ImportError as error:
            raise BackendLoadError(f"OpenSim does not import: {error}", remedy=_INSTALL) from error
        return OpensimEngine(scene, self.capabilities(options), seed=seed, options=options)
