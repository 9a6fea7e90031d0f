"""A scene in PyBullet, at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

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
from nrp_core.world.physics.bodies import Body, body_of
from nrp_core.world.render.cameras import Cameras
from nrp_core.world.render.optics import optics_of
from nrp_core.world.scene.checks import WORLD
from nrp_core.world.scene.model import Inertial, Link, Model, Rgba, Scene
from nrp_core.world.scene.pose import Pose
from nrp_world_pybullet.backend import PybulletOptions
from nrp_world_pybullet.build import build
from nrp_world_pybullet.cameras import frame_reader, open_cameras
from nrp_world_pybullet.control import Control, joint_wrench
from nrp_world_pybullet.drive import Drive
from nrp_world_pybullet.engine import bullet
from nrp_world_pybullet.motion import JointReader, MotionOf, Moving, motion_of


class PybulletWorld(World):
    """A scene in PyBullet; see :class:`~nrp_world_pybullet.backend.PybulletBackend` for the options."""

    def __init__(
        self, scene: Scene, *, seed: int, capabilities: WorldCapabilities, options: PybulletOptions
    ) -> None:
        identity = f"pybullet {bullet.getAPIVersion()} {options.model_dump_json()}"
        super().__init__(scene, seed=seed, capabilities=capabilities, identity=identity)
        self._options = options
        self.image_scale = options.image_scale
        self._cameras: Cameras | None = None
        self._client = bullet.connect(bullet.DIRECT)
        try:
            self._do_load(scene)
        except BaseException:
            self.close()
            raise

    def _do_load(self, scene: Scene) -> None:
        self._build(scene)
        if self._cameras is not None:
            self._cameras.close()
        renderer, optics = self.capabilities.renderers[0], optics_of(scene, self.image_scale)
        self._cameras = open_cameras(renderer, self._built, self._client, optics)

    def _build(self, scene: Scene) -> None:
        """Build the engine anew; that alone leaves no trace of what was before."""
        client, step_s = self._client, seconds(self._options.timestep)
        visuals = self.capabilities.renderers[0] != "raster"
        self._built = build(
            scene,
            timestep_ns=self._options.timestep,
            client=client,
            visuals=visuals,
            physical=self._options.drive == "physical",
        )
        self._drives = {path: self._drive_of(path, step_s) for path in self._built.drives}
        self._joints = {name: JointReader(joints, client) for name, joints in self._built.joints.items()}
        self._control = Control(self._built, scene, client, step_s)
        # of these not even the base moves, by which divergence would be noticed
        self._anchored = [self._joints[model.name] for model in scene.models if _is_anchored(model)]
        self._motions = {model.name: self._motion_of(model, model.links[0], None) for model in scene.models}
        self._links: dict[tuple[str, str], MotionOf] = {}
        self._efforts: dict[str, FloatArray] = {}

    def _drive_of(self, path: tuple[str, str], step_s: float) -> Drive:
        servo = self._built.drives[path]
        body, place = self._built.bodies[path[0]][servo.body]
        joints = self._built.joints[path[0]]
        wheels = [joints[wheel.joint] for wheel in servo.wheels]
        return Drive(self._client, servo, body, place.multibody, wheels, step_s, self.scene.gravity)

    def _motion_of(self, model: Model, link: Link, held: Pose | None) -> MotionOf:
        """Return what reads the motion of a link, or of the model's frame, which the base's body holds."""
        bodies = self._built.bodies[model.name]
        body, place = bodies[body_of([body for body, _ in bodies], link.name)]
        return motion_of(body, place, body.in_model.inverse() if held is None else held, self._client)

    def _do_advance(self, steps: int) -> None:
        self._efforts = {}
        drives, client, step = tuple(self._drives.values()), self._client, bullet.stepSimulation
        control = self._control if self._control.active else None
        for _ in range(steps):
            for drive in drives:
                drive.push()
            if control is not None:
                control.push()
            step(client)
        for joints in self._anchored:
            if not joints.finite():
                raise DivergedError("PyBullet diverged: a joint's position is not finite", t_ns=self._at_ns)

    def _do_reset(self, seed: int) -> None:
        self._build(self.scene)

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
        return frame_reader(self._built, self._client, paths)

    def _do_joint_states(self, model: str) -> JointStates:
        states = self._joints[model].states()
        if model in self._efforts:
            return replace(states, efforts=self._efforts[model])
        for (owner, joint), effort in self._control.applied.items():
            if owner == model:
                states.efforts[states.names.index(joint)] += effort
        return states

    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        self._drives[model, drive].aim(velocity)

    def _do_set_color(self, visual: str, rgba: Rgba) -> None:
        assert self._cameras is not None
        self._cameras.set_color(visual, rgba)

    def _do_depth(self, model: str, link: str, camera: str) -> DepthArray:
        assert self._cameras is not None
        return self._cameras.depth((model, link, camera))

    def _do_touches(self) -> Sequence[Touch]:
        return list(self._control.touches())

    def _do_joint_wrench(self, model: str, joint: str) -> Wrench:
        bodies = self._built.bodies[model]
        return joint_wrench(
            *next(pair for pair in bodies if pair[0].joint is not None and pair[0].joint.name == joint),
            self._client,
        )

    def _do_set_joint_aim(self, model: str, joint: str, aim: JointAim) -> None:
        self._control.aim(model, joint, aim)

    def _do_set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        self._control.set_effort(model, joint, effort)

    def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        self._control.set_wrench(body, wrench)

    def _do_place(self, model: str, motion: ModelMotion) -> None:
        to_model = self._do_model_motion(model).pose.inverse()
        for body, place in self._built.bodies[model]:
            if body.floats:
                base = Moving(place, _inertial(body).pose.inverse(), self._client)
                base.put(motion.at(to_model @ base().pose))
        self._moved(model)

    def _do_set_joints(self, model: str, positions: Mapping[str, float]) -> None:
        for name, position in positions.items():
            place = self._built.joints[model][name]
            bullet.resetJointState(place.multibody, place.link, position, 0.0, self._client)
        self._moved(model)

    def _do_configuration(self, model: str) -> object:
        client = self._client
        roots = [place.multibody for body, place in self._built.bodies[model] if body.floats]
        bases = [
            (*bullet.getBasePositionAndOrientation(root, client), *bullet.getBaseVelocity(root, client))
            for root in roots
        ]
        joints = [
            bullet.getJointState(place.multibody, place.link, client)[:2]
            for place in self._built.joints[model].values()
        ]
        return bases, joints

    def _do_configure(self, model: str, configuration: Any) -> None:
        client = self._client
        bases, joints = configuration
        roots = [place.multibody for body, place in self._built.bodies[model] if body.floats]
        for root, (position, orientation, linear, angular) in zip(roots, bases, strict=True):
            bullet.resetBasePositionAndOrientation(root, position, orientation, client)
            bullet.resetBaseVelocity(root, linear, angular, client)
        places = self._built.joints[model].values()
        for place, (position, velocity) in zip(places, joints, strict=True):
            bullet.resetJointState(place.multibody, place.link, position, velocity, client)
        self._moved(model)

    def _moved(self, model: str) -> None:
        """Go on from where a model was put."""
        self._control.forget(model)
        self._continue({})

    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        assert self._cameras is not None
        return self._cameras.picture((model, link, camera))

    def _do_save(self) -> object:
        efforts = {name: self._do_joint_states(name).efforts for name in self._joints}
        with TemporaryDirectory() as folder:
            file = Path(folder) / "state.bullet"
            bullet.saveBullet(str(file), physicsClientId=self._client)
            return file.read_bytes(), efforts, self._control.save()

    def _do_restore(self, saved: Any) -> None:
        state, efforts, control = saved
        self._build(self.scene)
        with TemporaryDirectory() as folder:
            file = Path(folder) / "state.bullet"
            file.write_bytes(state)
            bullet.restoreState(fileName=str(file), physicsClientId=self._client)
        self._control.restore(control)
        self._continue(efforts)

    def _do_close(self) -> None:
        if self._cameras is not None:
            self._cameras.close()
        bullet.disconnect(self._client)

    def _continue(self, efforts: dict[str, FloatArray]) -> None:
        """Start from another state than the one reached by steps; PyBullet keeps no efforts with a state."""
        self._efforts = efforts
        for drive in self._drives.values():
            drive.forget()


def _is_anchored(model: Model) -> bool:
    return not model.static and any(joint.parent == WORLD for joint in model.joints)


def _inertial(body: Body) -> Inertial:
    assert body.inertial is not None  # what moves has mass
    return body.inertial
