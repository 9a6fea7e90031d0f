"""The entry point: capabilities and the engine. Importing it does not load OpenSim."""

from __future__ import annotations

from importlib.metadata import version
from importlib.util import find_spec
from typing import ClassVar

from nrp_core.errors import BackendLoadError
from nrp_core.world import (
    Diagnosis,
    Engine,
    Scene,
    WorldBackend,
    WorldCapabilities,
    WorldOptions,
)

from nrp_world_opensim.options import OpensimOptions

_INSTALL = "pip install nrp-world-opensim"


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
            wrapping=True,
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
