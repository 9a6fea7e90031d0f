"""A scene in Gazebo."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np

from nrp_core.clock import seconds
from nrp_core.errors import DivergedError
from nrp_core.scene.merged_bodies import Body, tree_of
from nrp_core.scene.rigid import ReadFrames, rotation_matrix
from nrp_core.world import (
    BodyPath,
    BodyVelocity,
    FloatArray,
    JointedEngine,
    ModelMotion,
    Pose,
    Quaternion,
    Scene,
    WorldCapabilities,
)
from nrp_core.world.engine_kit.jointed import MotionOf
from nrp_core.world.raycast.beams import Beams
from nrp_core.world.render.cameras import Cameras
from nrp_world_gazebo.build import BodyHandle, Built, Coordinate, build
from nrp_world_gazebo.cameras import GazeboCameras
from nrp_world_gazebo.control import Control
from nrp_world_gazebo.drive import Drive, PluginDrive
from nrp_world_gazebo.motion import Hinged, JointReader, Moving, Tree, motion_of, put, travel
from nrp_world_gazebo.options import GazeboOptions
from nrp_world_gazebo.scan import scan
from nrp_world_gazebo.wire import operation


class GazeboEngine(JointedEngine):
    """A scene in Gazebo; see :class:`~nrp_world_gazebo.options.GazeboOptions` for the options."""

    _built: Built
    _drives: dict[tuple[str, str], Drive | PluginDrive]
    _joints: dict[str, JointReader]
    _control: Control
    _options: GazeboOptions

    def __init__(
        self, scene: Scene, *, seed: int, capabilities: WorldCapabilities, options: GazeboOptions
    ) -> None:
        super().__init__(scene, seed=seed, capabilities=capabilities, options=options, name="gazebo 11")
        self._built = build(scene, options)
        try:
            self._connect(scene)
            self._warm_up()
        except BaseException:
            self.close()
            raise

    def _do_load(self, scene: Scene) -> None:
        built = build(scene, self._options)  # the present one stays if this fails
        self._built.gazebo.close()
        self._built = built
        self._connect(scene)

    def _connect(self, scene: Scene) -> None:
        built, step_s = self._built, seconds(self._options.timestep)
        self._gazebo = built.gazebo
        self.warnings += built.warnings
        self._start = bytes(self._gazebo.ask(operation("S")))
        self._drives = {path: self._drive_of(path, number) for number, path in enumerate(built.drives)}
        self._joints = {name: JointReader(self._gazebo, joints) for name, joints in built.joints.items()}
        self._control = Control(built, scene, step_s)
        self._survey(scene)

    def _drive_of(self, path: tuple[str, str], number: int) -> Drive | PluginDrive:
        if path in self._built.turns:
            return PluginDrive(self._gazebo, path[0], self._built.turns[path])
        servo, bodies = self._built.drives[path], self._built.bodies[path[0]]
        joints = self._built.joints[path[0]]
        wheels = [joints[wheel.joint] for wheel in servo.wheels]
        base = Tree(self._gazebo, bodies, servo.body)
        step_s = seconds(self._options.timestep)
        return Drive(self._gazebo, number, servo, base, bodies[servo.body][1], wheels, step_s)

    def _do_motion_of(self, body: Body, place: BodyHandle, offset: Pose) -> MotionOf:
        moving = Moving(self._gazebo, place.link, place.held @ offset)
        model, _ = self._built.owners[place.link]
        coordinate = self._built.joints[model].get(body.joint.name) if body.joint else None
        if coordinate is None or body.parent is None:
            return moving
        parent = self._motion_of_body(*self._built.bodies[model][body.parent])
        return Hinged(moving, parent, coordinate, body.pose, offset)

    def _do_base(self, body: Body, place: BodyHandle) -> Tree:
        model, index = self._built.owners[place.link]
        return Tree(self._gazebo, self._built.bodies[model], index)

    def _do_advance(self, steps: int) -> None:
        if self._control.active:
            for _ in range(steps):
                self._control.push()
                self._gazebo.step(1)
        else:
            self._gazebo.step(steps)

    def check_state(self, t_ns: int) -> None:
        super().check_state(t_ns)
        if not np.isfinite(self._gazebo.links).all():
            raise DivergedError("Gazebo diverged: a velocity is not finite", t_ns=t_ns)
        if not all(map(isfinite, self.scene.gravity)):  # Gazebo would have used its own
            raise DivergedError(f"gravity is not finite: {self.scene.gravity}", t_ns=t_ns)

    def _do_reset(self, seed: int) -> None:
        self._resume(self._start)
        for path in self._drives:
            self._do_set_drive(*path, BodyVelocity())
        self._put_at_start(self.scene)

    def _resume(self, state: bytes) -> None:
        """Continue from a saved state of Gazebo, without any loads."""
        self._gazebo.do(operation("r") + operation("R") + state)
        self._control = Control(self._built, self.scene, seconds(self._options.timestep))
        self._continue()

    def _do_frames(self, paths: Sequence[BodyPath]) -> ReadFrames:
        places = [self._built.bodies[model][index] for model, index in paths]
        read = [self._seen(body, place) for body, place in places]

        def write(frames: FloatArray) -> None:
            for frame, motion in zip(frames, read, strict=True):
                pose = motion().pose
                frame[:, :3], frame[:, 3] = rotation_matrix(pose.orientation), pose.position

        return write

    def _seen(self, body: Body, place: BodyHandle) -> MotionOf:
        """Return the reader of the motion of a body as ODE has it, which is fast and exact enough to see."""
        if body.fixed:
            return self._motion_of_body(body, place)
        return Moving(self._gazebo, place.link, place.held)

    def _motion_of_body(self, body: Body, place: BodyHandle) -> MotionOf:
        if body.fixed:
            still = ModelMotion(body.pose)
            return lambda: still
        return self._do_motion_of(body, place, Pose())

    def _do_put_joint(self, place: Coordinate, position: float) -> None:
        """Move all bodies below a joint, at rest relative to its parent."""
        own = self._built.bodies[place.model]
        body, handle = own[place.body]
        assert body.parent is not None
        parent = self._motion_of_body(*own[body.parent])()
        now = motion_of(self._gazebo.links[handle.link]).pose @ handle.held
        moved = parent.pose @ body.pose @ travel(place, position) @ now.inverse()
        for index in tree_of(place.body, [each for each, _ in own]):
            for link in own[index][1].links:
                pose = moved @ motion_of(self._gazebo.links[link]).pose
                put(self._gazebo, link, parent.at(parent.pose.inverse() @ pose))
        self._gazebo.do(operation("j", place.number, values=(position,)))

    def _do_put_ball(self, place: Coordinate, orientation: Quaternion) -> None:
        raise self.lacks("has no ball joints")

    def _do_configuration(self, model: str) -> object:
        self._gazebo.refresh()
        return self._gazebo.links[self._links_of(model)], self._gazebo.joints[self._joints_of(model), 0]

    def _do_configure(self, model: str, configuration: Any) -> None:
        motions, positions = configuration
        for link, row in zip(self._links_of(model), motions, strict=True):
            put(self._gazebo, link, motion_of(row))
        for joint, position in zip(self._joints_of(model), positions, strict=True):
            self._gazebo.do(operation("j", joint, values=(position,)))
        self._moved(model)

    def _links_of(self, model: str) -> list[int]:
        places = [place for body, place in self._built.bodies[model] if not body.fixed]
        return [link for place in places for link in place.links]

    def _joints_of(self, model: str) -> list[int]:
        return [coordinate.number for coordinate in self._built.joints[model].values()]

    def _moved(self, model: str) -> None:
        self._control.forget(model)
        self._continue(model)

    def _do_save(self) -> object:
        return bytes(self._gazebo.ask(operation("S"))), self._control.save()

    def _do_restore(self, saved: Any) -> None:
        state, control = saved
        self._resume(state)
        self._control.restore(control)

    def _do_scan(self, model: str, link: str, beams: Beams) -> FloatArray:
        if self._options.rays == "shared":
            return super()._do_scan(model, link, beams)
        return scan(self._built, model, link, beams)

    def _do_open_cameras(self, renderer: str) -> Cameras:
        return GazeboCameras(self._built, self.scene.models, self._optics)

    def _do_close(self) -> None:
        self._built.gazebo.close()
