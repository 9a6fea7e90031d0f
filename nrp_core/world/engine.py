"""What the parts of a scene ask of physics, in terms of the fewest operations that a backend writes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.errors import CapabilityError
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.raycast.beams import Beams
from nrp_core.world.render.cameras import RASTER, REALISTIC, SHARED, Cameras, DepthArray, ImageArray
from nrp_core.world.render.optics import CameraPath, Optics, optics_of
from nrp_core.world.rigid.matrices import rotation_matrix
from nrp_core.world.rigid.motion import (
    BodyPath,
    BodyVelocity,
    JointAim,
    JointStates,
    ModelMotion,
    Touch,
    Wrench,
)
from nrp_core.world.scene.merged_bodies import Body, bodies_of, body_of
from nrp_core.world.scene.model import Light, Rgba, Scene

if TYPE_CHECKING:
    from nrp_core.world.raycast.collisions import CollisionSpace
    from nrp_core.world.render.raster import RasterCameras

ReadFrames = Callable[[FloatArray], None]
"""Writes rotation and translation to the world of some bodies, shape ``(n, 3, 4)``."""


class Engine(ABC):
    """What the parts ask of a physics engine."""

    scene: Scene

    @property
    @abstractmethod
    def seed(self) -> int:
        """The world's seed."""

    @property
    @abstractmethod
    def step_ns(self) -> int:
        """The physics step."""

    @abstractmethod
    def picture_size(self, model: str, link: str, camera: str) -> tuple[int, int]:
        """Return height and width of a camera's pictures."""

    @abstractmethod
    def model_motion(self, model: str) -> ModelMotion:
        """Return where a model's frame is and how it moves."""

    @abstractmethod
    def link_motion(self, model: str, link: str) -> ModelMotion:
        """Return where a link is and how it moves."""

    @abstractmethod
    def joint_states(self, model: str) -> JointStates:
        """Return the state of the movable joints of a model."""

    @abstractmethod
    def render(self, model: str, link: str, camera: str) -> ImageArray:
        """Return what a camera sees, shape ``(height, width, 3)``, RGB, read-only."""

    @abstractmethod
    def depth(self, model: str, link: str, camera: str) -> DepthArray:
        """Return how far along its line of sight a camera sees, m, ``inf`` beyond its clip distance."""

    @abstractmethod
    def scan(self, model: str, link: str, beams: Beams) -> FloatArray:
        """Return the distance along each ray, layer by layer, m, ``inf`` where it meets nothing."""

    @abstractmethod
    def touches(self) -> Sequence[tuple[Touch, tuple[str, str]]]:
        """Return where things touched, with the names of both collisions, ``model/link/collision``."""

    @abstractmethod
    def joint_wrench(self, model: str, joint: str) -> Wrench:
        """Return what a joint's child does to its parent, at the child link's origin."""

    @abstractmethod
    def set_color(self, visual: str, rgba: Rgba) -> None:
        """Colour a visual (``model/link/visual``)."""

    @abstractmethod
    def set_glow(self, visual: str, glows: bool) -> None:
        """Let a visual have its colour in any light, or not."""

    @abstractmethod
    def set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        """Let a drive aim at a velocity of the body."""

    @abstractmethod
    def set_joint_aim(self, model: str, joint: str, aim: JointAim) -> None:
        """Let a joint's servo aim at something from now on; only joints with a controller have one."""

    @abstractmethod
    def set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        """Put an effort (N m, N) on a joint from now on, besides what its servo does."""

    @abstractmethod
    def set_wrench(self, model: str, link: str, wrench: Wrench, of: str = "") -> bool:
        """Let a wrench act at a link's centre of mass from now on, besides those of others.

        Args:
            model: the model.
            link: its link.
            wrench: instead of the one before.
            of: who pushes.

        Returns:
            Whether its lever turns with the body, so that it is to be set again in each step.
        """


