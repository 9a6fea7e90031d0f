"""Forces that drives do not exert, and measurements: servos, efforts, wrenches, contacts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from nrp_core.findings.refusals import refusal
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.rigid import BodyPath, JointStates, Pose, Quaternion, ServoTarget, Touch, Vector, Wrench
from nrp_core.world import FloatArray, Scene
from nrp_core.world.engine_kit.firm_joints import FirmJoint, FirmJoints
from nrp_core.world.engine_kit.firm_kinds import FREE
from nrp_core.world.engine_kit.simulated import Decay
from nrp_world_drake.build import HOLDING, Built, JointPath, Motor
from nrp_world_drake.contacts import touches_in
from nrp_world_drake.motion import Frame, JointReader, Running, motion_of

Pull = tuple[Vector, Vector, Vector]
"""A point of a body in its frame, a force and a torque in the world."""


class DrakeFirmJoints(FirmJoints):
    """The firm joints of a scene: motors that hold a velocity, and are constraints with a bounded force.

    Args:
        built: the scene.
        running: its plant.
        step_s: the physics step.
    """

    def __init__(self, built: Built, running: Running, step_s: float) -> None:
        firm: Mapping[JointPath, tuple[FirmJoint, Motor]] = built.firm
        super().__init__({path: joint for path, (joint, _) in firm.items()}, step_s)
        self._running, self._rubbing = running, built.rubbing
        self._motors = [motor for _, motor in firm.values()]
        self._numbers_of = np.array([motor.number for motor in self._motors], dtype=int)
        handles = [built.joints[model][joint] for model, joint in firm]
        self._joints = [handle.joint for handle in handles]
        self._positions = np.array([handle.position for handle in handles], dtype=int)
        self._velocities = (
            np.array([handle.velocity for handle in handles], dtype=int) + running.velocities_start
        )
        self._last = np.zeros(len(firm))
        self._read = True

    def _do_step(self, steps: int) -> None:
        state, servos = self._running.state, self.servos
        positions = state.take(self._positions)
        if servos.moving:
            servos.step(positions, state.take(self._velocities))
        wanted = servos.velocities(positions)
        self._running.desired[1, self._numbers_of[self.on]] = wanted[self.on]
        self._read = False

    def restore(self, saved: Any) -> None:
        super().restore(saved)
        for number in range(len(self.paths)):
            self._engage(number)

    def leads(self, path: JointPath) -> bool:
        """Return whether a joint has a target."""
        return path in self._numbers and bool(self.servos.kinds[self._numbers[path]] != FREE)

    def release(self) -> None:
        """Remove all targets, as at the start."""
        for path in self.paths:
            self.set_target(path, ServoTarget())
        self._last[:], self._read = 0.0, True

    def _do_efforts(self) -> FloatArray:
        if not self._read:
            efforts = self._running.actuation()[self._numbers_of]
            self._last, self._read = np.where(self.servos.kinds == FREE, 0.0, efforts), True
        return self._last

    def _do_select(self, number: int) -> None:
        self._do_efforts()[number] = 0.0
        self._engage(number)

    def _engage(self, number: int) -> None:
        """Let the motor of a joint hold it, or release it to its friction and its damper."""
        led = self.servos.kinds[number] != FREE
        self._motors[number].set_gains(0.0, HOLDING if led else 0.0)
        joint = self._joints[number]
        joint.SetDamping(self._running.context, 0.0 if led else joint.default_damping())
        if self.paths[number] in self._rubbing:
            self._rubbing[self.paths[number]].set_gains(0.0, 0.0 if led else HOLDING)


class Control:
    """Forces in one scene.

    Args:
        built: the scene.
        running: its plant.
        scene: the same as data.
        readers: the readers of the joints of each model.
        step_s: the physics step.

    Attributes:
        firm: the joints that follow with any load.
        decaying: whether velocities of bodies decay, so that :meth:`pull` is needed before each step.
    """

    def __init__(
        self,
        built: Built,
        running: Running,
        scene: Scene,
        readers: Mapping[str, JointReader],
        step_s: float,
    ) -> None:
        self._built, self._running, self._readers = built, running, readers
        self.firm = DrakeFirmJoints(built, running, step_s)
        self._aims: dict[JointPath, ServoTarget] = {}
        self._acting: dict[JointPath, ServoTarget] = {}
        self._efforts: dict[JointPath, float] = {}
        self._exerted: dict[JointPath, float] = {}
        self._wrenches: dict[BodyPath, Wrench] = {}
        self._lifts = dict(self._lifts_of(scene.gravity))
        self._decays = []
        for model, bodies in built.bodies.items():
            for index, (body, place) in enumerate(bodies):
                if (decay := Decay.of(body, step_s)) is not None and body.inertial is not None:
                    motion = motion_of(running, body, place, body.inertial.pose)
                    self._decays.append(((model, index), decay, motion))
        self.decaying = bool(self._decays)
        if self._lifts:
            self.pull()

    def _lifts_of(self, gravity: Vector) -> Iterator[tuple[BodyPath, Pull]]:
        """Yield the forces that hold the bodies, or parts of them, that gravity does not pull."""
        for model, bodies in self._built.bodies.items():
            for index, (body, _) in enumerate(bodies):
                if body.inertial is not None and (lifted := body.weightless):
                    x, y, z = (-lifted.mass * part for part in gravity)
                    yield (model, index), (lifted.pose.position, (x, y, z), (0.0, 0.0, 0.0))

    # -- commands

    def set_target(self, model: str, joint: str, aim: ServoTarget) -> None:
        """Set the target of a joint's servo."""
        path = model, joint
        if path in self._built.firm:
            if self.firm.set_target(path, aim):
                return
            if aim.firm is not None:
                aim = ServoTarget()
        motor, before = self._built.servos[path], self._aims.get(path, ServoTarget())
        if (aim.stiffness, aim.damping) != (before.stiffness, before.damping):
            motor.set_gains(aim.stiffness, aim.damping)
        self._aims[path] = aim
        position, velocity = aim.position, aim.velocity
        if (
            aim.stiffness
        ):  # the effort is a part of the target, because Drake adds no inputs of several motors
            position += aim.effort / aim.stiffness
        elif aim.damping:
            velocity += aim.effort / aim.damping
        self._running.desired[:, motor.number] = position, velocity
        self._push(path)

    def orient(self, model: str, joint: str, orientation: Quaternion | None) -> None:
        """Refuse to lead a ball joint: Drake has no motors in them."""
        raise refusal(self, "cannot lead ball joints to orientations")

    def set_effort(self, model: str, joint: str, effort: float) -> None:
        """Apply an effort to a joint."""
        self._efforts[model, joint] = effort
        self._push((model, joint))

    def _push(self, path: JointPath) -> None:
        """Set the effort on a joint, with that of a servo that has no gains."""
        handle, aim, effort = (
            self._built.joints[path[0]][path[1]],
            self._aims.get(path),
            self._efforts.get(path, 0.0),
        )
        if aim is not None and not (aim.stiffness or aim.damping):
            limit = self._limit(*path)
            effort += min(max(aim.effort, -limit), limit)
        self._running.forces[handle.velocity + (handle.axis or 0)] = effort
        self._running.touch()

    def set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        """Apply a wrench to a body."""
        self._wrenches[body] = wrench
        if wrench == Wrench():
            del self._wrenches[body]
        self.pull()

    def pull(self) -> None:
        """Apply the wrenches on bodies in the next step."""
        pulls: list[tuple[BodyPath, Pull]] = list(self._lifts.items())
        for path, wrench in self._wrenches.items():
            pulls.append((path, (self._centre(path), wrench.force, wrench.torque)))
        for path, decay, motion in self._decays:
            now = motion()
            wrench = decay.wrench(now.pose, now.linear, now.angular)
            pulls.append((path, (self._centre(path), wrench.force, wrench.torque)))
        self._running.pull([(self._built.bodies[model][n][1], pull) for (model, n), pull in pulls])

    def _centre(self, path: BodyPath) -> Vector:
        """Return the centre of mass of a body in its frame."""
        inertial = self._built.bodies[path[0]][path[1]][0].inertial
        assert inertial is not None
        return inertial.pose.position

    def begin(self) -> None:
        """Note what acts in the next steps, which report it afterwards."""
        self._acting, self._exerted = dict(self._aims), dict(self._efforts)

    def release(self) -> None:
        """Remove all targets, efforts and wrenches, as at the start."""
        self.firm.release()
        for model, joint in list(self._aims):
            self.set_target(model, joint, ServoTarget())
        for model, joint in list(self._efforts):
            self.set_effort(model, joint, 0.0)
        self._efforts.clear()
        self._wrenches.clear()
        self.begin()
        self.pull()

    # -- measurements

    def add_efforts(self, model: str, states: JointStates) -> None:
        """Add the efforts of the last step to the states of a model's joints."""
        self.firm.add_efforts(model, states)
        numbers = {name: number for number, name in enumerate(states.names)}
        for (owner, joint), aim in self._acting.items():
            if owner == model:
                number, limit = numbers[joint], self._limit(owner, joint)
                off, slip = aim.position - states.positions[number], aim.velocity - states.velocities[number]
                effort = aim.stiffness * off + aim.damping * slip + aim.effort
                states.efforts[number] += min(max(effort, -limit), limit)
        for (owner, joint), effort in self._exerted.items():
            if owner == model:
                states.efforts[numbers[joint]] += effort
        for (owner, drive), servo in self._built.drives.items():
            for wheel, motor in zip(servo.wheels, self._built.spins[owner, drive], strict=True):
                if owner == model:
                    number = numbers[wheel.joint]
                    slip = self._running.desired[1, motor.number] - states.velocities[number]
                    states.efforts[number] += min(max(wheel.gain * slip, -wheel.limit), wheel.limit)

    def _limit(self, model: str, joint: str) -> float:
        return float(self._built.servos[model, joint].actuator.effort_limit())

    def touches(self) -> Iterator[Touch]:
        """Return the contacts of the last step."""
        return touches_in(self._running.contacts(), self._built.owners, self._built.fields)

    def joint_wrench(self, body: Body, place: Any) -> Wrench:
        """Return the wrench of a body on its parent in the last step, at the body's origin."""
        assert body.joint is not None
        reaction = self._running.reaction(self._built.placed[place.index()])
        (fx, fy, fz), (tx, ty, tz) = reaction.translational().tolist(), reaction.rotational().tolist()
        turn = Frame(self._running, place, Pose())().pose
        return Wrench(turn.rotate((-fx, -fy, -fz)), turn.rotate((-tx, -ty, -tz)))
