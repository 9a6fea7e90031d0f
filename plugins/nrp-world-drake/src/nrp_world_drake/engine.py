"""A scene in Drake."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np

from nrp_core.clock import seconds
from nrp_core.errors import DivergedError
from nrp_core.scene.merged_bodies import Body, place_in_frame
from nrp_core.scene.rigid import (
    BodyPath,
    JointStates,
    JointTargets,
    ModelMotion,
    Pose,
    Quaternion,
    ReadFrames,
    Touch,
    Wrench,
    matrix_of,
)
from nrp_core.world import FloatArray, JointedEngine, PhysicsOptions, Scene, WorldCapabilities
from nrp_world_drake.build import Built, JointHandle, build
from nrp_world_drake.control import Control
from nrp_world_drake.drive import Drive
from nrp_world_drake.motion import Base, JointReader, Running, angles_of, motion_of
from nrp_world_drake.muscles import Muscles


class DrakeEngine(JointedEngine):
    """A scene in Drake; see :class:`~nrp_core.world.PhysicsOptions`."""

    _built: Built
    _drives: dict[tuple[str, str], Drive]
    _joints: dict[str, JointReader]
    _control: Control

    def __init__(
        self, scene: Scene, *, seed: int, capabilities: WorldCapabilities, options: PhysicsOptions
    ) -> None:
        name = f"drake {version('drake')}"
        super().__init__(scene, seed=seed, capabilities=capabilities, options=options, name=name)
        self._do_load(scene)
        self._warm_up()

    def _do_load(self, scene: Scene) -> None:
        options, step_s = self._options, seconds(self._options.timestep)
        self._built = build(scene, timestep_ns=options.timestep, physical=options.drive == "physical")
        self.warnings += self._built.warnings
        self._running = Running(self._built, options.timestep)
        self._drives = {
            path: Drive(
                self._running,
                servo,
                Base(self._running, self._built.bodies[path[0]][servo.body][1]),
                self._built.spins[path],
                step_s,
                scene.gravity,
            )
            for path, servo in self._built.drives.items()
        }
        self._joints = {
            name: JointReader(self._running, joints) for name, joints in self._built.joints.items()
        }
        self._control = Control(self._built, self._running, scene, self._joints, step_s)
        self._muscles = Muscles(scene, self._built, self._running, self._control.firm, step_s, self.warnings)
        self._restored: tuple[dict[str, FloatArray], list[Touch], dict[tuple[str, str], Wrench]] | None = None
        self._survey(scene)

    # -- steps

    def _do_advance(self, steps: int) -> None:
        control = self._control
        self._restored = None
        control.begin()
        pushes: list[Callable[[], None]] = [drive.push for drive in self._drives.values() if drive.pushes]
        if control.firm.active:
            pushes.append(control.firm.step)
        if control.decaying:
            pushes.append(control.pull)
        if self._muscles:
            pushes.append(self._muscles.push)  # which lets Drake read the inputs
        elif pushes:
            pushes.append(self._running.touch)
        try:
            self._step(steps, pushes)
        except RuntimeError as error:
            reason = str(error).splitlines()[0]
            raise DivergedError(f"Drake diverged: {reason}", t_ns=self.now_ns) from error

    def _step(self, steps: int, pushes: Sequence[Callable[[], None]]) -> None:
        """Take physics steps, each after some functions that set its forces."""
        if not pushes:
            self._running.step(steps)
            return
        for _ in range(steps):
            for push in pushes:
                push()
            self._running.step()

    def _do_reset(self, seed: int) -> None:
        self._running.put(self._built.start)
        self._control.release()
        self._muscles.release()
        self._running.forces[:] = 0.0
        self._running.touch()
        for drive in self._drives.values():
            drive.forget()
        self._restored = None
        self._put_at_start(self.scene)
        self._continue()

    # -- motions

    def _do_motion_of(self, body: Body, place: Any, offset: Pose) -> Callable[[], ModelMotion]:
        return motion_of(self._running, body, place, offset)

    def _do_base(self, body: Body, place: Any) -> Base:
        return Base(self._running, place)

    def _do_frames(self, paths: Sequence[BodyPath]) -> ReadFrames:
        plant, context = self._running.plant, self._running.context
        bodies = [self._built.bodies[model][index] for model, index in paths]
        fixed = [matrix_of(place_in_frame(body)) if body.fixed else None for body, _ in bodies]

        def read(frames: FloatArray) -> None:
            for frame, still, (_, place) in zip(frames, fixed, bodies, strict=True):
                if still is None:
                    frame[:] = plant.EvalBodyPoseInWorld(context, place).GetAsMatrix34()
                else:
                    frame[:] = still

        return read

    def _do_joint_states(self, model: str) -> JointStates:
        states = super()._do_joint_states(model)
        if self._restored is not None:
            return replace(states, efforts=self._restored[0][model].copy())
        self._control.add_efforts(model, states)
        if self._muscles:
            states.efforts[:] += self._joints[model].efforts(self._muscles.efforts())
        return states

    def _do_touches(self) -> Sequence[Touch]:
        return super()._do_touches() if self._restored is None else self._restored[1]

    def _do_joint_wrench(self, model: str, joint: str) -> Wrench:
        if self._restored is None:
            return super()._do_joint_wrench(model, joint)
        return self._restored[2][model, joint]

    def set_control(self, model: str, actuator: str, value: float) -> None:
        self._muscles.set_controls(model, (actuator,), np.array([value]))

    def set_controls(self, model: str, actuators: Sequence[str], values: FloatArray) -> None:
        self._muscles.set_controls(model, actuators, values)

    def _do_actuator_states(self, model: str, actuators: Sequence[str]) -> FloatArray:
        return self._muscles.states(model, actuators)

    def retarget(self, model: str, targets: JointTargets) -> bool:
        return self._control.firm.retarget(model, targets)

    # -- changes

    def _do_put_joint(self, place: JointHandle, position: float) -> None:
        self._running.change(place.position, (position,))
        self._running.change(self._running.velocities_start + place.velocity, (0.0,))

    def _do_put_ball(self, place: JointHandle, orientation: Quaternion) -> None:
        self._running.change(place.position, angles_of(orientation))
        self._running.change(self._running.velocities_start + place.velocity, (0.0, 0.0, 0.0))

    def _do_configuration(self, model: str) -> object:
        return self._running.state[self._places(model)].copy()

    def _do_configure(self, model: str, configuration: Any) -> None:
        state = self._running.state.copy()
        state[self._places(model)] = configuration
        self._running.change(0, state)
        self._moved(model)

    def _places(self, model: str) -> list[int]:
        """Return the places of a model in the state."""
        places, after = list[int](), self._running.velocities_start
        for body, place in self._built.bodies[model]:
            if body.floats:
                first, speeds = place.floating_positions_start(), place.floating_velocities_start_in_v()
                places += [*range(first, first + 7), *range(after + speeds, after + speeds + 6)]
        for handle in self._built.joints[model].values():
            axis = handle.axis or 0
            places += [handle.position + axis, after + handle.velocity + axis]
        return places

    def _moved(self, model: str) -> None:
        self._control.firm.forget(model)
        self._continue(model)

    # -- snapshots

    def _do_save(self) -> object:
        efforts = {name: self._do_joint_states(name).efforts for name in self._joints}
        wrenches = {
            (model.name, joint): self._do_joint_wrench(model.name, joint)
            for model in self.scene.models
            for link in model.links
            for sensor in link.sensors
            for joint in sensor.measured_joints
        }
        state = self._running.state.copy()
        return (
            state,
            self._running.forces.copy(),
            self._control.firm.save(),
            self._muscles.save(),
            (efforts, list(self._do_touches()), wrenches),
        )

    def _do_restore(self, saved: Any) -> None:
        state, forces, firm, muscles, measured = saved
        self._running.put(state)
        self._running.forces[:] = forces
        self._control.firm.restore(firm)
        self._muscles.restore(muscles)
        self._running.touch()
        self._restored = measured
        self._continue()