class PhysicsEngine(Engine):
    """A physics engine with a scene in it.

    Args:
        scene: what is in it now.
        capabilities: what the engine has.

    Attributes:
        image_scale: by how much pictures are smaller than the files of robots have them.
    """

    def __init__(self, scene: Scene, capabilities: WorldCapabilities) -> None:
        self.scene = scene
        self.capabilities = capabilities
        self.image_scale = 1.0
        self._bodies: dict[str, tuple[Body, ...]] = {}
        self._pulls: dict[BodyPath, dict[tuple[str, str], FloatArray]] = {}
        self._space: CollisionSpace | None = None
        self._cameras: Cameras | None = None
        self._depths: Cameras | None = None
        self._colors: dict[str, Rgba] = {}
        self._glows: dict[str, bool] = {}

    @property
    def step_ns(self) -> int:
        """The physics step."""
        return self.capabilities.step_ns

    @final
    def model_motion(self, model: str) -> ModelMotion:
        return self._do_model_motion(model)

    @final
    def link_motion(self, model: str, link: str) -> ModelMotion:
        return self._do_link_motion(model, link)

    @final
    def joint_states(self, model: str) -> JointStates:
        return self._do_joint_states(model)

    @final
    def render(self, model: str, link: str, camera: str) -> ImageArray:
        picture = self._do_render(model, link, camera)
        picture.flags.writeable = False
        return picture

    @final
    def picture_size(self, model: str, link: str, camera: str) -> tuple[int, int]:
        sensors = self.scene.model(model).link(link).sensors
        view = next(sensor.view for sensor in sensors if sensor.view is not None and sensor.name == camera)
        optics = Optics.of(view, self.image_scale)
        return optics.height, optics.width

    @final
    def depth(self, model: str, link: str, camera: str) -> DepthArray:
        picture = self._do_depth(model, link, camera)
        picture.flags.writeable = False
        return picture

    @final
    def scan(self, model: str, link: str, beams: Beams) -> FloatArray:
        return self._collisions().scan(model, link, beams)

    @final
    def touches(self) -> Sequence[tuple[Touch, tuple[str, str]]]:
        if not (found := self._do_touches()):
            return ()
        space = self._collisions()
        return [
            (
                touch,
                (
                    space.name_at(touch.bodies[0], touch.position),
                    space.name_at(touch.bodies[1], touch.position),
                ),
            )
            for touch in found
        ]

    @final
    def joint_wrench(self, model: str, joint: str) -> Wrench:
        return self._do_joint_wrench(model, joint)

    @final
    def set_color(self, visual: str, rgba: Rgba) -> None:
        self._colors[visual] = rgba
        self._do_set_color(visual, rgba)

    @final
    def set_glow(self, visual: str, glows: bool) -> None:
        self._glows[visual] = glows
        self._do_set_glow(visual, glows)

    @final
    def set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        self._do_set_drive(model, drive, velocity)

    @final
    def set_joint_aim(self, model: str, joint: str, aim: JointAim) -> None:
        self._do_set_joint_aim(model, joint, aim)

    @final
    def set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        self._do_set_joint_effort(model, joint, effort)

    @final
    def set_wrench(self, model: str, link: str, wrench: Wrench, of: str = "") -> bool:
        """Move the wrench to the centre of mass of the body that the link is part of; add up that body's."""
        bodies = self._bodies_of(model)
        index = body_of(bodies, link)
        body = bodies[index]
        part = next(each for each in body.links if each.name == link)
        if body.inertial is None:
            return False  # what is fixed cannot be pushed
        inertial = part.inertial
        centre = (part.pose @ inertial.pose if inertial else part.pose).position
        lever = np.subtract(centre, body.inertial.pose.position)
        turn = rotation_matrix((self.link_motion(model, link).pose @ part.pose.inverse()).orientation)
        pulls = self._pulls.setdefault((model, index), {})
        pulls[link, of] = np.array([wrench.force, np.cross(turn @ lever, wrench.force) + wrench.torque])
        (fx, fy, fz), (tx, ty, tz) = np.sum([pulls[name] for name in sorted(pulls)], axis=0).tolist()
        self._do_set_wrench((model, index), Wrench((fx, fy, fz), (tx, ty, tz)))
        return bool(np.any(lever) and np.any(wrench.force))

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

    def _pictures(self) -> Cameras:
        """Return the cameras, drawn by the preferred renderer."""
        if self._cameras is None:
            if not self.capabilities.renderers:
                raise self._lacks("has no cameras")
            renderer = self.capabilities.renderers[0]
            shared = renderer in SHARED
            cameras = self._shared_cameras(renderer) if shared else self._do_open_cameras(renderer)
            self._cameras = self._painted(cameras)
        return self._cameras

    def _depth_pictures(self) -> Cameras:
        """Return what draws depth: the same for every renderer, for it does not depend on light or colour."""
        if self._depths is None:
            drawn = self._pictures()
            self._depths = drawn if drawn.draws_depth else self._painted(self._shared_cameras(RASTER))
        return self._depths

    def _shared_cameras(self, renderer: str) -> RasterCameras:
        """Open a renderer of the core's own."""
        from nrp_core.world.render.raster import RasterCameras  # compiled code takes time to load
        from nrp_core.world.render.realistic import RealisticCameras

        bodies = {model.name: self._bodies_of(model.name) for model in self.scene.models}
        if renderer == REALISTIC:
            return RealisticCameras(bodies, self._optics, self._do_frames, self.scene.lights)
        return RasterCameras(bodies, self._optics, self._do_frames)

    def _painted(self, cameras: Cameras) -> Cameras:
        """Give cameras that were just opened the colours of now."""
        for visual, rgba in self._colors.items():
            cameras.set_color(visual, rgba)
        for visual, glows in self._glows.items():
            cameras.set_glow(visual, glows)
        return cameras

    def _opened_cameras(self) -> Iterator[Cameras]:
        return (cameras for cameras in (self._cameras, self._depths) if cameras is not None)

    def _close_cameras(self) -> None:
        for cameras in self._opened_cameras():
            cameras.close()
        self._cameras = self._depths = None

    def _forget_scene(self) -> None:
        """Forget what followed from the scene, because it has changed."""
        self._bodies, self._pulls = {}, {}
        self._space = None
        self._colors, self._glows = {}, {}
        self._close_cameras()

    def _lacks(self, what: str) -> CapabilityError:
        return CapabilityError(f"{type(self).__name__} {what}")

    # -- for backends: the fewest operations that cannot be derived

    @abstractmethod
    def _do_advance(self, steps: int) -> None:
        """Take ``steps`` physics steps."""

    @abstractmethod
    def _do_reset(self, seed: int) -> None:
        """Return to the state right after opening; bit for bit where determinism is declared."""

    @abstractmethod
    def _do_model_motion(self, model: str) -> ModelMotion:
        """Return where a model's frame is and how it moves, in the frame of the world."""

    @abstractmethod
    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        """Let a drive aim at a velocity of the body from now on."""

    def _do_set_color(self, visual: str, rgba: Rgba) -> None:
        """Colour a visual, named by its path ``model/link/visual``, from the next picture on."""
        for cameras in self._opened_cameras():
            cameras.set_color(visual, rgba)

    def _do_set_glow(self, visual: str, glows: bool) -> None:
        """Let a visual have its colour in any light, or not, from the next picture on."""
        for cameras in self._opened_cameras():
            cameras.set_glow(visual, glows)

    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        """Return what a camera sees now, shape ``(height, width, 3)``, RGB, a fresh array."""
        return self._pictures().picture((model, link, camera))

    def _do_depth(self, model: str, link: str, camera: str) -> DepthArray:
        """Return the depth that a camera sees now, m, shape ``(height, width)``, a fresh array."""
        return self._depth_pictures().depth((model, link, camera))

    def _do_open_cameras(self, renderer: str) -> Cameras:
        """Open one of the renderers that the engine has beside the core's."""
        raise self._lacks(f"has no renderer '{renderer}'")

    def _do_set_lights(self, lights: Sequence[Light]) -> None:
        """Let these be the lights, from the next picture on."""
        for cameras in self._opened_cameras():
            cameras.set_lights(lights)

    def _do_joint_states(self, model: str) -> JointStates:
        """Return the state of the movable joints of a model, in the order of its file."""
        raise self._lacks("does not show joints")

    def _do_link_motion(self, model: str, link: str) -> ModelMotion:
        """Return where a link is and how it moves, in the frame of the world."""
        if not self.capabilities.dynamics:  # joints stay as the files have them
            return self._do_model_motion(model).at(self.scene.model(model).link(link).pose)
        bodies = self._bodies_of(model)
        body = bodies[body_of(bodies, link)]
        first = self.scene.model(model).links[0].name
        if all(each.name != first for each in body.links):
            raise self._lacks(f"does not tell where links are that move against the base ({model}/{link})")
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
        raise self._lacks("does not tell of contacts")

    def _do_joint_wrench(self, model: str, joint: str) -> Wrench:
        """Return what a joint's child did to its parent in the last step, at the child link's origin."""
        raise self._lacks("does not tell the forces in joints")

    def _do_set_joint_aim(self, model: str, joint: str, aim: JointAim) -> None:
        """Let the servo of a joint that has a controller aim at something from now on."""
        raise self._lacks("does not control joints")

    def _do_set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        """Put an effort on a joint from now on, besides what its servo does."""
        raise self._lacks("does not control joints")

    def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        """Let a wrench act at a body's centre of mass from now on."""
        raise self._lacks("takes no forces")

    def _do_load(self, scene: Scene) -> None:
        """Load another scene, at the state in which its files have it."""
        raise self._lacks("cannot change its scene")

    def _do_place(self, model: str, motion: ModelMotion) -> None:
        """Put a model whose base floats somewhere and let it move; its joints stay as they are."""
        raise self._lacks("cannot move models")

    def _do_set_joints(self, model: str, positions: Mapping[str, float]) -> None:
        """Put joints at positions, at rest."""
        raise self._lacks("cannot move joints")

    def _do_configuration(self, model: str) -> object:
        """Return where a model and its joints are and how they move."""
        raise self._lacks("cannot move models")

    def _do_configure(self, model: str, configuration: object) -> None:
        """Return a model to what :meth:`_do_configuration` gave."""
        raise self._lacks("cannot move models")

    def _do_save(self) -> object:
        """Return the complete state as something that pickles."""
        raise NotImplementedError

    def _do_restore(self, saved: object) -> None:
        """Return to what :meth:`_do_save` gave."""
        raise NotImplementedError
