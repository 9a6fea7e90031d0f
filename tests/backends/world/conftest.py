"""Every test here runs on both physics engines, on scenes made of a few parts."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from math import inf, pi
from pathlib import Path
from typing import Any

import jointed
import numpy as np
import numpy.typing as npt
import pytest

from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.scene.model import (
    Box,
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
)
from nrp_core.scene.rigid import Pose
from nrp_core.world.backend import WorldBackend
from nrp_core.world.backends import worlds
from nrp_core.world.drives.wheels import WheelDrive
from nrp_core.world.sensors.camera import Camera
from nrp_core.world.world import World

BACKENDS = ("mujoco", "pybullet")
GREY: Rgba = (0.6, 0.6, 0.6, 1.0)
WHEEL_RADIUS = 0.17775
AXLE_HEIGHT = 0.035
STANDING = WHEEL_RADIUS - AXLE_HEIGHT  # height of the base above the floor

OpenWorld = Callable[..., World]
Look = Callable[..., npt.NDArray[np.uint8]]


@pytest.fixture(params=BACKENDS)
def backend(request: pytest.FixtureRequest) -> WorldBackend:
    return load(request.param)


def load(name: str) -> WorldBackend:
    if importlib.util.find_spec(name) is None:
        pytest.skip(f"{name} is not installed")
    return worlds().load(name)


@pytest.fixture
def read(tmp_path: Path) -> Callable[[str], Model]:
    """Read the contents of a <model>."""
    return partial(jointed.read, tmp_path)


@pytest.fixture
def open_world(backend: WorldBackend) -> Iterator[OpenWorld]:
    """Open a scene, or models, in the backend; the world is closed after the test."""
    with ExitStack() as opened:

        def open_world(*models: Model | Scene, seed: int = 1, **options: Any) -> World:
            scene = models[0] if isinstance(models[0], Scene) else Scene(models)  # type: ignore[arg-type]
            world = backend.open(scene, seed=seed, options=backend.options(**options))
            return opened.enter_context(world)

        yield open_world


@pytest.fixture(scope="session")
def engines() -> list[WorldBackend]:
    """Both backends, for tests that compare them."""
    return [load(name) for name in BACKENDS]


@pytest.fixture
def look(backend: WorldBackend) -> Look:
    """Take the first image of the robot's camera in a scene of models."""

    def look(*models: Model, **options: Any) -> npt.NDArray[np.uint8]:
        with backend.open(Scene(models), seed=1, options=backend.options(**options)) as world:
            return world.engine.render("husky", "eye", "camera")

    return look


