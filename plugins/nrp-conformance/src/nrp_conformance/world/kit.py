"""Helpers for the tests of worlds: short functions that build scenes (m, kg), and how a world is run."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import numpy.typing as npt

from nrp_conformance.base import SimulatorTests, skip_undeclared
from nrp_core import worlds
from nrp_core.clock import from_seconds, seconds
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.scene.rigid import ModelMotion, Pose, Vector
from nrp_core.world import (
    Box,
    Camera,
    Collision,
    Cylinder,
    Geometry,
    Inertial,
    Joint,
    Link,
    Model,
    Plane,
    Rgba,
    Scene,
    Visual,
    WheelDrive,
    World,
    WorldBackend,
    WorldCapabilities,
)

RED: Rgba = (1.0, 0.0, 0.0, 1.0)
GREEN: Rgba = (0.0, 1.0, 0.0, 1.0)
BLUE: Rgba = (0.0, 0.0, 1.0, 1.0)
GREY: Rgba = (0.6, 0.6, 0.6, 1.0)

WHEEL_RADIUS, WHEEL_WIDTH, TRACK = 0.15, 0.08, 0.5
LENGTH, CAMERA_HEIGHT = 0.8, 0.5
FIELD_OF_VIEW, WIDTH, HEIGHT = pi / 2, 48, 32
CAMERA_HZ = 25.0
DRIVE_TIMEOUT_S = 0.3
Pixels = npt.NDArray[np.int64]
GRAVITY = 9.8
COMMANDS_HZ = 50


def prop(
    name: str, geometry: Geometry, pose: Pose = Pose(), *,
    mass: float = 0.0, rgba: Rgba = GREY, solid: bool = True,
) -> Model:  # fmt: skip
    """Return a model of one link, static unless it has a mass; its visual is ``<name>/link/visual``."""
    moment = 0.02 * mass
    inertial = Inertial(mass, inertia=(moment, moment, moment, 0.0, 0.0, 0.0)) if mass else None
    touching = (Collision("collision", geometry),) if solid else ()
    link = Link("link", Pose(), inertial, (Visual("visual", geometry, rgba=rgba),), touching)
    return Model(name, (link,), pose=pose, static=not mass)


def rubbing(model: Model, friction: float) -> Model:
    """Return a model of one link whose shapes have a coefficient of friction."""
    (link,) = model.links
    collisions = tuple(replace(each, friction=friction) for each in link.collisions)
    return replace(model, links=(replace(link, collisions=collisions),))


def at(x: float, y: float, z: float, *, yaw: float = 0.0) -> Pose:
    """Return a pose that is rotated about z only."""
    return Pose.from_rpy((x, y, z), 0.0, 0.0, yaw)


def floor() -> Model:
    """Return the ground."""
    return prop("floor", Plane((40.0, 40.0)))


def screen(name: str, y: float, rgba: Rgba, *, x: float = 3.0, z: float = CAMERA_HEIGHT) -> Model:
    """Return a flat square that faces the origin and touches nothing."""
    return prop(name, Box((0.1, 1.0, 1.0)), at(x, y, z), rgba=rgba, solid=False)


def robot(
    name: str = "robot", x: float = 0.0, y: float = 0.0, *, yaw: float = 0.0, tilt: float = 0.0
) -> Model:
    """Return a robot with four wheels that stands on the floor, its camera above its centre.

    Args:
        name: the model name, and the prefix of its topics.
        x: the x position, m.
        y: the y position, m.
        yaw: the heading, rad.
        tilt: the downward tilt of its camera, rad.
    """
    body = Box((LENGTH, 0.4, 0.2))
    base = Link(
        "base", Pose(), Inertial(20.0, Pose((0.0, 0.0, -0.05)), (0.4, 1.2, 1.4, 0.0, 0.0, 0.0)),
        (Visual("body", body),), (Collision("body", body),),
    )  # fmt: skip
    optics = Camera(
        "camera", f"/{name}/camera", CAMERA_HZ, FIELD_OF_VIEW, WIDTH, HEIGHT,
        pose=Pose.from_rpy((0.0, 0.0, 0.0), 0.0, tilt, 0.0),
    )  # fmt: skip
    eye = Link(
        "eye", Pose((0.0, 0.0, CAMERA_HEIGHT - WHEEL_RADIUS)),
        Inertial(0.1, inertia=(1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0)), sensors=(optics,),
    )  # fmt: skip
    corners = {
        f"{end}_{side}": (0.25 * along, TRACK / 2 * across)
        for end, along in (("back", -1), ("front", 1))
        for side, across in (("left", 1), ("right", -1))
    }
    wheels = {corner: _wheel(corner, *place) for corner, place in corners.items()}
    joints = [
        Joint(corner, "continuous", "base", wheel.name, wheel.pose, (0.0, 1.0, 0.0))
        for corner, wheel in wheels.items()
    ]
    drive = WheelDrive(
        "drive", f"/{name}/cmd_vel", ("back_left", "front_left"), ("back_right", "front_right"), TRACK,
        2 * WHEEL_RADIUS, torque=20.0, timeout=DRIVE_TIMEOUT_S, rate_hz=50.0,
        odometry_topic=f"/{name}/odom", wheel_speeds_topic=f"/{name}/wheel_speeds",
    )  # fmt: skip
    return Model(
        name, (base, eye, *wheels.values()), (Joint("mast", "fixed", "base", "eye"), *joints), (drive,),
        at(x, y, WHEEL_RADIUS, yaw=yaw), joint_states_topic=f"/{name}/joint_states",
    )  # fmt: skip


def _wheel(corner: str, x: float, y: float) -> Link:
    shape, lying = Cylinder(WHEEL_RADIUS, WHEEL_WIDTH), Pose.from_rpy((0.0, 0.0, 0.0), pi / 2, 0.0, 0.0)
    moment = (0.01, 0.02, 0.01, 0.0, 0.0, 0.0)
    return Link(
        f"{corner}_wheel", Pose((x, y, 0.0)), Inertial(2.0, inertia=moment),
        (Visual("tyre", shape, lying),), (Collision("tyre", shape, lying),),
    )  # fmt: skip


def pendulum(damping: float = 2.0) -> Model:
    """Return a pendulum bob on a joint along y at height 2, its mass ahead of the joint."""
    bob = Link("bob", Pose(), Inertial(2.0, Pose((0.5, 0.0, 0.0)), (0.02, 0.02, 0.02, 0.0, 0.0, 0.0)))
    joint = Joint("joint", "revolute", "world", "bob", Pose(), (0, 1, 0), -0.5, 0.6, damping=damping)
    return Model("pendulum", (bob,), (joint,), pose=at(0, 0, 2), joint_states_topic="/pendulum/joint_states")


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

    def image_of(self, world: World, robot: str = "robot") -> Pixels:
        """Return the next image of a robot's camera, as signed integers."""
        self.require_camera()
        images = world.subscribe(f"/{robot}/camera")
        self.run(world, seconds(world.now_ns) + 1 / CAMERA_HZ)
        stamped = images.latest
        assert stamped is not None, "no image within one period"
        world.unsubscribe(images)
        return np.asarray(stamped.message.data, dtype=np.int64)

    def movable(self, *models: Model) -> tuple[Model, ...]:
        """Return the models that the world supports; without dynamics, no free bodies."""
        return tuple(m for m in models if self.capabilities.dynamics or m.static or m.drives)

    def require(self, capability: str) -> None:
        """Skip the test if a capability is not declared."""
        if not getattr(self.capabilities, capability):
            skip_undeclared(capability.replace("_", " "))

    def require_camera(self) -> None:
        """Skip the test if cameras are not declared."""
        if not self.capabilities.renderers:
            skip_undeclared("cameras")


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
