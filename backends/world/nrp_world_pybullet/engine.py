"""A scene in PyBullet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.clock import seconds
from nrp_core.errors import DivergedError
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.model import Scene
from nrp_core.scene.rigid import BodyPath, JointStates, JointTargets, Pose, Quaternion, ReadFrames, Vector
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.engine_kit.jointed import JointedEngine, MotionOf, PhysicsOptions
from nrp_world_pybullet.build import BodyHandle, Built, build
from nrp_world_pybullet.control import Control
from nrp_world_pybullet.drive import Drive
from nrp_world_pybullet.library import bullet
from nrp_world_pybullet.mechanisms import report_mechanisms
from nrp_world_pybullet.motion import JointReader, Moving, moving, place_of
from nrp_world_pybullet.muscles import Muscles


class PybulletEngine(JointedEngine):
    """A scene in PyBullet; see :class:`~nrp_core.world.engine_kit.jointed.PhysicsOptions`."""

    _built: Built
    _drives: dict[tuple[str, str], Drive]
    _joints: dict[str, JointReader]
    _control: Control

    def __init__(
        self, scene: Scene, *, seed: int, capabilities: WorldCapabilities, options: PhysicsOptions
    ) -> None:
        name = f"pybullet {bullet.getAPIVersion()}"
        super().__init__(scene, seed=seed, capabilities=capabilities, options=options, name=name)
        self._client = bullet.connect(bullet.DIRECT)
        try:
            self._do_load(scene)
            self._warm_up()
        except BaseException:
            self.close()
            raise

    def _do_load(self, scene: Scene) -> None:
        """Rebuild the engine; only this removes all traces of earlier steps."""
        client, options, step_s = self._client, self._options, seconds(self._options.timestep)
        physical = options.drive == "physical"
        self._built = build(scene, timestep_ns=options.timestep, client=client, physical=physical)
        self.warnings += self._built.warnings
        self._drives = {path: self._drive_of(path, step_s, scene.gravity) for path in self._built.drives}
        wheels = {
            (model, wheel.joint) for (model, _), servo in self._built.drives.items() for wheel in servo.wheels
        }
        self._joints = {
            name: JointReader(joints, {joint for joint in joints if (name, joint) in wheels}, client)
            for name, joints in self._built.joints.items()
        }
        self._muscles = Muscles(scene, self._built, client, step_s)
        self._muscled = bool(self._muscles)
        self._control = Control(self._built, scene, self._joints, self._muscles, client, step_s)
        for model in scene.models:
            report_mechanisms(model, self._control.exact_joints(model.name), self.warnings)
        self._efforts: dict[str, FloatArray] = {}
        self._survey(scene)
        self._bases = [motion for motion in self._motions.values() if isinstance(motion, Moving)]

    def _do_motion_of(self, body: Body, place: BodyHandle, offset: Pose) -> MotionOf:
        return moving(body, place, offset, self._client)

    def _do_base(self, body: Body, place: BodyHandle) -> Moving:
        return moving(body, place, Pose(), self._client)

    def _drive_of(self, path: tuple[str, str], step_s: float, gravity: Vector) -> Drive:
        servo = self._built.drives[path]
        body, place = self._built.bodies[path[0]][servo.body]
        joints = self._built.joints[path[0]]
        wheels = [joints[wheel.joint] for wheel in servo.wheels]
        return Drive(self._client, servo, body, place.multibody, wheels, step_s, gravity)

    def _do_advance(self, steps: int) -> None:
        self._efforts = {}
        client, step = self._client, bullet.stepSimulation
        pushes = [*[drive.push for drive in self._drives.values()], *self._control.pushes()]
        if self._muscled:
            pushes.append(self._muscles.push)
            if self._drives:  # they set velocities
                self._muscles.forget()
        for _ in range(steps):
            for push in pushes:
                push()
            step(client)
        self._forget_motions()

    def _forget_motions(self) -> None:
        if self._muscled:
            self._muscles.forget()
        for name in self._bounds:  # those with joints
            self._joints[name].forget()

    def check_state(self, t_ns: int) -> None:
        for base in self._bases:
            if not base.is_possible():  # faster than a check of each motion
                super().check_state(t_ns)
        for name, bounds in self._bounds.items():
            if not self._joints[name].are_within(bounds):
                bounds.require(self._joints[name].states(), t_ns)
        if self._muscled and not self._muscles.is_finite():
            raise DivergedError("PyBullet diverged: the state of a muscle is not finite", t_ns=t_ns)

    def _do_reset(self, seed: int) -> None:
        self._do_load(self.scene)

    def _do_frames(self, paths: Sequence[BodyPath]) -> ReadFrames:
        bodies, client = self._built.bodies, self._client
        places = [place_of(*bodies[model][index], Pose(), client) for model, index in paths]

        def read(frames: FloatArray) -> None:
            for frame, place in zip(frames, places, strict=True):
                position, orientation = place()
                frame[:, :3] = np.reshape(bullet.getMatrixFromQuaternion(orientation), (3, 3))
                frame[:, 3] = position

        return read

    def retarget(self, model: str, targets: JointTargets) -> bool:
        return self._control.retarget(model, targets)

    def joint_positions(self, model: str) -> FloatArray:
        return self._joints[model].positions()

    def _do_joint_states(self, model: str) -> JointStates:
        states = super()._do_joint_states(model)
        if model in self._efforts:
            return replace(states, efforts=self._efforts[model])
        self._control.add_efforts(model, states)
        self._muscles.add_efforts(model, states)
        return states

    def set_control(self, model: str, actuator: str, value: float) -> None:
        self._muscles.set_control(model, actuator, value)

    def set_controls(self, model: str, actuators: Sequence[str], values: FloatArray) -> None:
        self._muscles.set_controls(model, actuators, values)

    def _do_actuator_states(self, model: str, actuators: Sequence[str]) -> FloatArray:
        return self._muscles.states(model, actuators)

    def _do_put_joint(self, place: BodyHandle, position: float) -> None:
        bullet.resetJointState(place.multibody, place.link, position, 0.0, self._client)

    def _do_put_ball(self, place: BodyHandle, orientation: Quaternion) -> None:
        still = [0.0, 0.0, 0.0]
        bullet.resetJointStateMultiDof(place.multibody, place.link, orientation, still, self._client)

    def _do_configuration(self, model: str) -> object:
        client = self._client
        roots = [place.multibody for body, place in self._built.bodies[model] if body.floats]
        bases = [
            (*bullet.getBasePositionAndOrientation(root, client), *bullet.getBaseVelocity(root, client))
            for root in roots
        ]
        joints = [
            bullet.getJointStateMultiDof(place.multibody, place.link, client)[:2]
            for place in self._jointed(model)
        ]
        return bases, joints

    def _do_configure(self, model: str, configuration: Any) -> None:
        client = self._client
        bases, joints = configuration
        roots = [place.multibody for body, place in self._built.bodies[model] if body.floats]
        for root, (position, orientation, linear, angular) in zip(roots, bases, strict=True):
            bullet.resetBasePositionAndOrientation(root, position, orientation, client)
            bullet.resetBaseVelocity(root, linear, angular, client)
        for place, (position, velocity) in zip(self._jointed(model), joints, strict=True):
            bullet.resetJointStateMultiDof(place.multibody, place.link, position, velocity, client)
        self._moved(model)

    def _jointed(self, model: str) -> list[BodyHandle]:
        """Return the handles of the movable joints of a model."""
        return [place for place in self._built.joints[model].values() if not place.axis]

    def _moved(self, model: str) -> None:
        self._control.forget(model)
        self._efforts = {}
        self._forget_motions()
        self._continue(model)

    def _do_save(self) -> object:
        efforts = {name: self._do_joint_states(name).efforts for name in self._joints}
        with TemporaryDirectory() as folder:
            file = Path(folder) / "state.bullet"
            bullet.saveBullet(str(file), physicsClientId=self._client)
            return file.read_bytes(), efforts, self._control.save(), self._muscles.save()

    def _do_restore(self, saved: Any) -> None:
        state, efforts, control, muscles = saved
        self._do_load(self.scene)
        with TemporaryDirectory() as folder:
            file = Path(folder) / "state.bullet"
            file.write_bytes(state)
            bullet.restoreState(fileName=str(file), physicsClientId=self._client)
        self._forget_motions()
        self._control.restore(control)
        self._muscles.restore(muscles)
        self._efforts = efforts  # PyBullet does not save them with a state
        self._continue()

    def _do_close(self) -> None:
        bullet.disconnect(self._client)