class Parts:
    """Models to put scenes together from."""

    standing = STANDING
    tyre: Rgba = (0.1, 0.1, 0.1, 1.0)

    @staticmethod
    def prop(
        name: str,
        geometry: Geometry,
        pose: Pose = Pose(),
        *,
        mass: float = 0.0,
        rgba: Rgba = GREY,
        friction: float = 1.0,
        solid: bool = True,
    ) -> Model:
        """Return one link; static unless it has a mass. Its visual is ``<name>/link/visual``."""
        moment = mass * 0.01
        link = Link(
            "link",
            inertial=Inertial(mass, inertia=(moment, moment, moment, 0.0, 0.0, 0.0)) if mass else None,
            visuals=(Visual("visual", geometry, rgba=rgba),),
            collisions=(Collision("collision", geometry, friction=friction),) if solid else (),
        )
        return Model(name, (link,), pose=pose, static=not mass)

    @classmethod
    def floor(cls, friction: float = 1.0) -> Model:
        return cls.prop("floor", Plane((30.0, 30.0)), friction=friction, rgba=(0.5, 0.5, 0.4, 1.0))

    @classmethod
    def wall(cls, x: float, rgba: Rgba = GREY) -> Model:
        """Return a wall whose face towards the origin is at ``x``."""
        return cls.prop("wall", Box((0.2, 8.0, 2.0)), Pose((x + 0.1, 0.0, 1.0)), rgba=rgba)

    @staticmethod
    def hanging(
        kind: str,
        axis: tuple[float, float, float],
        *,
        lower: float = -inf,
        upper: float = inf,
        com: tuple[float, float, float] = (0.0, 0.0, -0.5),
        damping: float = 0.0,
    ) -> Model:
        """Return a bob of 2 kg that a joint at height 2 m holds to the world."""
        bob = Link("bob", inertial=Inertial(2.0, Pose(com), (0.02, 0.02, 0.02, 0.0, 0.0, 0.0)))
        joint = Joint("joint", kind, "world", "bob", axis=axis, lower=lower, upper=upper, damping=damping)
        return Model("hanging", (bob,), (joint,), pose=Pose((0.0, 0.0, 2.0)))

    @staticmethod
    def husky(name: str = "husky", pose: Pose | None = None, **camera: Any) -> Model:
        """Return a skid-steered robot with a camera on a mast, standing at the origin."""
        box, chassis = Box((1.0074, 0.5709, 0.2675)), Pose((0.0, 0.0, 0.1))
        base = Link(
            "base_link",
            inertial=Inertial(
                33.855,
                Pose((-0.0856132, -0.000839955, 0.238145)),
                (2.2343, 3.42518, 2.1241, -0.023642, 0.275174, 0.00239624),
            ),
            visuals=(Visual("chassis", box, chassis, (0.9, 0.8, 0.1, 1.0)),),
            collisions=(Collision("chassis", box, chassis),),
        )
        optics = {"rate_hz": 30.0, "horizontal_fov": 1.57, "width": 64, "height": 48} | camera
        eye = Link(
            "eye",
            Pose((-0.16, 0.0, 0.36)),
            Inertial(1.0, inertia=(0.01, 0.01, 0.01, 0.0, 0.0, 0.0)),
            sensors=(Camera("camera", f"/{name}/camera", **optics),),
        )
        corners = {
            "back_left": (-0.256, 0.2855),
            "back_right": (-0.256, -0.2855),
            "front_left": (0.256, 0.2855),
            "front_right": (0.256, -0.2855),
        }
        wheels = [_wheel(corner, x, y) for corner, (x, y) in corners.items()]
        joints = [
            Joint(corner, "continuous", "base_link", f"{corner}_wheel", wheel.pose, (0.0, 1.0, 0.0))
            for corner, wheel in zip(corners, wheels, strict=True)
        ]
        drive = WheelDrive(
            "drive",
            f"/{name}/cmd_vel",
            left=("back_left", "front_left"),
            right=("back_right", "front_right"),
            separation=0.571,
            wheel_diameter=2 * WHEEL_RADIUS,
            torque=35.0,
            odometry_topic=f"/{name}/odom",
            wheel_speeds_topic=f"/{name}/wheel_speeds",
        )
        return Model(
            name,
            (base, eye, *wheels),
            (Joint("mast", "fixed", "base_link", "eye"), *joints),
            (drive,),
            pose or Pose((0.0, 0.0, STANDING)),
            joint_states_topic=f"/{name}/joint_states",
        )


def _wheel(corner: str, x: float, y: float) -> Link:
    shape, lying = Cylinder(WHEEL_RADIUS, 0.1143), Pose.from_rpy((0.0, 0.0, 0.0), -pi / 2, 0.0, 0.0)
    return Link(
        f"{corner}_wheel",
        Pose((x, y, AXLE_HEIGHT)),
        Inertial(2.6357, inertia=(0.0247, 0.0441, 0.0247, 0.0, 0.0, 0.0)),
        (Visual("tyre", shape, lying, Parts.tyre),),
        (Collision("tyre", shape, lying),),
    )


@pytest.fixture(scope="session")
def parts() -> type[Parts]:
    return Parts


def run(world: World, seconds: float) -> None:
    """Advance a world, in steps of 20 ms."""
    for _ in range(round(seconds / 0.02)):
        world.run_until(world.now_ns + 20_000_000)


class Driver:
    """Commands one robot again and again, as an experiment does."""

    def __init__(self, world: World, robot: str = "husky") -> None:
        self._world, self._robot = world, robot
        self._commands = world.advertise(f"/{robot}/cmd_vel")

    def drive(self, forward: float, turn: float, seconds: float) -> Pose:
        """Drive for some time and return where the robot is then."""
        for _ in range(round(seconds / 0.02)):
            self._commands.publish(Twist(Vector3(forward), Vector3(0, 0, turn)))
            self._world.run_until(self._world.now_ns + 20_000_000)
        return self._world.model_motion(self._robot).pose


@pytest.fixture(scope="session")
def driver() -> type[Driver]:
    return Driver


@pytest.fixture(scope="session")
def advance() -> Callable[[World, float], None]:
    return run


@pytest.fixture(scope="session")
def require_to_go_on() -> Callable[[World, World, float, Callable[[World], object]], None]:
    """Require that a world, and a fresh one, go on from a snapshot of now as if nothing had been."""

    def require(world: World, fresh: World, duration_s: float, look: Callable[[World], object]) -> None:
        snapshot = world.snapshot()
        run(world, duration_s)
        expected = look(world)
        for again in (world, fresh):
            again.restore(snapshot)
            run(again, duration_s)
            assert look(again) == expected

    return require
