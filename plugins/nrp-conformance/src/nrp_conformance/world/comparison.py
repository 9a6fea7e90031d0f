"""Cross and speed: against every other installed world, and against wall-clock time."""

from __future__ import annotations

from time import perf_counter

import numpy as np

from nrp_conformance.base import skip_undeclared
from nrp_conformance.world.driving import SLIP
from nrp_conformance.world.kit import RED, WorldKit, floor, robot, screen, where
from nrp_core import worlds
from nrp_core.errors import BackendError
from nrp_core.world import Model, Scene, World

WAY_M, PIXELS = 1.5, 0.02
"""The distance that the robot drives, and the share of pixels that may differ: the edges of objects."""


class WorldCrossTests(WorldKit):
    """The same scene and commands in every other installed world."""

    level = "cross"

    def test_a_robot_reaches_the_same_place_as_in_every_other_world(self) -> None:
        self.note("compared", len(others := self._others()))
        mine = self._final_pose(self.open(*_scene()))
        for name, world in others.items():
            theirs = self._final_pose(world)
            distance = float(np.linalg.norm(np.subtract(mine, theirs)))
            self.note(f"distance_to_{name}_m", distance)
            assert distance <= 2 * SLIP * WAY_M

    def test_a_camera_renders_the_same_image_in_every_world(self) -> None:
        self.require_camera()
        mine = where(self.image_of(self.open(*_scene())), 0)
        for name, world in self._others().items():
            if world.capabilities.renderers:
                theirs = where(self.image_of(world), 0)
                if theirs.shape == mine.shape:
                    self.note(f"pixels_unlike_{name}", float((mine != theirs).mean()))
                    assert (mine != theirs).mean() <= PIXELS

    def _others(self) -> dict[str, World]:
        found = {}
        for name in worlds().names():
            if name == self.backend_name:
                continue
            try:
                backend = worlds().load(name)
                world = backend.open(Scene(_scene()), seed=1, options=backend.options())
            except BackendError:
                continue
            found[name] = self.opened.enter_context(world)
        if not found:
            skip_undeclared("another installed world")
        return found

    def _final_pose(self, world: World) -> tuple[float, float, float]:
        self.drive(world, WAY_M / 3, 0.3, 3.0)
        return world.model_motion("robot").pose.position


class SpeedTests(WorldKit):
    """Only reported; this test cannot fail."""

    level = "speed"

    def test_the_speed(self) -> None:
        world = self.open(*_scene())
        if self.capabilities.renderers:
            world.subscribe("/robot/camera")
        self.drive(world, 0.3, 0.1, 0.2)
        started = perf_counter()
        self.drive(world, 0.3, 0.1, 2.0)
        self.note("simulated_seconds_per_second", 2.0 / (perf_counter() - started))


def _scene() -> tuple[Model, ...]:
    return floor(), robot(), screen("screen", 0.5, RED, x=4.0)
