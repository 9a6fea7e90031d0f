"""A scene in MuJoCo, at a time."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrp_core.clock import seconds
from nrp_core.errors import DivergedError
from nrp_core.world.interface import ImageArray, World, WorldCapabilities
from nrp_core.world.parts.base import BodyVelocity, JointStates, ModelMotion
from nrp_core.world.physics.bodies import body_of
from nrp_core.world.render.optics import optics_of
from nrp_core.world.scene.model import Model, Rgba, Scene
from nrp_world_mujoco.backend import MujocoOptions
from nrp_world_mujoco.build import build
from nrp_world_mujoco.cameras import open_cameras
from nrp_world_mujoco.drive import Drive
from nrp_world_mujoco.engine import mujoco
from nrp_world_mujoco.motion import Floating, JointReader, MotionOf, motion_of


class MujocoWorld(World):
    """A scene in MuJoCo; see :class:`~nrp_world_mujoco.backend.MujocoBackend` for the options."""

    def __init__(
        self, scene: Scene, *, seed: int, capabilities: WorldCapabilities, options: MujocoOptions
    ) -> None:
        identity = f"mujoco {mujoco.__version__} {options.model_dump_json()}"
        super().__init__(scene, seed=seed, capabilities=capabilities, identity=identity)
        renderer, optics = capabilities.renderers[0], optics_of(scene, options.image_scale)
        self._built = build(scene, timestep_ns=options.timestep, optics=optics, visuals=renderer != "raster")
        self._model = self._built.model
        self._data = mujoco.MjData(self._model)
        self._buffer = np.empty(mujoco.mj_stateSize(self._model, mujoco.mjtState.mjSTATE_INTEGRATION))
        self._warned = self._data.warning.number
        self._mute_warnings()
        self._calm = self._warned.tobytes()
        self._stale = True
        self._drives = {path: self._drive_of(path) for path in self._built.drives}
        self._joints = {
            name: JointReader(self._model, self._data, joints) for name, joints in self._built.joints.items()
        }
        self._motions = {model.name: self._motion_of(model) for model in scene.models}
        self._refresh()
        self._cameras = open_cameras(renderer, self._built, self._data, optics)

    def _motion_of(self, model: Model) -> MotionOf:
        bodies = self._built.bodies[model.name]
        body, ident = bodies[body_of([body for body, _ in bodies], model.links[0].name)]
        return motion_of(model, body, ident, self._model, self._data, self._refresh)

    def _drive_of(self, path: tuple[str, str]) -> Drive:
        servo, actuators = self._built.drives[path]
        _, ident = self._built.bodies[path[0]][servo.body]
        base = Floating(self._model, self._data, ident)
        return Drive(self._data, servo, base, actuators, seconds(self.capabilities.step_ns))

    def _do_advance(self, steps: int) -> None:
        mujoco.mj_step(self._model, self._data, steps)
        self._stale = True
        if self._warned.tobytes() != self._calm:
            self._report_warnings()

    def _do_reset(self, seed: int) -> None:
        mujoco.mj_resetData(self._model, self._data)
        self._continue()

    def _do_model_motion(self, model: str) -> ModelMotion:
        return self._motions[model]()

    def _do_joint_states(self, model: str) -> JointStates:
        return self._joints[model].states()

    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        self._drives[model, drive].aim(velocity)

    def _do_set_color(self, visual: str, rgba: Rgba) -> None:
        self._cameras.set_color(visual, rgba)

    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        self._refresh()
        return self._cameras.picture((model, link, camera))

    def _do_save(self) -> object:
        mujoco.mj_getState(self._model, self._data, self._buffer, mujoco.mjtState.mjSTATE_INTEGRATION)
        return self._buffer.tobytes(), self._data.qfrc_actuator.tobytes()

    def _do_restore(self, saved: Any) -> None:
        state, efforts = saved
        self._buffer[:] = np.frombuffer(state)
        mujoco.mj_setState(self._model, self._data, self._buffer, mujoco.mjtState.mjSTATE_INTEGRATION)
        self._data.qfrc_actuator[:] = np.frombuffer(efforts)
        self._continue()

    def _do_close(self) -> None:
        self._cameras.close()

    def _continue(self) -> None:
        """Start from another state than the one reached by steps."""
        self._stale = True
        self._mute_warnings()
        for drive in self._drives.values():
            drive.forget()

    def _refresh(self) -> None:
        """Bring the positions of bodies and cameras up to date; a step leaves them one behind."""
        if self._stale:
            mujoco.mj_kinematics(self._model, self._data)
            mujoco.mj_camlight(self._model, self._data)
            self._stale = False

    def _mute_warnings(self) -> None:
        """Let every kind of warning count as given once: MuJoCo prints and logs only the first."""
        self._warned[:] = 1

    def _report_warnings(self) -> None:
        kinds = mujoco.mjtWarning
        bad = (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC)
        if any(self._warned[kind] > 1 for kind in bad):
            t_ns = self._at_ns
            raise DivergedError(
                f"MuJoCo diverged after {seconds(t_ns):g} s: a position, velocity or acceleration is huge or "
                f"not finite; a shorter timestep may help",
                t_ns=t_ns,
            )
        for kind, count in enumerate(self._warned):
            if count > 1:
                self.warnings.append(f"MuJoCo: {mujoco.mju_warningText(kind, 0)}")
        self._mute_warnings()
