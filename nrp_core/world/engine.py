"""An engine: a scene in a physics simulator, as a world backend implements it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import isfinite
from typing import TYPE_CHECKING, Any, ClassVar, Final, final

import numpy as np

from nrp_core._support.arrays import FloatArray, IntArray
from nrp_core.errors import DivergedError
from nrp_core.findings import Findings
from nrp_core.findings.refusals import MODEL_MOVES, SCENE_CHANGES, SNAPSHOTS
from nrp_core.scene.merged_bodies import Body, bodies_of, body_of
from nrp_core.scene.model import Light, Model, Rgba, Scene
from nrp_core.scene.rigid import (
    BodyPath,
    BodyVelocity,
    JointStates,
    LinkMotions,
    ModelMotion,
    Pose,
    ReadFrames,
    Touch,
    Wrench,
    rotation_matrix,
)
from nrp_core.simulation import Failures, note_failure
from nrp_core.world.capabilities import WorldCapabilities, check_scene
from nrp_core.world.external_wrenches import ExternalWrenches, Group, wrench_of
from nrp_core.world.joint_commands import JointCommands
from nrp_core.world.part import Part
from nrp_core.world.raycast.beams import Beams
from nrp_core.world.render.cameras import (
    RASTER,
    SHARED,
    CameraPath,
    Cameras,
    DepthArray,
    ImageArray,
    Optics,
    SegmentArray,
    Sight,
    optics_of,
)
from nrp_core.world.render.renderers import SceneRenderers, open_shared

if TYPE_CHECKING:
    from nrp_core.world.raycast.collisions import CollisionSpace


MOST_RATE: Final = 9.9e5
"""A rate, m/s or rad/s, that no body has: one that diverges in PyBullet stays at 1e6."""


class Engine(JointCommands):
    """A physics engine with a scene; it does not handle topics.

    The world and its parts step it, query it and change its scene. A backend implements the ``_do_*``
    methods, four of which are abstract. Units are m, rad and ns; axes are those of the world.

    Args:
        scene: the first scene. Each model has its ``source``, the file and element that it was read from, and
            ``native`` elements of that file, each for a specific engine.
        capabilities: the capabilities of the backend under these options.
        seed: the seed of the world.
        identity: text with engine, version and options; snapshots with another identity are refused.

    Attributes:
        scene: the present scene.
        capabilities: the capabilities of the backend.
        seed: the seed of the world; set by the world, as is ``now_ns``.
        now_ns: the time at the start of the current step, else the time reached, ns.
        image_scale: factor of the width and height that the robot's file gives for images.
        warnings: warnings for the user; the world reports them.
        copies: operations on all copies of a scene at once.

    Raises:
        CapabilityError: the scene needs a capability that the engine does not have.
    """

    stops_between_steps: ClassVar[bool] = True
    """Whether it can stop at any of its own steps; another process may only stop at those of the loop."""

    def __init__(self, scene: Scene, capabilities: WorldCapabilities, *, seed: int, identity: str) -> None:
        self.scene = scene
        self.capabilities = capabilities
        self.seed = seed
        self.now_ns = 0
        self.identity = identity
        self.image_scale = 1.0
        self.warnings = Findings(scene.warnings)
        check_scene(scene, self.capabilities, self, self.warnings)
        self._bodies: dict[str, tuple[Body, ...]] = {}
        self._external_wrenches = ExternalWrenches()
        self._pushed: dict[tuple[str, tuple[str, ...], str], Group | None] = {}
        self._body_paths: dict[tuple[str, str], BodyPath] = {}
        self._constant: dict[str, Any] = {}
        self._space: CollisionSpace | None = None
        self._renderers = SceneRenderers(self._open_renderer, "".join(self.capabilities.renderers[:1]))

    @property
    def title(self) -> str:
        """Its name in messages."""
        return type(self).__name__

    @property
    def step_ns(self) -> int:
        """The physics step."""
        return self.capabilities.step_ns

    # -- time

    @final
    def advance(self, steps: int, *, paused: bool = False) -> None:
        """Take physics steps; while the world is paused, time passes but nothing moves."""
        (self._do_wait if paused else self._do_advance)(steps)
        self.now_ns += steps * self.capabilities.step_ns

    @classmethod
    def advance_all(cls, engines: Sequence[Any], steps: int) -> Failures:
        """Take physics steps in several engines, and check their states; an engine may override this.

        Returns:
            The errors by the number of the engine; the others have taken the steps.
        """
        failed: Failures = {}
        for number, engine in enumerate(engines):
            note_failure(failed, number, partial(engine.advance_safely, steps))
        return failed

    def advance_safely(self, steps: int) -> None:
        """Take physics steps and check the state."""
        self.advance(steps)
        self.check_state(self.now_ns)

    @final
    def reset(self, seed: int) -> None:
        """Reset to the state right after opening, with the current scene."""
        self.seed = seed
        self._external_wrenches.clear()
        self._do_reset(seed)

    @final
    def save(self) -> object:
        """Return the complete state as an object that can be pickled.

        Raises:
            CapabilityError: the engine cannot do that.
        """
        if not self.capabilities.snapshot:
            raise self.lacks(SNAPSHOTS)
        return self._do_save()

    @final
    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`, in the same scene."""
        if not self.capabilities.snapshot:
            raise self.lacks(SNAPSHOTS)
        self._do_restore(saved)

    def check_state(self, t_ns: int) -> None:
        """Refuse a state that is not finite or not possible; an engine may override this with a faster check.

        Raises:
            DivergedError: the position of a model is not finite, or its speed :data:`MOST_RATE` or more.
        """
        for model in self.scene.models if self.capabilities.poses else ():
            if model.static:
                continue
            motion = self._do_model_motion(model.name)
            if not all(map(isfinite, motion.pose.position)):
                message = f"model '{model.name}' has a position that is not finite"
                raise DivergedError(message, t_ns=t_ns)
            if not all(abs(rate) < MOST_RATE for rate in (*motion.linear, *motion.angular)):
                message = f"model '{model.name}' moves at more than {MOST_RATE:g} m/s (or rad/s)"
                raise DivergedError(message, t_ns=t_ns)

    @final
    def close(self) -> None:
        """Release the engine and its cameras."""
        self._renderers.close()
        self._do_close()

    # -- for sensors

    @final
    def model_motion(self, model: str) -> ModelMotion:
        """Return pose and velocity of a model's frame."""
        return self._do_model_motion(model)

    @final
    def link_motion(self, model: str, link: str) -> ModelMotion:
        """Return pose and velocity of a link."""
        return self._do_link_motion(model, link)

    @final
    def link_motions(self, model: str, links: tuple[str, ...]) -> LinkMotions:
        """Return poses and velocities of links of a model as arrays."""
        return self._do_link_motions(model, links)

    @final
    def joint_states(self, model: str) -> JointStates:
        """Return the state of a model's joints."""
        return self._do_joint_states(model)

    def joint_positions(self, model: str) -> FloatArray:
        """Return the positions in :meth:`joint_states`, rad or m, shape ``(n,)``."""
        return self.joint_states(model).positions

    @final
    def frames(self, paths: Sequence[BodyPath]) -> ReadFrames:
        """Return a function that writes the poses of bodies; valid for the current scene."""
        return self._do_frames(paths)

    @property
    def visual_colors(self) -> Mapping[str, Rgba]:
        """The colours of visuals that were set, by path, ``model/link/visual``."""
        return self._renderers.colors

    def model_pose(self, model: str) -> Pose:
        """Return the pose of a model's frame."""
        return self._do_model_motion(model).pose

    def position_places(
        self, models: Sequence[str], jointed: Sequence[str]
    ) -> tuple[FloatArray, IntArray] | None:
        """Return an array that always has the present positions, and the indices of some of them.

        Args:
            models: models whose poses (position, orientation x, y, z, w) are wanted.
            jointed: models whose joints are wanted after these, as :meth:`joint_positions` returns them.

        Returns:
            None if no such array has all of them; then :meth:`model_pose` has to be used.
        """
        return None

    def read_motion(self, model: str, row: FloatArray) -> None:
        """Write position, orientation (x, y, z, w), linear and angular velocity, shape ``(13,)``."""
        motion = self._do_model_motion(model)
        row[:] = (*motion.pose.position, *motion.pose.orientation, *motion.linear, *motion.angular)

    def read_joints(self, model: str, rows: FloatArray) -> None:
        """Write positions, velocities and efforts of joints, shape ``(3, n)``."""
        states = self._do_joint_states(model)
        rows[:] = states.positions, states.velocities, states.efforts

    @classmethod
    def read_motions(cls, engines: Sequence[Any], model: str, rows: FloatArray) -> None:
        """Write :meth:`read_motion` of several engines, shape ``(engines, 13)``."""
        for engine, row in zip(engines, rows, strict=True):
            engine.read_motion(model, row)

    @classmethod
    def read_joints_of(cls, engines: Sequence[Any], model: str, rows: FloatArray) -> None:
        """Write :meth:`read_joints` of several engines, shape ``(engines, 3, n)``; 2: without efforts."""
        states = np.empty((3, rows.shape[2]))
        for engine, row in zip(engines, rows, strict=True):
            engine.read_joints(model, states)
            row[:] = states[: len(row)]

    @final
    def render(self, model: str, link: str, camera: str) -> ImageArray:
        """Return the image of a camera, shape ``(height, width, 3)``, RGB, read-only."""
        image = self._do_render(model, link, camera)
        image.flags.writeable = False
        return image

    def look(self, model: str, link: str, camera: str) -> Sight | None:
        """Return what a camera sees now, if the engine can draw its image later; None if it cannot."""
        if type(self)._do_render is not Engine._do_render:
            return None
        return self._renderers.images.look((model, link, camera))

    @final
    def image_size(self, model: str, link: str, camera: str) -> tuple[int, int]:
        """Return height and width of a camera's images."""
        optics = self._optics[model, link, camera]
        return optics.height, optics.width

    @final
    def depth(self, model: str, link: str, camera: str) -> DepthArray:
        """Return the depth image of a camera, m, ``inf`` beyond its far clip distance."""
        image = self._do_depth(model, link, camera)
        image.flags.writeable = False
        return image

    @final
    def segments(self, model: str, link: str, camera: str) -> SegmentArray:
        """Return label and instance of the visual at each pixel, shape ``(height, width, 2)``."""
        return self._renderers.depths.segments((model, link, camera))

    @final
    def scan(self, model: str, link: str, beams: Beams) -> FloatArray:
        """Return the distance along each ray, layer by layer, m, ``inf`` for a ray that hits nothing."""
        return self._do_scan(model, link, beams)

    @final
    def touches(self) -> Sequence[tuple[Touch, tuple[str, str]]]:
        """Return the contacts, with the names of both collisions, ``model/link/collision``."""
        if not (found := self._do_touches()):
            return ()
        return self._collisions().named(found)

    @final
    def contacts(self) -> Sequence[Touch]:
        """Return the contacts without the names of collisions, which take longer."""
        return self._do_touches()

    @final
    def joint_wrench(self, model: str, joint: str) -> Wrench:
        """Return the wrench of a joint's child on its parent, at the joint's origin."""
        return self._do_joint_wrench(model, joint)

    # -- for drives, controllers and services

    @final
    def set_color(self, visual: str, rgba: Rgba) -> None:
        """Set the colour of a visual (``model/link/visual``)."""
        if self._renderers.colors.get(visual) != rgba:  # a reset sets all of them, and painting takes time
            self._renderers.colors[visual] = rgba
            self._do_set_color(visual, rgba)

    @final
    def set_glow(self, visual: str, glows: bool) -> None:
        """Set whether a visual glows: it has its colour in any light."""
        self._renderers.glows[visual] = glows
        self._do_set_glow(visual, glows)

    @final
    def set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        """Set the target velocity of a drive."""
        self._do_set_drive(model, drive, velocity)

    @classmethod
    def set_drive_of(
        cls, engines: Sequence[Any], model: str, drive: str, velocities: Sequence[BodyVelocity]
    ) -> bool:
        """Set the target velocity of a drive in several engines, if it can do so at once.

        Returns:
            Whether it has. Otherwise, and after an error, :meth:`set_drive` is called for each engine:
            nothing may have changed, or nothing that would change again.
        """
        return False

    @final
    def set_wrench(self, model: str, link: str, wrench: Wrench, of: str = "") -> bool:
        """Set the wrench that acts at a link's centre of mass from now on, in addition to those of others.

        Args:
            model: the model.
            link: its link.
            wrench: the wrench; it replaces the previous one of the same owner.
            of: the owner of the wrench.

        Returns:
            Whether its lever arm turns with the body, so that it must be set again in each step.
        """
        path = self._place_of(model, link)
        body = self._bodies_of(model)[path[1]]
        if body.inertial is None:
            return False  # a fixed body cannot be pushed

        def pose() -> Pose:
            return self.link_motion(model, link).pose

        total, turns = self._external_wrenches.add(path, body, link, pose, wrench, of)
        self._do_set_wrench(path, total)
        return turns

    @final
    def set_wrenches(self, model: str, links: tuple[str, ...], wrenches: FloatArray, of: str = "") -> None:
        """Set the wrenches of an owner on links of a model: :meth:`set_wrench` for each, but faster.

        Args:
            model: the model.
            links: its links.
            wrenches: forces and torques, N and N m, along the axes of the world, shape ``(n, 6)``.
            of: the owner of the wrenches.
        """
        key, rows = (model, links, of), wrenches.tolist()
        if key not in self._pushed:
            paths = [self._place_of(model, link) for link in links]
            found = [
                (path, self._bodies_of(model)[path[1]], link) for path, link in zip(paths, links, strict=True)
            ]
            moves = all(body.inertial is not None for _, body, _ in found)
            self._pushed[key] = self._external_wrenches.group(found, of) if moves else None
        group = self._pushed[key]
        if group is None:
            for link, row in zip(links, rows, strict=True):
                self.set_wrench(model, link, wrench_of(row), of)
        else:
            self._do_set_wrenches(group.bodies, self._external_wrenches.add_all(group, rows))

    # -- changes of the scene

    @final
    def load(self, scene: Scene) -> None:
        """Load another scene in its initial state; if only lights differ, set these.

        Raises:
            CapabilityError: the engine cannot simulate a model in it.
        """
        if replace(self.scene, lights=scene.lights) == scene:
            self.set_lights(scene.lights)
            return
        check_scene(scene, self.capabilities, self, self.warnings)
        self._do_load(scene)
        self.scene = scene
        self._bodies, self._body_paths, self._constant = {}, {}, {}
        self._external_wrenches, self._pushed = ExternalWrenches(), {}
        self._space = None
        self._renderers.close()
        self._renderers = SceneRenderers(self._open_renderer, "".join(self.capabilities.renderers[:1]))

    @final
    def set_lights(self, lights: tuple[Light, ...]) -> None:
        """Set the lights of the scene; realistic images show them, flat ones do not."""
        self.scene = replace(self.scene, lights=lights)
        self._do_set_lights(lights)

    @final
    def floats(self, model: str) -> bool:
        """Return whether the base of a model floats freely."""
        bodies = self._bodies_of(model)
        return bodies[body_of(bodies, self.scene.model(model).links[0].name)].floats

    @final
    def place(self, model: str, motion: ModelMotion) -> None:
        """Set pose and velocity of a model whose base floats; its joints keep their positions."""
        self._do_place(model, motion)

    @final
    def set_joints(self, model: str, positions: Mapping[str, float]) -> None:
        """Set the positions of joints, at rest."""
        self._do_set_joints(model, positions)

    @final
    def configuration(self, model: str) -> object:
        """Return positions and velocities of a model and its joints."""
        return self._do_configuration(model)

    @final
    def configure(self, model: str, configuration: object) -> None:
        """Restore a model's state from :meth:`configuration`."""
        self._do_configure(model, configuration)

    def parts(self, usual: Sequence[Part], model: Model | None) -> Sequence[Part]:
        """Return the parts of a model, or of the world itself (None).

        An engine whose messages come from outside, as from ROS or a recording, replaces the core's parts.
        """
        return usual

    def answer(self, service: str, request: Any, response: type) -> Any:
        """Return the answer of a body that has services of its own, as one behind ROS; else None.

        Args:
            service: name of the service.
            request: the request.
            response: class of the answer.
        """
        return None

    # -- derived from the scene alone

    @final
    def _share(self, like: Engine) -> None:
        """Use the constant parts of another engine with the same scene."""
        self._bodies, self._body_paths, self._constant = like._bodies, like._body_paths, like._constant

    def _bodies_of(self, model: str) -> tuple[Body, ...]:
        if model not in self._bodies:
            self._bodies[model] = bodies_of(self.scene.model(model))
        return self._bodies[model]

    def _place_of(self, model: str, link: str) -> BodyPath:
        """Return the path of the body that a link is part of."""
        if (model, link) not in self._body_paths:
            self._body_paths[model, link] = model, body_of(self._bodies_of(model), link)
        return self._body_paths[model, link]

    def _all_bodies(self) -> dict[str, tuple[Body, ...]]:
        return {model.name: self._bodies_of(model.name) for model in self.scene.models}

    def _collisions(self) -> CollisionSpace:
        from nrp_core.world.raycast.collisions import CollisionSpace  # compiled code takes time to load

        if self._space is None and "space" in self._constant:
            self._space = self._constant["space"].copy(self._do_frames)
        elif self._space is None:
            self._space = CollisionSpace(self._all_bodies(), self._do_frames)
            self._constant["space"] = self._space
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
        if renderer == RASTER and RASTER in self._constant:
            cameras: Cameras = self._constant[RASTER].copy(self._do_frames)
            return cameras
        scene = self._all_bodies(), self._optics, self._do_frames, self.scene.lights
        cameras = open_shared(renderer, *scene)
        if renderer == RASTER:
            self._constant[RASTER] = cameras
        return cameras

    # -- for backends: the operations that cannot be derived

    @abstractmethod
    def _do_advance(self, steps: int) -> None:
        """Take ``steps`` physics steps."""

    @abstractmethod
    def _do_reset(self, seed: int) -> None:
        """Reset to the state right after opening; bit for bit if determinism is declared."""

    def _do_wait(self, steps: int) -> None:
        """Let the time of steps pass while the world is paused; external sensors may continue."""

    def _do_model_motion(self, model: str) -> ModelMotion:
        """Return pose and velocity of a model's frame; needed unless ``poses`` is declared false."""
        raise self.lacks("does not report where models are")

    @abstractmethod
    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        """Set the target velocity of a drive."""

    def _do_set_color(self, visual: str, rgba: Rgba) -> None:
        """Set the colour of a visual, named by its path ``model/link/visual``, from the next image on."""
        for cameras in self._renderers.opened:
            cameras.set_color(visual, rgba)

    def _do_set_glow(self, visual: str, glows: bool) -> None:
        """Set whether a visual glows, from the next image on."""
        for cameras in self._renderers.opened:
            cameras.set_glow(visual, glows)

    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        """Return the current image of a camera, shape ``(height, width, 3)``, RGB, a new array."""
        return self._renderers.images.image((model, link, camera))

    def _do_depth(self, model: str, link: str, camera: str) -> DepthArray:
        """Return the current depth image of a camera, m, shape ``(height, width)``, a new array."""
        return self._renderers.depths.depth((model, link, camera))

    def _do_scan(self, model: str, link: str, beams: Beams) -> FloatArray:
        """Return the distance along each ray of a scanner; an engine may use shapes and rays of its own."""
        return self._collisions().scan(model, link, beams)

    def _do_open_cameras(self, renderer: str) -> Cameras:
        """Open one of the engine's own renderers."""
        raise self.lacks(f"has no renderer '{renderer}'")

    def _do_set_lights(self, lights: Sequence[Light]) -> None:
        """Set the lights, from the next image on."""
        for cameras in self._renderers.opened:
            cameras.set_lights(lights)

    def _do_joint_states(self, model: str) -> JointStates:
        """Return the state of the movable joints of a model, in the order of its file."""
        raise self.lacks("does not report joints")

    def _do_link_motion(self, model: str, link: str) -> ModelMotion:
        """Return pose and velocity of a link, in the frame of the world."""
        if not self.capabilities.dynamics:  # joints stay at their initial positions
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
        """Return a function that writes the poses of these bodies; called once."""
        links = [(model, self._bodies_of(model)[index].links[0]) for model, index in paths]

        def read(frames: FloatArray) -> None:
            for frame, (model, link) in zip(frames, links, strict=True):
                pose = self._do_link_motion(model, link.name).pose @ link.pose.inverse()
                frame[:, :3], frame[:, 3] = rotation_matrix(pose.orientation), pose.position

        return read

    def _do_touches(self) -> Sequence[Touch]:
        """Return all contacts of the last physics step, except those within a model."""
        raise self.lacks("does not report contacts")

    def _do_joint_wrench(self, model: str, joint: str) -> Wrench:
        """Return the wrench of a joint's child on its parent in the last step, at the joint's origin."""
        raise self.lacks("does not report the forces in joints")

    def _do_link_motions(self, model: str, links: tuple[str, ...]) -> LinkMotions:
        """Return poses and velocities of links; an engine may override it with a faster one."""
        return LinkMotions.of([self._do_link_motion(model, link) for link in links])

    def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        """Set the wrench that acts at a body's centre of mass from now on."""
        raise self.lacks("cannot apply forces")

    def _do_set_wrenches(self, bodies: tuple[BodyPath, ...], wrenches: Sequence[Sequence[float]]) -> None:
        """Set the wrenches on bodies; an engine may override it with a faster one."""
        for body, row in zip(bodies, wrenches, strict=True):
            self._do_set_wrench(body, wrench_of(row))

    def _do_load(self, scene: Scene) -> None:
        """Load another scene in its initial state."""
        raise self.lacks(SCENE_CHANGES)

    def _do_place(self, model: str, motion: ModelMotion) -> None:
        """Set pose and velocity of a model whose base floats; its joints keep their positions."""
        raise self.lacks(MODEL_MOVES)

    def _do_set_joints(self, model: str, positions: Mapping[str, float]) -> None:
        """Set the positions of joints, at rest."""
        raise self.lacks("cannot move joints")

    def _do_configuration(self, model: str) -> object:
        """Return positions and velocities of a model and its joints."""
        raise self.lacks(MODEL_MOVES)

    def _do_configure(self, model: str, configuration: object) -> None:
        """Restore a model's state from :meth:`_do_configuration`."""
        raise self.lacks(MODEL_MOVES)

    def _do_save(self) -> object:
        """Return the complete state as an object that can be pickled."""
        raise self.lacks(SNAPSHOTS)

    def _do_restore(self, saved: Any) -> None:
        """Restore a state from :meth:`_do_save`."""
        raise self.lacks(SNAPSHOTS)

    def _do_close(self) -> None:
        """Release the engine; by default do nothing."""
