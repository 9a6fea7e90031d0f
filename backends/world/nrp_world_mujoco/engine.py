"""A scene in MuJoCo."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.clock import seconds
from nrp_core.errors import DivergedError
from nrp_core.findings import Code
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.model import Scene
from nrp_core.scene.rigid import BodyPath, JointStates, JointTargets, Pose, Quaternion, ReadFrames, Wrench
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.engine import MOST_RATE
from nrp_core.world.engine_kit.jointed import JointedEngine, MotionOf
from nrp_world_mujoco.build import Built, build
from nrp_world_mujoco.control import Control
from nrp_world_mujoco.creep import Creep
from nrp_world_mujoco.drive import Decays, Drive
from nrp_world_mujoco.library import SAID, mujoco, scalar_first
from nrp_world_mujoco.motion import Floating, JointReader, motion_of
from nrp_world_mujoco.muscles import ActuatorGroup, PresentState
from nrp_world_mujoco.one_file import settings_of

if TYPE_CHECKING:
    from nrp_world_mujoco.backend import MujocoOptions


class MujocoEngine(JointedEngine):
    """A scene in MuJoCo; see :class:`~nrp_world_mujoco.backend.MujocoOptions`."""

    _built: Built
    _options: MujocoOptions
    _control: Control
    _drives: dict[tuple[str, str], Drive]
    _joints: dict[str, JointReader]

    def __init__(
        self,
        scene: Scene,
        *,
        seed: int,
        capabilities: WorldCapabilities,
        options: MujocoOptions,
        built: Built | None = None,
    ) -> None:
        name = f"mujoco {mujoco.__version__}"
        super().__init__(scene, seed=seed, capabilities=capabilities, options=options, name=name)
        self._do_load(scene, built)
        self._warm_up()

    @property
    def motions(self) -> Mapping[str, MotionOf]:
        """The readers of the motions of models."""
        return self._motions

    @property
    def drives(self) -> Mapping[tuple[str, str], Drive]:
        """The drives, by model and name."""
        return self._drives

    def copy(self, seed: int) -> MujocoEngine:
        """Open the same scene again without compiling it."""
        built = self._built
        if built.servos or built.firm:  # gains are written into the model
            built = replace(built, model=copy(built.model))
        has, options = self.capabilities, self._options
        return MujocoEngine(self.scene, seed=seed, capabilities=has, options=options, built=built)

    def _do_load(self, scene: Scene, built: Built | None = None) -> None:
        options = self._options
        physical = options.drive == "physical"
        self._built = built or build(
            scene, timestep_ns=options.timestep, physical=physical, impratio=options.impratio
        )
        self._model = self._built.model
        self.warnings += self._built.warnings
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
        self._present = PresentState(self._model, self._data)
        self._groups: dict[tuple[str, tuple[str, ...]], ActuatorGroup] = {}
        self._creep = Creep(self._built, self._data)
        self._decays = Decays(self._built, self._data, seconds(options.timestep))
        self._survey(scene)
        self._refresh()

    def _do_motion_of(self, body: Body, place: int, offset: Pose) -> MotionOf:
        return motion_of(body, place, offset, self._model, self._data, self._refresh_rates)

    def _do_base(self, body: Body, place: int) -> Floating:
        return Floating(self._model, self._data, place)

    def _drive_of(self, path: tuple[str, str]) -> Drive:
        servo, actuators = self._built.drives[path]
        _, ident = self._built.bodies[path[0]][servo.body]
        base = Floating(self._model, self._data, ident)
        return Drive(self._data, servo, base, actuators, seconds(self.capabilities.step_ns))

    def retarget(self, model: str, targets: JointTargets) -> bool:
        return self._control.firm.retarget(model, targets)

    def _do_joint_states(self, model: str) -> JointStates:
        states = super()._do_joint_states(model)
        self._control.firm.add_efforts(model, states)
        return states

    def _do_joint_wrench(self, model: str, joint: str) -> Wrench:
        with self._decays.acting():
            return super()._do_joint_wrench(model, joint)

    def _do_advance(self, steps: int) -> None:
        if self._decays:
            self._decays.advance(steps, self._step)
        else:
            self._step(steps)
        self._stale = True
        for held, holder, speed in self._creep.after(steps):
            speed_mm = f"{1e3 * speed:.2g} mm/s"
            message = f"'{held}' slides along '{holder}' at {speed_mm}, although friction should hold it"
            self.warnings.add(Code.NRP386, message, subject=held)
        if SAID or self._warned.tobytes() != self._calm:
            self._report_warnings()

    def _step(self, steps: int) -> None:
        if self._control.firm.active:
            self._control.firm.step(steps)
        else:
            mujoco.mj_step(self._model, self._data, steps)

    def _survey(self, scene: Scene) -> None:
        super()._survey(scene)
        places = [self._model.jnt_qposadr[self._model.dof_jntid[dof]]
                  for joints in self._built.joints.values() for dof in joints.values()]  # fmt: skip
        low, high = (
            np.concatenate([np.empty(0), *(getattr(one, end) for one in self._bounds.values())])
            for end in ("low", "high")
        )
        limited = np.isfinite(low)
        self._limited = np.array(places, int)[limited]
        self._low, self._high = low[limited], high[limited]

    def _put_at_start(self, scene: Scene) -> None:
        """Put the joints at their initial positions, which in MJCF may be beyond the limits."""
        for model in scene.models:
            for name, position in model.starts if settings_of(model) else ():
                self._do_put_joint(self._built.joints[model.name][name], position)
        super()._put_at_start(replace(scene, models=tuple(m for m in scene.models if not settings_of(m))))

    def check_state(self, t_ns: int) -> None:
        positions, rates = self._positions, self._data.qvel  # sums of squares are faster than a look at each
        calm = isfinite(positions.dot(positions)) and rates.dot(rates) < MOST_RATE**2
        if calm and len(self._limited):
            now = positions.take(self._limited)
            calm = not ((now < self._low) | (now > self._high)).any()
        if not calm:
            super().check_state(t_ns)
            if not abs(rates).max() < MOST_RATE:
                message = f"MuJoCo diverged: a body moves at {abs(rates).max():.4g} m/s (or rad/s)"
                raise DivergedError(message, t_ns=t_ns)

    def _do_reset(self, seed: int) -> None:
        mujoco.mj_resetData(self._model, self._data)
        self._control.release()
        self._put_at_start(self.scene)
        self._continue()

    def _do_frames(self, paths: Sequence[BodyPath]) -> ReadFrames:
        ids = np.array([self._built.bodies[model][index][1] for model, index in paths], int)

        def read(frames: FloatArray) -> None:
            self._refresh()
            frames[:, :, :3] = self._data.xmat[ids].reshape(-1, 3, 3)
            frames[:, :, 3] = self._data.xpos[ids]

        return read

    def model_pose(self, model: str) -> Pose:
        motion = self._motions[model]
        return motion.pose() if isinstance(motion, Floating) else motion().pose

    def read_motion(self, model: str, row: FloatArray) -> None:
        motion = self._motions[model]
        if isinstance(motion, Floating):
            motion.read(row)
        else:
            super().read_motion(model, row)

    def set_control(self, model: str, actuator: str, value: float) -> None:
        self._data.ctrl[self._model.actuator_ctrladr[self._built.actuators[model, actuator]]] = value

    def set_controls(self, model: str, actuators: Sequence[str], values: FloatArray) -> None:
        self._data.ctrl[self._group(model, actuators).controls] = values

    def _do_actuator_states(self, model: str, actuators: Sequence[str]) -> FloatArray:
        return self._present.states(self._group(model, actuators))

    def _group(self, model: str, actuators: Sequence[str]) -> ActuatorGroup:
        path = model, tuple(actuators)
        if path not in self._groups:
            numbers = [self._built.actuators[model, name] for name in actuators]
            self._groups[path] = self._present.group(numbers)
        return self._groups[path]

    def _do_sensor_values(self, model: str, sensor: str) -> FloatArray:
        return self._present.sensor(self._built.sensors[model, sensor])

    def _do_put_joint(self, place: int, position: float) -> None:
        self._data.qpos[self._model.jnt_qposadr[self._model.dof_jntid[place]]] = position
        self._data.qvel[place] = 0.0

    def _do_put_ball(self, place: int, orientation: Quaternion) -> None:
        start = self._model.jnt_qposadr[self._model.dof_jntid[place]]
        self._data.qpos[start : start + 4] = scalar_first(orientation)
        self._data.qvel[place : place + 3] = 0.0

    def _do_configuration(self, model: str) -> object:
        positions, velocities = self._places(model)
        return self._data.qpos[positions].copy(), self._data.qvel[velocities].copy()

    def _do_configure(self, model: str, configuration: Any) -> None:
        positions, velocities = self._places(model)
        self._data.qpos[positions], self._data.qvel[velocities] = configuration
        self._continue(model)

    def _places(self, model: str) -> tuple[IntArray, IntArray]:
        """Return the parts of the state that belong to a model."""
        positions, velocities = self._joints[model].places
        roots = [self._model.body_jntadr[i] for body, i in self._built.bodies[model] if body.floats]
        free = [np.arange(7) + self._model.jnt_qposadr[joint] for joint in roots]
        moving = [np.arange(6) + self._model.jnt_dofadr[joint] for joint in roots]
        return np.concatenate([positions, *free]), np.concatenate([velocities, *moving])

    def _do_save(self) -> object:
        mujoco.mj_getState(self._model, self._data, self._buffer, mujoco.mjtState.mjSTATE_INTEGRATION)
        return self._buffer.tobytes(), self._data.qfrc_actuator.tobytes(), self._control.firm.save()

    def _do_restore(self, saved: Any) -> None:
        state, efforts, firm = saved
        self._buffer[:] = np.frombuffer(state)
        mujoco.mj_setState(self._model, self._data, self._buffer, mujoco.mjtState.mjSTATE_INTEGRATION)
        self._data.qfrc_actuator[:] = np.frombuffer(efforts)
        self._continue()
        self._control.restore(firm)

    def _moved(self, model: str) -> None:
        self._control.firm.forget(model)
        self._continue(model)

    def _continue(self, model: str | None = None) -> None:
        super()._continue(model)
        self._creep.forget()
        self._stale = True
        self._mute_warnings()

    def _refresh(self) -> None:
        """Update the positions of bodies, which are one step behind after a step."""
        if self._stale:
            mujoco.mj_kinematics(self._model, self._data)
            self._stale, self._rates_stale = False, True

    def _refresh_rates(self) -> None:
        """Update also the velocities of bodies."""
        self._refresh()
        if self._rates_stale:
            mujoco.mj_comPos(self._model, self._data)
            mujoco.mj_comVel(self._model, self._data)
            self._rates_stale = False

    def _mute_warnings(self) -> None:
        """Mark every kind of warning as given: MuJoCo prints and logs only the first one."""
        self._warned[:] = 1

    def _report_warnings(self) -> None:
        kinds = mujoco.mjtWarning
        bad = (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC)
        if any(self._warned[kind] > 1 for kind in bad):
            t_ns = self.now_ns
            raise DivergedError(
                f"MuJoCo diverged after {seconds(t_ns):g} s: a position, velocity or acceleration is huge or "
                f"not finite; a shorter timestep or smaller commands may help",
                t_ns=t_ns,
            )
        for kind, count in enumerate(self._warned):
            if count > 1:
                self.warnings.add(Code.NRP277, f"MuJoCo: {mujoco.mju_warningText(kind, 0)}")
        while SAID:
            self.warnings.add(Code.NRP277, f"MuJoCo: {SAID.popitem()[0]}")
        self._mute_warnings()
