"""A scene in PyBullet, at a time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core.clock import seconds
from nrp_core.errors import DivergedError
from nrp_core.world.interface import ImageArray, World, WorldCapabilities
from nrp_core.world.parts.base import BodyVelocity, JointStates, ModelMotion
from nrp_core.world.physics.bodies import body_of
from nrp_core.world.render.optics import optics_of
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.model import Model, Rgba, Scene
from nrp_world_pybullet.backend import PybulletOptions
from nrp_world_pybullet.build import build
from nrp_world_pybullet.cameras import open_cameras
from nrp_world_pybullet.drive import Drive
from nrp_world_pybullet.engine import bullet
from nrp_world_pybullet.motion import JointReader, MotionOf, motion_of

FloatArray = npt.NDArray[np.float64]


class PybulletWorld(World):
    """A scene in PyBullet; see :class:`~nrp_world_pybullet.backend.PybulletBackend` for the options."""

    def __init__(
        self, scene: Scene, *, seed: int, capabilities: WorldCapabilities, options: PybulletOptions
    ) -> None:
        identity = f"pybullet {bullet.getAPIVersion()} {options.model_dump_json()}"
        super().__init__(scene, seed=seed, capabilities=capabilities, identity=identity)
        self._client = bullet.connect(bullet.DIRECT)
        try:
            self._open(scene, options)
        except BaseException:
            self.close()
            raise

    def _open(self, scene: Scene, options: PybulletOptions) -> None:
        client = self._client
        renderer, optics = self.capabilities.renderers[0], optics_of(scene, options.image_scale)
        self._built = build(scene, timestep_ns=options.timestep, client=client, visuals=renderer != "raster")
        self._drives = {path: self._drive_of(path, seconds(options.timestep)) for path in self._built.drives}
        self._joints = {name: JointReader(joints, client) for name, joints in self._built.joints.items()}
        # of these not even the base moves, by which divergence would be noticed
        self._anchored = [self._joints[model.name] for model in scene.models if _is_anchored(model)]
        self._motions = {model.name: self._motion_of(model) for model in scene.models}
        self._cameras = open_cameras(renderer, self._built, client, optics)
        self._efforts: dict[str, FloatArray] = {}
        self._start = bullet.saveState(physicsClientId=client)

    def _drive_of(self, path: tuple[str, str], step_s: float) -> Drive:
        servo = self._built.drives[path]
        body, _ = self._built.bodies[path[0]][servo.body]
        joints = self._built.joints[path[0]]
        wheels = [joints[wheel.joint] for wheel in servo.wheels]
        return Drive(self._client, servo, body, wheels, step_s, self.scene.gravity)

    def _motion_of(self, model: Model) -> MotionOf:
        bodies = self._built.bodies[model.name]
        body, place = bodies[body_of([body for body, _ in bodies], model.links[0].name)]
        return motion_of(model, body, place, self._client)

    def _do_advance(self, steps: int) -> None:
        self._efforts = {}
        drives, client, step = tuple(self._drives.values()), self._client, bullet.stepSimulation
        for _ in range(steps):
            for drive in drives:
                drive.push()
            step(client)
        for joints in self._anchored:
            if not joints.finite():
                raise DivergedError("PyBullet diverged: a joint's position is not finite", t_ns=self._at_ns)

    def _do_reset(self, seed: int) -> None:
        bullet.restoreState(self._start, physicsClientId=self._client)
        self._continue({name: np.zeros(len(joints)) for name, joints in self._built.joints.items()})

    def _do_model_motion(self, model: str) -> ModelMotion:
        return self._motions[model]()

    def _do_joint_states(self, model: str) -> JointStates:
        states = self._joints[model].states()
        return replace(states, efforts=self._efforts[model]) if model in self._efforts else states

    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        self._drives[model, drive].aim(velocity)

    def _do_set_color(self, visual: str, rgba: Rgba) -> None:
        self._cameras.set_color(visual, rgba)

    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        return self._cameras.picture((model, link, camera))

    def _do_save(self) -> object:
        efforts = {name: self._do_joint_states(name).efforts for name in self._joints}
        with TemporaryDirectory() as folder:
            file = Path(folder) / "state.bullet"
            bullet.saveBullet(str(file), physicsClientId=self._client)
            return file.read_bytes(), efforts

    def _do_restore(self, saved: Any) -> None:
        state, efforts = saved
        with TemporaryDirectory() as folder:
            file = Path(folder) / "state.bullet"
            file.write_bytes(state)
            bullet.restoreState(fileName=str(file), physicsClientId=self._client)
        self._continue(efforts)

    def _do_close(self) -> None:
        bullet.disconnect(self._client)

    def _continue(self, efforts: dict[str, FloatArray]) -> None:
        """Start from another state than the one reached by steps; PyBullet keeps no efforts with a state."""
        self._efforts = efforts
        for drive in self._drives.values():
            drive.forget()


def _is_anchored(model: Model) -> bool:
    return not model.static and any(joint.parent == WORLD for joint in model.joints)
