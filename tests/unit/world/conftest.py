"""A world without a simulator: a robot that is a point with a heading, moved by Euler steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import cos, sin
from typing import Any

import numpy as np
import pytest

from nrp_core.scene.model import Box, Joint, Light, Link, Model, Rgba, Scene, Sphere, Visual
from nrp_core.scene.rigid import BodyVelocity, JointStates, ModelMotion, Pose
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.drives.wheels import WheelDrive
from nrp_core.world.engine import Engine
from nrp_core.world.sensors.camera import Camera
from nrp_core.world.world import World

STEP_NS = 2_000_000

ROBOT = Model(
    "husky",
    links=(
        Link(
            "base_link",
            sensors=(Camera("camera", "/husky/camera", 30.0, 1.57, 4, 3),),
            visuals=(Visual("deck", Box((1, 1, 1)), rgba=(1.0, 0.8, 0.0, 1.0)),),
        ),
        Link("left_wheel"),
        Link("right_wheel"),
    ),
    joints=(
        Joint("left_joint", "continuous", "base_link", "left_wheel"),
        Joint("right_joint", "continuous", "base_link", "right_wheel"),
    ),
    drives=(
        WheelDrive(
            "drive",
            "/husky/cmd_vel",
            ("left_joint",),
            ("right_joint",),
            separation=0.5,
            wheel_diameter=0.4,
            odometry_topic="/husky/odom",
            wheel_speeds_topic="/husky/wheel_speeds",
        ),
    ),
    pose=Pose.from_rpy((1.0, 0.0, 0.0), 0.0, 0.0, 0.5),
    joint_states_topic="/husky/joint_states",
)
SCREEN = Model(
    "screen",
    links=(Link("body", visuals=(Visual("glass", Sphere(1), rgba=(0.0, 0.0, 1.0, 1.0)),)),),
    pose=Pose((0.0, 2.0, 0.0)),
    static=True,
)


class PointEngine(Engine):
    """Knows what was asked of it: ``renders``, ``colors``, ``steps``."""

    def __init__(self, scene: Scene, *, snapshot: bool = True) -> None:
        capabilities = WorldCapabilities(STEP_NS, snapshot=snapshot)
        super().__init__(scene, capabilities, seed=1, identity="point")
        self.colors: dict[str, Rgba] = {}
        self.renders = 0
        self.fails = False
        self._do_reset(1)

    def _do_reset(self, seed: int) -> None:
        start = self.scene.models[0].pose
        self.steps = 0
        self.x, self.y, self.heading = start.position[0], start.position[1], start.yaw
        self.velocity = BodyVelocity()

    def _do_advance(self, steps: int) -> None:
        if self.fails:
            raise ZeroDivisionError("in the engine")
        for _ in range(steps):
            self.steps += 1
            self.x += self.velocity.forward * cos(self.heading) * STEP_NS / 1e9
            self.y += self.velocity.forward * sin(self.heading) * STEP_NS / 1e9
            self.heading += self.velocity.turn * STEP_NS / 1e9

    def _do_model_motion(self, model: str) -> ModelMotion:
        assert model == "husky", "what is static is not asked for"
        speed = self.velocity.forward
        linear = (speed * cos(self.heading), speed * sin(self.heading), 0.0)
        pose = Pose.from_rpy((self.x, self.y, 0.0), 0.0, 0.0, self.heading)
        return ModelMotion(pose, linear, (0.0, 0.0, self.velocity.turn))

    def _do_joint_states(self, model: str) -> JointStates:
        left = self.velocity.forward - self.velocity.turn * 0.25
        right = self.velocity.forward + self.velocity.turn * 0.25
        speeds = np.array([left, right]) / 0.2
        return JointStates(("left_joint", "right_joint"), np.zeros(2), speeds, np.zeros(2))

    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        assert (model, drive) == ("husky", "drive")
        self.velocity = velocity

    def _do_set_color(self, visual: str, rgba: Rgba) -> None:
        self.colors[visual] = rgba

    def _do_render(self, model: str, link: str, camera: str) -> np.ndarray:
        assert (model, link, camera) == ("husky", "base_link", "camera")
        self.renders += 1
        return np.full((3, 4, 3), self.steps % 256, np.uint8)

    def _do_save(self) -> object:
        return self.steps, self.x, self.y, self.heading

    def _do_restore(self, saved: Any) -> None:
        self.steps, self.x, self.y, self.heading = saved

    def _do_close(self) -> None:
        pass


Opener = Callable[..., World]


@pytest.fixture
def open_world() -> Opener:
    """Open a world with the robot and a screen, and with another camera rate or drive time-out."""

    def open_it(
        *, rate_hz: float = 30.0, timeout: float = 0.1, snapshot: bool = True, delay_s: float = 0.0
    ) -> World:
        base, *wheels = ROBOT.links
        camera = replace(base.sensors[0], rate_hz=rate_hz)
        drive = replace(ROBOT.drives[0], timeout=timeout)
        robot = replace(ROBOT, links=(replace(base, sensors=(camera,)), *wheels), drives=(drive,))
        delays = (("/husky/cmd_vel", delay_s),) if delay_s else ()
        scene = Scene((robot, SCREEN), (Light("sun"),), command_delays=delays)
        return World(PointEngine(scene, snapshot=snapshot))

    return open_it


@pytest.fixture
def room(open_world: Opener) -> World:
    """A world with everything at its default."""
    return open_world()
