"""Helpers for the tests of worlds: open, drive and observe a world."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from nrp_core.clock import from_seconds, seconds
from nrp_core.conformance.base import SimulatorTests
from nrp_core.conformance.guard import undeclared
from nrp_core.conformance.world.scenes import CAMERA_HZ
from nrp_core.world.backends import worlds
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.interface import WorldBackend
from nrp_core.world.messages.geometry_msgs import Twist, Vector3
from nrp_core.world.messages.std_msgs import ColorRGBA
from nrp_core.world.rigid import ModelMotion, Vector
from nrp_core.world.scene.model import Model, Rgba, Scene
from nrp_core.world.world import World

Pixels = npt.NDArray[np.int64]
GRAVITY = 9.8
COMMANDS_HZ = 50


class WorldKit(SimulatorTests[WorldBackend, WorldCapabilities]):
    """Opens the world under test."""

    @classmethod
    def make_backend(cls) -> WorldBackend:
        return worlds().load(cls.backend_name)

    @property
    def step_s(self) -> float:
        """The declared physics step."""
        return seconds(self.capabilities.step_ns)

    def open(self, *models: Model, seed: int = 1, gravity: Vector = (0.0, 0.0, -GRAVITY)) -> World:
        """Open a scene of models; it is closed after the test."""
        scene = Scene(models, gravity=gravity)
        return self.opened.enter_context(self.backend.open(scene, seed=seed, options=self.chosen))

    def grid_ns(self, t_s: float) -> int:
        """Return the first time at or after ``t_s`` at which the world can be stopped."""
        step_ns = self.capabilities.step_ns
        return -(-from_seconds(t_s) // step_ns) * step_ns

    def run(self, world: World, until_s: float) -> None:
        """Advance to the first possible time at or after ``until_s``."""
        world.run_until(self.grid_ns(until_s))

    def drive(self, world: World, forward: float, turn: float, for_s: float, robot: str = "robot") -> None:
        """Command a robot repeatedly, for some time."""
        commands = world.advertise(f"/{robot}/cmd_vel")
        start_s = seconds(world.now_ns)
        for step in range(round(for_s * COMMANDS_HZ)):
            commands.publish(twist(forward, turn))
            self.run(world, start_s + (step + 1) / COMMANDS_HZ)

    def look(self, world: World, robot: str = "robot") -> Pixels:
        """Return the next image of a robot's camera, as signed integers."""
        self.require_camera()
        images = world.subscribe(f"/{robot}/camera")
        self.run(world, seconds(world.now_ns) + 1 / CAMERA_HZ)
        stamped = images.latest
        assert stamped is not None, "no image within one period"
        world.unsubscribe(images)
        return np.asarray(stamped.message.data, dtype=np.int64)

    def movable(self, *models: Model) -> tuple[Model, ...]:
        """Return the models that the world supports; without dynamics, free bodies are left out."""
        return tuple(m for m in models if self.capabilities.dynamics or m.static or m.drives)

    def require(self, capability: str) -> None:
        """Skip the test if a capability is not declared."""
        if not getattr(self.capabilities, capability):
            undeclared(capability.replace("_", " "))

    def require_camera(self) -> None:
        """Skip the test if cameras are not declared."""
        if not self.capabilities.renderers:
            undeclared("cameras")


def twist(forward: float, turn: float) -> Twist:
    """Return a command."""
    return Twist(Vector3(forward), Vector3(0.0, 0.0, turn))


def paint(world: World, visual: str, rgba: Rgba) -> None:
    """Colour a visual (``model/link/visual``)."""
    world.advertise(f"/{visual}/color").publish(ColorRGBA(*rgba))


def states(world: World) -> dict[str, ModelMotion]:
    """Return the pose and velocity of every movable model."""
    return {model.name: world.model_motion(model.name) for model in world.scene.models if not model.static}


def where(image: Pixels, channel: int) -> npt.NDArray[np.bool_]:
    """Return the pixels in which one channel clearly exceeds both others."""
    others = np.delete(image, channel, axis=2).max(axis=2)
    return np.asarray(image[:, :, channel] > others + 60)


def centre(mask: npt.NDArray[np.bool_]) -> tuple[float, float]:
    """Return the mean row and column of the pixels that are set, from -1 (top, left) to 1."""
    assert mask.any(), "the object is not in the image"
    rows, columns = np.nonzero(mask)
    height, width = mask.shape
    return float((2 * rows.mean() + 1) / height - 1), float((2 * columns.mean() + 1) / width - 1)
