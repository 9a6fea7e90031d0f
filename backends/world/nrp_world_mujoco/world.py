"""A scene in MuJoCo, at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np

from nrp_core.clock import seconds
from nrp_core.errors import DivergedError
from nrp_core.world.engine import FloatArray, ReadFrames
from nrp_core.world.interface import ImageArray, World, WorldCapabilities
from nrp_core.world.parts.base import (
    BodyPath,
    BodyVelocity,
    DepthArray,
    JointAim,
    JointStates,
    ModelMotion,
    Touch,
    Wrench,
)
from nrp_core.world.physics.bodies import body_of
from nrp_core.world.render.cameras import Cameras
from nrp_core.world.render.optics import optics_of
from nrp_core.world.scene.model import Link, Model, Rgba, Scene
from nrp_core.world.scene.pose import Pose
from nrp_world_mujoco.backend import MujocoOptions
from nrp_world_mujoco.build import Built, build
from nrp_world_mujoco.cameras import frame_reader, open_cameras
from nrp_world_mujoco.control import Control
from nrp_world_mujoco.drive import Drive
from nrp_world_mujoco.engine import mujoco
from nrp_world_mujoco.motion import Floating, IntArray, JointReader, MotionOf, motion_of


class MujocoWorld(World):
    """A scene in MuJoCo; see :class:`~nrp_world_mujoco.backend.MujocoBackend` for the options."""

    def __init__(
        self,
        scene: Scene,
        *,
        seed: int,
        capabilities: WorldCapabilities,
        options: MujocoOptions,
        built: Built | None = None,
    ) -> None:
        identity = f"mujoco {mujoco.__version__} {options.model_dump_json()}"
        super().__init__(scene, seed=seed, capabilities=capabilities, identity=identity)
        self._options = options
        self.image_scale = options.image_scale
        self._cameras: Cameras | None = None
        self._do_load(scene, built)

    def copy(self, seed: int) -> MujocoWorld:
        """Open the same scene once more, without compiling it again."""
        built = self._built
        if built.servos or built.visuals:  # gains and colours are written into the model, else it is shared
            built = replace(built, model=copy(built.model))
        has, options = self.capabilities, self._options
        return MujocoWorld(self._opened, seed=seed, capabilities=has, options=options, built=built)

    def _do_load(self, scene: Scene, built: Built | None = None) -> None:
        options, renderer = self._options, self.capabilities.renderers[0]
        optics, visuals = optics_of(scene, options.image_scale), renderer != "raster"
        self._built = built or build(
            scene,
            timestep_ns=options.timestep,
            optics=optics,
            visuals=visuals,
            physical=options.drive == "physical",
        )
        self._model = self._built.model
        self._data = mujoco.MjData(self._model)
        self._positions = self._data.qpos
        self._buffer = np.empty(mujoco.mj_stateSize(self._model, mujoco.mjtState.mjSTATE_INTEGRATION))
        self._warned = self._data.warning.number
        self._mute_warnings()
        self._calm = self._warned.tobytes()
        self._stale = True
        self._drives = {path: self._drive_of(path) for path in self._built.drives}
        self._joints = {
            name: JointReader(self._model, self._data, joints) for name, joints in self._built.joints.items()
        }
        self._control = Control(self._built, self._data, seconds(options.timestep))
        self._motions = {model.name: self._motion_of(model, model.links[0], None) for model in scene.models}
        self._links: dict[tuple[str, str], MotionOf] = {}
        self._refresh()
        if self._cameras is not None:
            self._cameras.close()
        self._cameras = open_cameras(renderer, self._built, self._data, optics)

    def _motion_of(self, model: Model, link: Link, held: Pose | None) -> MotionOf:
        """Return what reads the motion of a link, or of the model's frame, which the base's body holds."""
        bodies = self._built.bodies[model.name]
        body, ident = bodies[body_of([body for body, _ in bodies], link.name)]
        place = body.in_model.inverse() if held is None else held
        return motion_of(body, ident, place, self._model, self._data, self._refresh)

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

    def _check_finite(self, t_ns: int) -> None:
        if not isfinite(self._positions @ self._positions):  # takes less time than to look at each model
            super()._check_finite(t_ns)

    def _do_reset(self, seed: int) -> None:
        mujoco.mj_resetData(self._model, self._data)
        self._control.release()
        self._continue()

    def _do_model_motion(self, model: str) -> ModelMotion:
        return self._motions[model]()

    def _do_link_motion(self, model: str, link: str) -> ModelMotion:
        path = model, link
        if path not in self._links:
            bodies = [body for body, _ in self._built.bodies[model]]
            held = next(each for each in bodies[body_of(bodies, link)].links if each.name == link)
            self._links[path] = self._motion_of(self.scene.model(model), held, held.pose)
        return self._links[path]()

    def _do_frames(self, paths: Sequence[BodyPath]) -> ReadFrames:
        read = frame_reader(self._built, self._data, paths)

        def refreshed(frames: FloatArray) -> None:
            self._refresh()
            read(frames)

        return refreshed

    def _do_joint_states(self, model: str) -> JointStates:
        return self._joints[model].states()

    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        self._drives[model, drive].aim(velocity)

    def _do_set_color(self, visual: str, rgba: Rgba) -> None:
        assert self._cameras is not None
        self._cameras.set_color(visual, rgba)

    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        self._refresh()
        assert self._cameras is not None
        return self._cameras.picture((model, link, camera))

    def _do_depth(self, model: str, link: str, camera: str) -> DepthArray:
        self._refresh()
        assert self._cameras is not None
        return self._cameras.depth((model, link, camera))

    def _do_touches(self) -> Sequence[Touch]:
        return list(self._control.touches())

    def _do_joint_wrench(self, model: str, joint: str) -> Wrench:
        bodies = self._built.bodies[model]
        return self._control.joint_wrench(
            next(ident for body, ident in bodies if body.joint is not None and body.joint.name == joint)
        )

    def _do_set_joint_aim(self, model: str, joint: str, aim: JointAim) -> None:
        self._control.aim(model, joint, aim)

    def _do_set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        self._control.set_effort(model, joint, effort)

    def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        self._control.set_wrench(body, wrench)

    def _do_place(self, model: str, motion: ModelMotion) -> None:
        to_model = self._do_model_motion(model).pose.inverse()
        for body, ident in self._built.bodies[model]:
            if body.floats:
                base = Floating(self._model, self._data, ident)
                there = motion.at(to_model @ base().pose)
                base.place(there.pose)
                base.set_velocity(there)
        self._continue()

    def _do_set_joints(self, model: str, positions: Mapping[str, float]) -> None:
        for name, position in positions.items():
            joint = self._built.joints[model][name]
            self._data.qpos[self._model.jnt_qposadr[joint]] = position
            self._data.qvel[self._model.jnt_dofadr[joint]] = 0.0
        self._continue()

    def _do_configuration(self, model: str) -> object:
        positions, velocities = self._places(model)
        return self._data.qpos[positions].copy(), self._data.qvel[velocities].copy()

    def _do_configure(self, model: str, configuration: Any) -> None:
        positions, velocities = self._places(model)
        self._data.qpos[positions], self._data.qvel[velocities] = configuration
        self._continue()

    def _places(self, model: str) -> tuple[IntArray, IntArray]:
        """Return where all that moves of a model is in the state."""
        positions, velocities = self._joints[model].places
        roots = [self._model.body_jntadr[i] for body, i in self._built.bodies[model] if body.floats]
        free = [np.arange(7) + self._model.jnt_qposadr[joint] for joint in roots]
        moving = [np.arange(6) + self._model.jnt_dofadr[joint] for joint in roots]
        return np.concatenate([positions, *free]), np.concatenate([velocities, *moving])

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
        if self._cameras is not None:
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
