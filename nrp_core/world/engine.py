"""What a backend of a world writes: a physics engine with a scene in it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isfinite
from typing import TYPE_CHECKING, Any, final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import CapabilityError, DivergedError
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.part import Part
from nrp_core.world.raycast.beams import Beams
from nrp_core.world.render.cameras import REALISTIC, SHARED, Cameras, DepthArray, ImageArray
from nrp_core.world.render.eyes import Eyes
from nrp_core.world.render.optics import CameraPath, Optics, optics_of
from nrp_core.world.rigid.matrices import rotation_matrix
from nrp_core.world.rigid.motion import (
    BodyPath,
    BodyVelocity,
    JointAim,
    JointStates,
    ModelMotion,
    ReadFrames,
    Touch,
    Wrench,
)
from nrp_core.world.scene.merged_bodies import Body, bodies_of, body_of, lever_of
from nrp_core.world.scene.model import Light, Model, Rgba, Scene

if TYPE_CHECKING:
    from nrp_core.world.raycast.collisions import CollisionSpace


class Engine(ABC):
    """A physics engine with a scene in it; it knows nothing of topics.

    The world steps it, changes its scene and asks it; so do the parts of the world. A backend writes the
    ``_do_*`` methods, of which four are abstract. Units are m, rad and ns, axes those of the world.

    Args:
        scene: the first scene. Each model has its ``source``, the file and element that it was read from,
            and ``native`` elements of that file, which are meant for one engine.
        capabilities: of the backend, under these options.
        seed: of the world.
        identity: text that names engine, version and options; snapshots of others do not fit.

    Attributes:
        scene: the scene as it is now.
        capabilities: of the backend.
        seed: of the world; set by the world, as is ``now_ns``.
        now_ns: the time before the step that is being taken, else the time reached.
        image_scale: width and height of images are those of the robot's file times this.
        warnings: for the user; the world shows them.

    Raises:
        CapabilityError: something in the scene would move in a way that the engine does not have.
    """

    def __init__(self, scene: Scene, capabilities: WorldCapabilities, *, seed: int, identity: str) -> None:
        self.scene = scene
        self.capabilities = capabilities
        self.seed = seed
        self.now_ns = 0
        self.identity = identity
        self.image_scale = 1.0
        self.warnings: list[str] = list(scene.warnings)
        self._require_movable(scene)
        self._bodies: dict[str, tuple[Body, ...]] = {}
        self._pulls: dict[BodyPath, dict[tuple[str, str], FloatArray]] = {}
        self._space: CollisionSpace | None = None
        self._eyes = Eyes(self._open_renderer, "".join(self.capabilities.renderers[:1]))

    @property
    def step_ns(self) -> int:
        """The physics step."""
        return self.capabilities.step_ns

    # -- time

    @final
    def advance(self, steps: int, *, paused: bool = False) -> None:
        """Take physics steps; while the world is paused time passes, but nothing moves."""
        if paused:
            self._do_wait(steps)
        else:
            self._do_advance(steps)
        self.now_ns += steps * self.capabilities.step_ns

    @final
    def reset(self, seed: int) -> None:
        """Return to the state right after opening, with the scene of now."""
        self.seed = seed
        self._do_reset(seed)

    @final
    def save(self) -> object:
        """Return the complete state as something that pickles.

        Raises:
            CapabilityError: the engine cannot do that.
        """
        if not self.capabilities.snapshot:
            raise self.lacks("cannot save and restore its state")
        return self._do_save()

    @final
    def restore(self, saved: Any) -> None:
        """Return to what :meth:`save` gave, in the same scene."""
        if not self.capabilities.snapshot:
            raise self.lacks("cannot save and restore its state")
        self._do_restore(saved)

    def check_finite(self, t_ns: int) -> None:
        """Refuse a state that is not finite; an engine may look in a quicker way first.

        Raises:
            DivergedError: the position of a model is not finite.
        """
        for model in self.scene.models if self.capabilities.poses else ():
            position = None if model.static else self._do_model_motion(model.name).pose.position
            if position is not None and not all(map(isfinite, position)):
                message = f"model '{model.name}' has a position that is not finite"
                raise DivergedError(message, t_ns=t_ns)

    @final
    def close(self) -> None:
        """Release the engine and its cameras."""
        self._eyes.close()
        self._do_close()

    # -- what sensors read

    @final
    def model_motion(self, model: str) -> ModelMotion:
        """Return where a model's frame is and how it moves."""
        return self._do_model_motion(model)

    @final
    def link_motion(self, model: str, link: str) -> ModelMotion:
        """Return where a link is and how it moves."""
        return self._do_link_motion(model, link)

    @final
    def joint_states(self, model: str) -> JointStates:
        """Return the state of a model's joints."""
        return self._do_joint_states(model)

    def read_motion(self, model: str, row: FloatArray) -> None:
        """Write where a model is and how it moves; an engine may do so without :class:`ModelMotion`.

        Args:
            model: the model.
            row: gets position, orientation (x, y, z, w), linear and angular velocity, shape ``(13,)``.
        """
        motion = self._do_model_motion(model)
        row[:] = (*motion.pose.position, *motion.pose.orientation, *motion.linear, *motion.angular)

    def read_joints(self, model: str, rows: FloatArray) -> None:
        """Write positions, velocities and efforts of joints, shape ``(3, n)``."""
        states = self._do_joint_states(model)
        rows[:] = states.positions, states.velocities, states.efforts

    @final
    def render(self, model: str, link: str, camera: str) -> ImageArray:
        """Return what a camera sees, shape ``(height, width, 3)``, RGB, read-only."""
        image = self._do_render(model, link, camera)
        image.flags.writeable = False
        return image

    @final
    def image_size(self, model: str, link: str, camera: str) -> tuple[int, int]:
        """Return height and width of a camera's images."""
        sensors = self.scene.model(model).link(link).sensors
        view = next(sensor.view for sensor in sensors if sensor.view is not None and sensor.name == camera)
        optics = Optics.of(view, self.image_scale)
        return optics.height, optics.width

    @final
    def depth(self, model: str, link: str, camera: str) -> DepthArray:
        """Return the depth that a camera sees, m, ``inf`` beyond its clip distance."""
        image = self._do_depth(model, link, camera)
        image.flags.writeable = False
        return image

    @final
    def scan(self, model: str, link: str, beams: Beams) -> FloatArray:
        """Return the distance along each ray, layer by layer, m, ``inf`` where it meets nothing."""
        return self._collisions().scan(model, link, beams)

    @final
    def touches(self) -> Sequence[tuple[Touch, tuple[str, str]]]:
        """Return where things touched, with the names of both collisions, ``model/link/collision``."""
        if not (found := self._do_touches()):
            return ()
        name_at = self._collisions().name_at
        return [
            (each, (name_at(each.bodies[0], each.position), name_at(each.bodies[1], each.position)))
            for each in found
        ]

    @final
    def joint_wrench(self, model: str, joint: str) -> Wrench:
        """Return what a joint's child does to its parent, at the child link's origin."""
        return self._do_joint_wrench(model, joint)

    # -- what drives, controllers and services command

    @final
    def set_color(self, visual: str, rgba: Rgba) -> None:
        """Colour a visual (``model/link/visual``)."""
        self._eyes.colors[visual] = rgba
        self._do_set_color(visual, rgba)

    @final
    def set_glow(self, visual: str, glows: bool) -> None:
        """Say whether a visual has its colour in any light."""
        self._eyes.glows[visual] = glows
        self._do_set_glow(visual, glows)

    @final
    def set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        """Aim a drive at a velocity of the body."""
        self._do_set_drive(model, drive, velocity)

    @final
    def set_joint_aim(self, model: str, joint: str, aim: JointAim) -> None:
        """Aim a joint's servo from now on; only joints with a controller have one."""
        self._do_set_joint_aim(model, joint, aim)

    @final
    def set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        """Put an effort (N m, N) on a joint from now on, besides what its servo does."""
        self._do_set_joint_effort(model, joint, effort)

    @final
    def set_wrench(self, model: str, link: str, wrench: Wrench, of: str = "") -> bool:
        """Set the wrench that acts at a link's centre of mass from now on, besides those of others.

        Args:
            model: the model.
            link: its link.
            wrench: replaces the one before.
            of: who pushes.

        Returns:
            Whether its lever turns with the body, so that it is to be set again in each step.
        """
        bodies = self._bodies_of(model)
        index = body_of(bodies, link)
        if bodies[index].inertial is None:
            return False  # what is fixed cannot be pushed
        part, lever = lever_of(bodies[index], link)
        turn = rotation_matrix((self.link_motion(model, link).pose @ part.pose.inverse()).orientation)
        pulls = self._pulls.setdefault((model, index), {})
        pulls[link, of] = np.array([wrench.force, np.cross(turn @ lever, wrench.force) + wrench.torque])
        (fx, fy, fz), (tx, ty, tz) = np.sum([pulls[name] for name in sorted(pulls)], axis=0).tolist()
        self._do_set_wrench((model, index), Wrench((fx, fy, fz), (tx, ty, tz)))
        return bool(np.any(lever) and np.any(wrench.force))

    # -- changes of the scene

    @final
    def load(self, scene: Scene) -> None:
        """Load another scene, at the state in which its files have it; where only lights differ, set them.

        Raises:
            CapabilityError: something in it would move in a way that the engine does not have.
        """
        if replace(self.scene, lights=scene.lights) == scene:
            self.set_lights(scene.lights)
            return
        self._require_movable(scene)
        self._do_load(scene)
        self.scene = scene
        self._bodies, self._pulls = {}, {}
        self._space = None
        self._eyes.close()
        self._eyes = Eyes(self._open_renderer, "".join(self.capabilities.renderers[:1]))

    @final
    def set_lights(self, lights: tuple[Light, ...]) -> None:
        """Set the lights of the scene; realistic images show them, flat ones do not."""
        self.scene = replace(self.scene, lights=lights)
        self._do_set_lights(lights)

    @final
    def floats(self, model: str) -> bool:
        """Whether the base of a model can go anywhere."""
        bodies = self._bodies_of(model)
        return bodies[body_of(bodies, self.scene.model(model).links[0].name)].floats

    @final
    def place(self, model: str, motion: ModelMotion) -> None:
        """Put a model whose base floats somewhere; its joints stay as they are."""
        self._do_place(model, motion)

    @final
    def set_joints(self, model: str, positions: Mapping[str, float]) -> None:
        """Put joints at positions, at rest."""
        self._do_set_joints(model, positions)

    @final
    def configuration(self, model: str) -> object:
        """Return where a model and its joints are and how they move."""
        return self._do_configuration(model)

    @final
    def configure(self, model: str, configuration: object) -> None:
        """Return a model to what :meth:`configuration` gave."""
        self._do_configure(model, configuration)

    @final
    def lacks(self, what: str) -> CapabilityError:
        """Return the error of an engine that cannot do something."""
        return CapabilityError(f"{type(self).__name__} {what}")

    def parts(self, usual: Sequence[Part], model: Model | None) -> Sequence[Part]:
        """Return the parts of a model, or of the world itself (None).

        An engine whose messages come from outside, as from ROS or a recording, puts parts of its own in
        the place of those that the core would use.

        Args:
            usual: the parts of the core.
            model: that they belong to.
        """
        return usual

    # -- checks

    def _require_movable(self, scene: Scene) -> None:
        if lacking := self.capabilities.lacking_for(scene):
            raise self.lacks(lacking)

    # -- what follows from the scene alone

    def _bodies_of(self, model: str) -> tuple[Body, ...]:
        if model not in self._bodies:
            self._bodies[model] = bodies_of(self.scene.model(model))
        return self._bodies[model]

    def _collisions(self) -> CollisionSpace:
        from nrp_core.world.raycast.collisions import CollisionSpace  # compiled code takes time to load

        if self._space is None:
            bodies = {model.name: self._bodies_of(model.name) for model in self.scene.models}
            self._space = CollisionSpace(bodies, self._do_frames)
        return self._space

    @property
    def _optics(self) -> Mapping[CameraPath, Optics]:
        return optics_of(self.scene, self.image_scale)

    def _open_renderer(self, renderer: str) -> Cameras:
        """Open a renderer of the core, or one of the engine."""
        if not renderer:
            raise self.lacks("has no cameras")
        if renderer not in SHARED:
            return self._do_open_cameras(renderer)
        from nrp_core.world.render.raster import RasterCameras  # compiled code takes time to load
        from nrp_core.world.render.realistic import RealisticCameras

        bodies = {model.name: self._bodies_of(model.name) for model in self.scene.models}
        if renderer == REALISTIC:
            return RealisticCameras(bodies, self._optics, self._do_frames, self.scene.lights)
        return RasterCameras(bodies, self._optics, self._do_frames)

    # -- for backends: the fewest operations that cannot be derived

    @abstractmethod
    def _do_advance(self, steps: int) -> None:
        """Take ``steps`` physics steps."""

    @abstractmethod
    def _do_reset(self, seed: int) -> None:
        """Return to the state right after opening; bit for bit where determinism is declared."""

    def _do_wait(self, steps: int) -> None:
        """Let the time of steps pass while the world is paused; sensors outside may go on."""

    @abstractmethod
    def _do_model_motion(self, model: str) -> ModelMotion:
        """Return where a model's frame is and how it moves, in the frame of the world."""

    @abstractmethod
    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        """Aim a drive at a velocity of the body from now on."""

    def _do_set_color(self, visual: str, rgba: Rgba) -> None:
        """Colour a visual, named by its path ``model/link/visual``, from the next image on."""
        for cameras in self._eyes.opened:
            cameras.set_color(visual, rgba)

    def _do_set_glow(self, visual: str, glows: bool) -> None:
        """Say whether a visual has its colour in any light, from the next image on."""
        for cameras in self._eyes.opened:
            cameras.set_glow(visual, glows)

    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        """Return what a camera sees now, shape ``(height, width, 3)``, RGB, a fresh array."""
        return self._eyes.images.picture((model, link, camera))

    def _do_depth(self, model: str, link: str, camera: str) -> DepthArray:
        """Return the depth that a camera sees now, m, shape ``(height, width)``, a fresh array."""
        return self._eyes.depths.depth((model, link, camera))

    def _do_open_cameras(self, renderer: str) -> Cameras:
        """Open one of the renderers that the engine has beside the core's."""
        raise self.lacks(f"has no renderer '{renderer}'")

    def _do_set_lights(self, lights: Sequence[Light]) -> None:
        """Set the lights, from the next image on."""
        for cameras in self._eyes.opened:
            cameras.set_lights(lights)

    def _do_joint_states(self, model: str) -> JointStates:
        """Return the state of the movable joints of a model, in the order of its file."""
        raise self.lacks("does not report joints")

    def _do_link_motion(self, model: str, link: str) -> ModelMotion:
        """Return where a link is and how it moves, in the frame of the world."""
        if not self.capabilities.dynamics:  # joints stay as the files have them
            return self._do_model_motion(model).at(self.scene.model(model).link(link).pose)
        bodies = self._bodies_of(model)
        body = bodies[body_of(bodies, link)]
        first = self.scene.model(model).links[0].name
        if all(each.name != first for each in body.links):
            raise self.lacks(
                f"does not report the poses of links that move relative to the base ({model}/{link})"
            )
        held = {each.name: each.pose for each in body.links}
        base = self.scene.model(model).links[0].pose
        return self._do_model_motion(model).at(base @ held[first].inverse() @ held[link])

    def _do_frames(self, paths: Sequence[BodyPath]) -> ReadFrames:
        """Return what writes where these bodies are; called once."""
        links = [(model, self._bodies_of(model)[index].links[0]) for model, index in paths]

        def read(frames: FloatArray) -> None:
            for frame, (model, link) in zip(frames, links, strict=True):
                pose = self._do_link_motion(model, link.name).pose @ link.pose.inverse()
                frame[:, :3], frame[:, 3] = rotation_matrix(pose.orientation), pose.position

        return read

    def _do_touches(self) -> Sequence[Touch]:
        """Return all contacts of the last physics step, those within a model left out."""
        raise self.lacks("does not report contacts")

    def _do_joint_wrench(self, model: str, joint: str) -> Wrench:
        """Return what a joint's child did to its parent in the last step, at the child link's origin."""
        raise self.lacks("does not report the forces in joints")

    def _do_set_joint_aim(self, model: str, joint: str, aim: JointAim) -> None:
        """Aim the servo of a joint that has a controller from now on."""
        raise self.lacks("does not control joints")

    def _do_set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        """Put an effort on a joint from now on, besides what its servo does."""
        raise self.lacks("does not control joints")

    def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        """Set the wrench that acts at a body's centre of mass from now on."""
        raise self.lacks("cannot apply forces")

    def _do_load(self, scene: Scene) -> None:
        """Load another scene, at the state in which its files have it."""
        raise self.lacks("cannot change its scene")

    def _do_place(self, model: str, motion: ModelMotion) -> None:
        """Put a model whose base floats somewhere and let it move; its joints stay as they are."""
        raise self.lacks("cannot move models")

    def _do_set_joints(self, model: str, positions: Mapping[str, float]) -> None:
        """Put joints at positions, at rest."""
        raise self.lacks("cannot move joints")

    def _do_configuration(self, model: str) -> object:
        """Return where a model and its joints are and how they move."""
        raise self.lacks("cannot move models")

    def _do_configure(self, model: str, configuration: object) -> None:
        """Return a model to what :meth:`_do_configuration` gave."""
        raise self.lacks("cannot move models")

    def _do_save(self) -> object:
        """Return the complete state as something that pickles."""
        raise self.lacks("cannot save and restore its state")

    def _do_restore(self, saved: Any) -> None:
        """Return to what :meth:`_do_save` gave."""
        raise self.lacks("cannot save and restore its state")

    def _do_close(self) -> None:
        """Release the engine; by default there is nothing to release."""
