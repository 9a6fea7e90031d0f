"""A scene in MuJoCo."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import partial
from math import isfinite
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.clock import seconds
from nrp_core.errors import DivergedError
from nrp_core.findings import Code
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.model import Scene
from nrp_core.scene.rigid import (
    BodyPath,
    BodyVelocity,
    JointStates,
    JointTargets,
    LinkMotions,
    Pose,
    Quaternion,
    ReadFrames,
    Touch,
    Wrench,
    rotate_vector,
)
from nrp_core.simulation import Failures, note_failure
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.engine import MOST_RATE
from nrp_core.world.engine_kit.jointed import JointedEngine, MotionOf
from nrp_world_mujoco.build import Built, build
from nrp_world_mujoco.control import Control
from nrp_world_mujoco.creep import Creep
from nrp_world_mujoco.drive import Decays, Drive, set_velocities
from nrp_world_mujoco.library import SAID, mujoco, scalar_first
from nrp_world_mujoco.motion import Floating, JointReader, LinkReader, motion_of
from nrp_world_mujoco.muscles import COMPLETE, ActuatorGroup
from nrp_world_mujoco.one_file import settings_of
from nrp_world_mujoco.workspace import SharedWorkspace, StateRow, Workspace

if TYPE_CHECKING:
    from nrp_world_mujoco.backend import MujocoOptions


_UNSEEN: Final = (None, None)
_SLEEP = mujoco.mjtEnableBit.mjENBL_SLEEP


class MujocoEngine(JointedEngine):
    """A scene in MuJoCo; see :class:`~nrp_world_mujoco.backend.MujocoOptions`.

    Args:
        scene: the scene.
        seed: the seed of the world.
        capabilities: the capabilities under the options.
        options: the options.
        like: another engine with the same scene.
        built: the compiled scene of the other engine, or a copy of it.
    """

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
        like: MujocoEngine | None = None,
        built: Built | None = None,
    ) -> None:
        self._shared: SharedWorkspace | None = None if like is None else like._shared
        name = f"mujoco {mujoco.__version__}"
        super().__init__(scene, seed=seed, capabilities=capabilities, options=options, name=name)
        if like is not None:
            self._share(like)
        self._open(scene, built)
        if like is None:
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
        """Open the same scene again without compiling it.

        The copies of an engine share MuJoCo's data, unless the data contain more than a state.
        """
        built = self._built
        if self._shared is None and not (built.firm or built.model.opt.enableflags & _SLEEP):
            self._shared = SharedWorkspace(built.model)
        if built.servos or built.firm:  # gains are written into the model
            built = replace(built, model=copy(built.model))
        has, options = self.capabilities, self._options
        return MujocoEngine(self.scene, seed=seed, capabilities=has, options=options, like=self, built=built)

    def _do_load(self, scene: Scene) -> None:
        self._shared = None
        self._open(scene, None)

    def _open(self, scene: Scene, built: Built | None) -> None:
        options = self._options
        physical = options.drive == "physical"
        self._built = built or build(
            scene, timestep_ns=options.timestep, physical=physical, impratio=options.impratio
        )
        self._model = self._built.model
        self.warnings += self._built.warnings
        self._work: Workspace = self._shared if built and self._shared else Workspace(self._model)
        shares = isinstance(self._work, SharedWorkspace)
        self._row = StateRow(self._model, has_gains=bool(self._built.servos)) if shares else None
        self._state: Any = self._work.data if self._row is None else self._row
        self._begin_row()
        self._positions, self._rates = self._state.qpos, self._state.qvel
        self._taken = 0
        self._pushes: FloatArray | None = None
        self._moment: object = object()
        self._placed: object = None
        self._rated: object = None
        self._seen: tuple[FloatArray | None, FloatArray | None] = (None, None)
        self._drives = {path: self._drive_of(path) for path in self._built.drives}
        self._joints = {
            name: JointReader(self._model, self._state, joints) for name, joints in self._built.joints.items()
        }
        self._control = Control(self._built, self._state, seconds(options.timestep), self._last_step)
        self._groups: dict[tuple[str, tuple[str, ...]], ActuatorGroup] = {}
        self._link_readers: dict[tuple[str, tuple[str, ...]], LinkReader] = {}
        self._creep = Creep(self._built)
        self._decays = Decays(self._built, seconds(options.timestep))
        # whether steps change only the state, and nothing is looked up in MuJoCo's data after them
        self._takes_plain_steps = shares and not (self._decays or self._creep.watches)
        self._survey(scene)
        self._refresh()

    @property
    def _data(self) -> Any:
        """MuJoCo's data with the current state."""
        return self._loaded().data

    def _do_motion_of(self, body: Body, place: int, offset: Pose) -> MotionOf:
        return motion_of(body, place, offset, self._model, self._state, self._refresh_rates)

    def _do_link_motions(self, model: str, links: tuple[str, ...]) -> LinkMotions:
        reader = self._link_readers.get((model, links))
        if reader is None:
            frames = [self._motion_of_link(model, link) for link in links]
            reader = LinkReader(frames, self._model, self._refresh_rates)
            self._link_readers[model, links] = reader
        return reader()

    def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        self._keep_pushes()
        super()._do_set_wrench(body, wrench)

    def _do_set_wrenches(self, bodies: tuple[BodyPath, ...], wrenches: Sequence[Sequence[float]]) -> None:
        self._keep_pushes()
        places = [self._built.bodies[model][index][1] for model, index in bodies]
        self._state.xfrc_applied[places] = wrenches

    def _keep_pushes(self) -> None:
        """Store the wrenches of the last step on bodies before they change for the first time."""
        if self._pushes is None:
            self._pushes = self._state.xfrc_applied.copy()

    def _do_base(self, body: Body, place: int) -> Floating:
        return Floating(self._model, self._state, place)

    def _drive_of(self, path: tuple[str, str]) -> Drive:
        servo, actuators = self._built.drives[path]
        _, ident = self._built.bodies[path[0]][servo.body]
        base = Floating(self._model, self._state, ident)
        return Drive(self._state, servo, base, actuators, seconds(self.capabilities.step_ns))

    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        super()._do_set_drive(model, drive, velocity)
        self._moment = object()  # it may have changed a velocity

    @classmethod
    def set_drive_of(
        cls, engines: Sequence[MujocoEngine], model: str, drive: str, velocities: Sequence[BodyVelocity]
    ) -> bool:
        if cls._do_set_drive is not MujocoEngine._do_set_drive:
            return False
        set_velocities([engine._drives[model, drive] for engine in engines], velocities)
        for engine in engines:
            engine._moment = object()
        return True

    def _do_set_servo_efforts(self, model: str, joints: tuple[str, ...], efforts: Sequence[float]) -> None:
        if not self._control.set_efforts(model, joints, efforts):
            super()._do_set_servo_efforts(model, joints, efforts)

    @classmethod
    def set_servo_efforts_of(
        cls, engines: Sequence[MujocoEngine], model: str, joints: tuple[str, ...], rows: FloatArray
    ) -> None:
        for engine, row in zip(engines, rows, strict=True):
            if not engine._control.set_efforts(model, joints, row):
                engine._do_set_servo_efforts(model, joints, row.tolist())

    def retarget(self, model: str, targets: JointTargets) -> bool:
        return self._control.firm.retarget(model, targets)

    def _do_joint_states(self, model: str) -> JointStates:
        states = super()._do_joint_states(model)
        self._control.firm.add_efforts(model, states)
        return states

    def _do_joint_wrench(self, model: str, joint: str) -> Wrench:
        if not self._taken:
            return Wrench()
        applied = self._last_step().xfrc_applied
        now = applied.copy()
        applied[:] = self._state.xfrc_applied if self._pushes is None else self._pushes
        self._decays.act_again(applied)
        try:
            return super()._do_joint_wrench(model, joint)
        finally:
            applied[:] = now

    def _do_touches(self) -> Sequence[Touch]:
        return super()._do_touches() if self._taken else ()

    @classmethod
    def advance_all(cls, engines: Sequence[MujocoEngine], steps: int) -> Failures:
        failed: Failures = {}
        first, together = engines[0], [n for n, engine in enumerate(engines) if engine._takes_plain_steps]
        are_alike = _are_alike(engines)
        if len(together) > 1 and are_alike and first._shared is not None:
            said = set(SAID)
            rows = [row for number in together if (row := engines[number]._row) is not None]
            warned = first._shared.steps_of(first._model, rows).take(steps)
            left = [together[place] for place in warned.tolist()]
            for text in SAID.keys() - said if left else ():
                SAID.pop(text, None)
            for number in set(together) - set(left):
                engines[number]._note_steps(steps)
            alone = sorted({*range(len(engines))} - set(together) | set(left))
        else:
            alone = [*range(len(engines))]
        for number in alone:
            note_failure(failed, number, partial(engines[number].advance, steps))
        rest = [number for number in range(len(engines)) if number not in failed]
        if are_alike and rest:
            rest = [rest[place] for place in _restless([engines[number] for number in rest])]
        for number in rest:
            engine = engines[number]
            note_failure(failed, number, partial(engine.check_state, engine.now_ns))
        return failed

    def _note_steps(self, steps: int) -> None:
        """Note steps that were taken together with those of other engines."""
        self._taken, self._pushes, self._seen, self._moment = steps, None, _UNSEEN, object()
        self.now_ns += steps * self.capabilities.step_ns

    def _do_advance(self, steps: int) -> None:
        work, row, model = self._work, self._row, self._model
        data = work.data
        if row is not None:
            row.begin(model, data)
        self._take(data, steps)
        self._taken, self._pushes, self._seen = steps, None, _UNSEEN
        self._moment = moment = object()
        if row is not None:
            row.store(model, data)
            work.loaded, work.placed, work.rated = moment, None, None
        if self._creep.watches:
            self._watch_creep(steps, data)
        if SAID or work.warned.tobytes() != work.muted:
            self._report_warnings(work)

    def _watch_creep(self, steps: int, data: Any) -> None:
        """Report objects that slide although friction should hold them."""
        for held, holder, speed in self._creep.after(steps, data):
            speed_mm = f"{1e3 * speed:.2g} mm/s"
            message = f"'{held}' slides along '{holder}' at {speed_mm}, although friction should hold it"
            self.warnings.add(Code.NRP386, message, subject=held)

    def _take(self, data: Any, steps: int) -> None:
        """Take steps from the state in the data."""
        if self._decays:
            self._decays.advance(data, steps, self._step)
        elif self._built.firm:
            self._step(data, steps)
        else:
            mujoco.mj_step(self._model, data, steps)

    def _step(self, data: Any, steps: int) -> None:
        if self._control.firm.active:
            self._control.firm.step(steps)
        else:
            mujoco.mj_step(self._model, data, steps)

    def _last_step(self) -> Any:
        """Return MuJoCo's data of the last step: its contacts and forces, which are not part of a state.

        The first call repeats the last step, in data that belong to this state alone from then on.
        """
        if self._row is not None and self._work is self._shared:
            self._work = Workspace(self._model)
            data, (placed, rated) = self._work.data, self._seen
            if self._taken:
                mujoco.mj_setState(self._model, data, self._row.before, COMPLETE)
                gains = self._model.actuator_biasprm.copy()
                if self._built.servos:  # only then does this copy have its own model
                    self._model.actuator_biasprm[:] = self._row.gains
                self._take(data, self._taken)
                if self._built.servos:
                    self._model.actuator_biasprm[:] = gains
                self._work.mute()
            if rated is not None:
                mujoco.mj_setState(self._model, data, rated, COMPLETE)
                mujoco.mj_kinematics(self._model, data)
                mujoco.mj_comPos(self._model, data)
                mujoco.mj_comVel(self._model, data)
            if placed is not None:
                mujoco.mj_setState(self._model, data, placed, COMPLETE)
                mujoco.mj_kinematics(self._model, data)
            self._row.load(self._model, data)
            self._work.loaded = self._moment
            self._work.placed, self._work.rated = self._placed, self._rated
        return self._work.data

    def _loaded(self) -> Workspace:
        """Return a workspace with the current state."""
        work = self._work
        if self._row is not None and work.loaded is not self._moment:
            self._row.load(self._model, work.data)
            work.loaded = self._moment
        return work

    def _begin_row(self) -> None:
        """Write the initial state of the model, that of new data, into the row."""
        if self._row is not None:
            mujoco.mj_resetData(self._model, self._work.data)
            self._row.store(self._model, self._work.data)
            self._work.loaded = self._work.placed = self._work.rated = None
            self._work.mute()

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
        alone = [model for model in scene.models if settings_of(model)]
        for model in alone:
            for name, position in model.starts:
                self._do_put_joint(self._built.joints[model.name][name], position)
        if alone:
            scene = replace(scene, models=tuple(model for model in scene.models if model not in alone))
        super()._put_at_start(scene)

    def check_state(self, t_ns: int) -> None:
        positions, rates = self._positions, self._rates
        # sums of squares are faster than a check of each number
        if isfinite(positions.dot(positions)) and rates.dot(rates) < MOST_RATE**2:
            now = positions.take(self._limited)
            if not ((now < self._low) | (now > self._high)).any():
                return
        super().check_state(t_ns)
        if not abs(rates).max() < MOST_RATE:
            message = f"MuJoCo diverged: a body moves at {abs(rates).max():.4g} m/s (or rad/s)"
            raise DivergedError(message, t_ns=t_ns)

    def _do_reset(self, seed: int) -> None:
        if self._row is None:
            mujoco.mj_resetData(self._model, self._work.data)
        self._begin_row()
        self._taken, self._seen = 0, (None, None)
        self._control.release()
        self._put_at_start(self.scene)
        self._continue()

    def _do_frames(self, paths: Sequence[BodyPath]) -> ReadFrames:
        ids = np.array([self._built.bodies[model][index][1] for model, index in paths], int)

        def read(frames: FloatArray) -> None:
            data = self._refresh()
            frames[:, :, :3] = data.xmat[ids].reshape(-1, 3, 3)
            frames[:, :, 3] = data.xpos[ids]

        return read

    def model_pose(self, model: str) -> Pose:
        motion = self._motions[model]
        return motion.pose() if isinstance(motion, Floating) else motion().pose

    def position_places(
        self, models: Sequence[str], jointed: Sequence[str]
    ) -> tuple[FloatArray, IntArray] | None:
        bases, joints = [self._motions[name] for name in models], [self._joints[name] for name in jointed]
        poses = [base.places for base in bases if isinstance(base, Floating)]
        if len(poses) < len(bases) or any(one.has_balls for one in joints):
            return None
        return self._positions, np.concatenate([np.empty(0, int), *poses, *(one.indices for one in joints)])

    def read_motion(self, model: str, row: FloatArray) -> None:
        motion = self._motions[model]
        if isinstance(motion, Floating):
            motion.read(row)
        else:
            super().read_motion(model, row)

    @classmethod
    def read_motions(cls, engines: Sequence[MujocoEngine], model: str, rows: FloatArray) -> None:
        motion = engines[0]._motions[model]
        if not (isinstance(motion, Floating) and _are_alike(engines)):
            super().read_motions(engines, model, rows)
            return
        positions, velocities = motion.places, motion.rates
        rows[:, :7] = _stacked([engine._positions for engine in engines])[:, positions]
        rows[:, 7:] = _stacked([engine._rates for engine in engines])[:, velocities]
        x, y, z, w = rows[:, 3:7].T
        rows[:, 10:] = np.array(rotate_vector(x, y, z, w, tuple(rows[:, 10:].T))).T

    @classmethod
    def read_joints_of(cls, engines: Sequence[MujocoEngine], model: str, rows: FloatArray) -> None:
        reader = engines[0]._joints[model]
        if reader.has_balls or engines[0]._built.firm or not _are_alike(engines):
            super().read_joints_of(engines, model, rows)
            return
        positions, dofs = reader.places
        rows[:, 0] = _stacked([engine._positions for engine in engines])[:, positions]
        rows[:, 1] = _stacked([engine._rates for engine in engines])[:, dofs]
        if rows.shape[1] == 2:
            return  # without efforts
        efforts = _stacked([engine._state.qfrc_actuator for engine in engines])[:, dofs]
        rows[:, 2] = efforts + _stacked([engine._state.qfrc_applied for engine in engines])[:, dofs]

    def set_control(self, model: str, actuator: str, value: float) -> None:
        self._state.ctrl[self._model.actuator_ctrladr[self._built.actuators[model, actuator]]] = value

    def set_controls(self, model: str, actuators: Sequence[str], values: FloatArray) -> None:
        self._state.ctrl[self._group(model, actuators).controls] = values

    def _do_actuator_states(self, model: str, actuators: Sequence[str]) -> FloatArray:
        present, group = self._work.present, self._group(model, actuators)
        return present.states(self._model, self._complete(), group)

    def _group(self, model: str, actuators: Sequence[str]) -> ActuatorGroup:
        path = model, tuple(actuators)
        if path not in self._groups:
            numbers = [self._built.actuators[model, name] for name in actuators]
            self._groups[path] = ActuatorGroup(self._model, numbers)
        return self._groups[path]

    def _do_sensor_values(self, model: str, sensor: str) -> FloatArray:
        number = self._built.sensors[model, sensor]
        return self._work.present.sensor(self._model, self._complete(), number)

    def _complete(self) -> FloatArray:
        """Return the complete state, which is valid until the next step."""
        if self._row is not None:
            return self._row.numbers
        state = np.empty(mujoco.mj_stateSize(self._model, COMPLETE))
        mujoco.mj_getState(self._model, self._state, state, COMPLETE)
        return state

    def _do_put_joint(self, place: int, position: float) -> None:
        self._positions[self._model.jnt_qposadr[self._model.dof_jntid[place]]] = position
        self._rates[place] = 0.0

    def _do_put_ball(self, place: int, orientation: Quaternion) -> None:
        start = self._model.jnt_qposadr[self._model.dof_jntid[place]]
        self._positions[start : start + 4] = scalar_first(orientation)
        self._rates[place : place + 3] = 0.0

    def _do_configuration(self, model: str) -> object:
        positions, velocities = self._places(model)
        return self._positions[positions].copy(), self._rates[velocities].copy()

    def _do_configure(self, model: str, configuration: Any) -> None:
        positions, velocities = self._places(model)
        self._positions[positions], self._rates[velocities] = configuration
        self._continue(model)

    def _places(self, model: str) -> tuple[IntArray, IntArray]:
        """Return the parts of the state that belong to a model."""
        positions, velocities = self._joints[model].places
        roots = [self._model.body_jntadr[i] for body, i in self._built.bodies[model] if body.floats]
        free = [np.arange(7) + self._model.jnt_qposadr[joint] for joint in roots]
        moving = [np.arange(6) + self._model.jnt_dofadr[joint] for joint in roots]
        return np.concatenate([positions, *free]), np.concatenate([velocities, *moving])

    def _do_save(self) -> object:
        efforts = self._state.qfrc_actuator.tobytes()
        return self._complete().tobytes(), efforts, self._control.firm.save()

    def _do_restore(self, saved: Any) -> None:
        state, efforts, firm = saved
        if self._row is None:
            mujoco.mj_setState(self._model, self._state, np.frombuffer(state), COMPLETE)
        else:
            self._row.numbers[:] = np.frombuffer(state)
        self._state.qfrc_actuator[:] = np.frombuffer(efforts)
        self._taken, self._seen = 0, (None, None)
        self._continue()
        self._control.restore(firm)

    def _moved(self, model: str) -> None:
        self._control.firm.forget(model)
        self._continue(model)

    def _continue(self, model: str | None = None) -> None:
        super()._continue(model)
        self._creep.forget()
        self._moment = object()
        self._work.mute()

    def _refresh(self) -> Any:
        """Return MuJoCo's data with the positions of bodies, which are one step behind after a step."""
        work = self._loaded()
        if work.placed is not self._moment:
            mujoco.mj_kinematics(self._model, work.data)
            work.placed = self._moment
        if self._row is not None and self._placed is not self._moment:
            self._seen = self._row.numbers.copy(), self._seen[1]
        self._placed = self._moment
        return work.data

    def _refresh_rates(self) -> Any:
        """Return MuJoCo's data with the positions and the velocities of bodies."""
        data, work = self._refresh(), self._work
        if work.rated is not self._moment:
            mujoco.mj_comPos(self._model, data)
            mujoco.mj_comVel(self._model, data)
            work.rated = self._moment
        if self._rated is not self._moment:
            self._seen = self._seen[0], self._seen[0]
        self._rated = self._moment
        return data

    def _report_warnings(self, work: Workspace) -> None:
        """Report the warnings of the last steps, and restart their counts."""
        counts = work.warned.tolist()
        work.mute()
        kinds = mujoco.mjtWarning
        bad = (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC)
        if any(counts[kind] > 1 for kind in bad):
            t_ns = self.now_ns
            raise DivergedError(
                f"MuJoCo diverged after {seconds(t_ns):g} s: a position, velocity or acceleration is huge or "
                f"not finite; a shorter timestep or smaller commands may help",
                t_ns=t_ns,
            )
        for kind, count in enumerate(counts):
            if count > 1:
                self.warnings.add(Code.NRP277, f"MuJoCo: {mujoco.mju_warningText(kind, 0)}")
        while SAID:
            self.warnings.add(Code.NRP277, f"MuJoCo: {SAID.popitem()[0]}")


def _are_alike(engines: Sequence[MujocoEngine]) -> bool:
    """Return whether engines have the same scene and options, so that their states have the same layout."""
    scene, identity = engines[0].scene, engines[0].identity
    return all(engine.scene is scene and engine.identity == identity for engine in engines)


def _stacked(arrays: Sequence[FloatArray]) -> FloatArray:
    """Return arrays of one size as the rows of one; faster than ``np.stack``."""
    return np.concatenate(arrays).reshape(len(arrays), -1)


def _restless(engines: Sequence[MujocoEngine]) -> list[int]:
    """Return the numbers of engines, which are alike, whose states need a complete check."""
    first = engines[0]
    positions = _stacked([engine._positions for engine in engines])
    rates = _stacked([engine._rates for engine in engines])
    calm = np.isfinite(np.square(positions).sum(1)) & (np.square(rates).sum(1) < MOST_RATE**2)
    now = positions.take(first._limited, 1)
    calm &= ((now >= first._low) & (now <= first._high)).all(1)
    return np.flatnonzero(~calm).tolist()
