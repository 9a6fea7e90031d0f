"""MuJoCo worlds as the base of worlds with one bug each: another engine, or another scene."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from nrp_world_mujoco.backend import MujocoBackend
from nrp_world_mujoco.engine import MujocoEngine

from nrp_core.scene.model import Scene
from nrp_core.world.backend import WorldOptions
from nrp_core.world.engine import Engine
from nrp_core.world.sensors.camera import Camera


class Opens(MujocoBackend):
    world: type[MujocoEngine] = MujocoEngine

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        return self.world(scene, seed=seed, capabilities=self.capabilities(options), options=options)  # type: ignore[arg-type]


class ChangesTheScene(Opens):
    """Loads another scene than it was given."""

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        return super().engine(self.changed(scene), seed=seed, options=options)

    def changed(self, scene: Scene) -> Scene:
        raise NotImplementedError


def with_links(scene: Scene, change: Any) -> Scene:
    models = (replace(m, links=tuple(change(link) for link in m.links)) for m in scene.models)
    return replace(scene, models=tuple(models))


def with_sensors(scene: Scene, change: Any) -> Scene:
    def changed(link: Any) -> Any:
        return replace(link, sensors=tuple(change(s) if isinstance(s, Camera) else s for s in link.sensors))

    return with_links(scene, changed)


def with_visuals(scene: Scene, change: Any) -> Scene:
    return with_links(scene, lambda link: replace(link, visuals=tuple(change(v) for v in link.visuals)))
