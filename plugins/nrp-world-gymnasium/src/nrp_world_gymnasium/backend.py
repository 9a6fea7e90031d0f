"""The entry point: options and capabilities. Importing it does not load Gymnasium."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from typing import ClassVar

from nrp_core.world import (
    Diagnosis,
    Engine,
    Scene,
    TopicInfo,
    WorldBackend,
    WorldCapabilities,
    WorldOptions,
)
from nrp_world_gymnasium.options import GymnasiumOptions

_INSTALL = "pip install nrp-world-gymnasium"


class GymnasiumBackend(WorldBackend):
    """A world is one environment; it brings its own bodies, so that it needs no scene."""

    interface_version = 2
    options: ClassVar[type[WorldOptions]] = GymnasiumOptions

    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        assert isinstance(options, GymnasiumOptions)
        return WorldCapabilities(step_ns=options.timestep, snapshot=True, poses=False, own_scene=True)

    def diagnose(self) -> list[Diagnosis]:
        present = find_spec("gymnasium") is not None
        return [
            Diagnosis("Gymnasium", present, "it is " + ("" if present else "not ") + "installed", _INSTALL)
        ]

    def topics(self, options: WorldOptions) -> Sequence[TopicInfo]:
        """Return the topics of the environment, which is made for this."""
        from nrp_world_gymnasium.engine import GymnasiumEngine

        assert isinstance(options, GymnasiumOptions)
        engine = GymnasiumEngine(Scene(()), self.capabilities(options), seed=0, options=options)
        engine.close()
        return engine.topics

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        from nrp_world_gymnasium.engine import GymnasiumEngine

        assert isinstance(options, GymnasiumOptions)
        return GymnasiumEngine(scene, self.capabilities(options), seed=seed, options=options)
