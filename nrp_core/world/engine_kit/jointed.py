"""The shared part of physics backends: their options, and engines with joints, servos and contacts."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal, Protocol

from pydantic import Field

from nrp_core._support.arrays import FloatArray
from nrp_core._support.diagnosis import Diagnosis
from nrp_core.clock import NS_PER_MS
from nrp_core.errors import BackendLoadError
from nrp_core.quantities import DurationNs
from nrp_core.scene.merged_bodies import Body, body_of
from nrp_core.scene.model import Link, Model, Scene
from nrp_core.scene.posture import start_positions
from nrp_core.scene.rigid import (
    BodyPath,
    BodyVelocity,
    JointStates,
    ModelMotion,
    Pose,
    Quaternion,
    ServoTarget,
    Touch,
    Wrench,
    rotation_by,
)
from nrp_core.simulation import Determinism
from nrp_core.world.backend import WorldBackend, WorldOptions
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.engine import Engine
from nrp_core.world.engine_kit.joint_bounds import JointBounds
from nrp_core.world.render.cameras import RASTER, REALISTIC, SHARED


class PhysicsOptions(WorldOptions):
    """Options of a world in a physics engine; one with renderers of its own adds them to ``renderer``."""

    timestep: Annotated[DurationNs, Field(description="the physics step")] = 2 * NS_PER_MS
    image_scale: Annotated[
        float, Field(ge=0.01, le=1, description="scales width and height of every camera, for speed")
    ] = 1.0
    drive: Annotated[
        Literal["planar", "physical"],
        Field(
            description="how wheels move a robot: planar moves the body as commanded, "
            "physical only turns the wheels"
        ),
    ] = "planar"
    renderer: Annotated[
        Literal["auto", "raster", "realistic"],
        Field(
            description="of cameras: raster (auto) draws flat colours on the CPU, realistic light and shadows"
        ),
    ] = "auto"


MotionOf = Callable[[], ModelMotion]
"""Reads pose and velocity of an object."""


class Built(Protocol):
    """The handles of a scene's objects in the engine, of a type that the engine defines."""

    @property
    def bodies(self) -> Mapping[str, Sequence[tuple[Body, Any]]]:
        """The bodies of each model, with their handles."""

    @property
    def joints(self) -> Mapping[str, Mapping[str, Any]]:
        """The handles of the coordinates of each model's joints."""


class Drive(Protocol):
    """Moves a body as commanded."""

    def set_velocity(self, velocity: BodyVelocity) -> None:
        """Set the target velocity of the body."""

    def forget(self) -> None:
        """Treat the next command as if it had been in force before."""


class JointReader(Protocol):
    """Reads the movable joints of one model."""

    def states(self) -> JointStates:
        """Return positions, velocities and efforts."""


class Base(Protocol):
    """A body that floats freely."""

    def __call__(self) -> ModelMotion:
        """Return how its frame moves."""

    def put(self, motion: ModelMotion) -> None:
        """Set its pose and velocity."""


class Control(Protocol):
    """Forces on bodies and joints that drives do not exert, and measurements of forces."""

    def set_target(self, model: str, joint: str, aim: ServoTarget) -> None:
        """Set the target of a joint's servo."""

    def orient(self, model: str, joint: str, orientation: Quaternion | None) -> None:
        """Lead a ball joint to an orientation of its child, or release it."""

    def set_effort(self, model: str, joint: str, effort: float) -> None:
        """Apply an effort to a joint."""

    def set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        """Apply a wrench to a body."""

    def touches(self) -> Iterable[Touch]:
        """Return the contacts of the last step."""

    def joint_wrench(self, body: Body, place: Any) -> Wrench:
        """Return the wrench of a body on its parent in the last step, at the body's origin."""


class JointedEngine(Engine):
    """A physics engine with joints, servos, contacts and cameras.

    A backend's ``_do_load`` builds the scene, sets the four attributes, and calls :meth:`_survey`. Its
    constructor ends with :meth:`_warm_up`.

    Args:
        scene: the scene.
        seed: the experiment's seed for the world.
        capabilities: the capabilities of the backend.
        options: the options of the backend.
        name: name and version of the engine.
    """

    _built: Built
    _drives: Mapping[tuple[str, str], Drive]
    _joints: Mapping[str, JointReader]
    _control: Control

    def __init__(
        self,
        scene: Scene,
        *,
        seed: int,
        capabilities: WorldCapabilities,
        options: PhysicsOptions,
        name: str,
    ) -> None:
        super().__init__(scene, capabilities, seed=seed, identity=f"{name} {options.model_dump_json()}")
        self._options = options
        self.image_scale = options.image_scale

    def _survey(self, scene: Scene) -> None:
        """Find the readers of the motions of models; those of links are found on demand."""
        self._motions = {model.name: self._motion_of(model, None) for model in scene.models}
        self._links: dict[tuple[str, str], MotionOf] = {}
        joints = self._built.joints.items()
        self._bounds = {name: JointBounds(scene.model(name), tuple(each)) for name, each in joints if each}
        self._put_at_start(scene)

    def check_state(self, t_ns: int) -> None:
        super().check_state(t_ns)
        for name, bounds in self._bounds.items():
            bounds.require(self._joints[name].states(), t_ns)

    def _put_at_start(self, scene: Scene) -> None:
        """Put the joints at their initial positions; engines begin with all joints at 0."""
        for model in scene.models:
            starts = {} if model.static else start_positions(model)
            for name, position in starts.items():
                self._do_put_joint(self._built.joints[model.name][name], position)
            if starts:
                self._moved(model.name)

    def _warm_up(self) -> None:
        """Render an image with each camera, because the first one is slow."""
        for path in self._optics:
            self._renderers.images.image(path)

    def _motion_of(self, model: Model, link: Link | None) -> MotionOf:
        """Return the reader of the motion of a link, or of the model's frame, fixed to the base's body."""
        name = (link or model.links[0]).name
        bodies = self._built.bodies[model.name]
        body, place = bodies[body_of([body for body, _ in bodies], name)]
        held = next(each.pose for each in body.links if each.name == name)
        offset = body.in_model.inverse() if link is None else held
        if not body.fixed:
            return self._do_motion_of(body, place, offset)
        still = ModelMotion(body.pose @ offset)
        return lambda: still

    def _do_model_motion(self, model: str) -> ModelMotion:
        return self._motions[model]()

    def _do_link_motion(self, model: str, link: str) -> ModelMotion:
        return self._motion_of_link(model, link)()

    def _motion_of_link(self, model: str, link: str) -> MotionOf:
        path = model, link
        if path not in self._links:
            owner = self.scene.model(model)
            self._links[path] = self._motion_of(owner, owner.link(link))
        return self._links[path]

    def joint_positions(self, model: str) -> FloatArray:
        return self._joints[model].states().positions

    def _do_joint_states(self, model: str) -> JointStates:
        return self._joints[model].states()

    def _do_touches(self) -> Sequence[Touch]:
        return list(self._control.touches())

    def _do_joint_wrench(self, model: str, joint: str) -> Wrench:
        for body, place in self._built.bodies[model]:
            if body.joint is not None and body.joint.name == joint:
                return self._control.joint_wrench(body, place)
        raise AssertionError(f"no joint '{joint}' connects two bodies of '{model}'")  # sensors' joints all do

    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        self._drives[model, drive].set_velocity(velocity)

    def _do_set_servo_target(self, model: str, joint: str, aim: ServoTarget) -> None:
        self._control.set_target(model, joint, aim)

    def _do_set_ball_target(self, model: str, joint: str, orientation: Quaternion | None) -> None:
        self._control.orient(model, joint, orientation)

    def _do_set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        self._control.set_effort(model, joint, effort)

    def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        self._control.set_wrench(body, wrench)

    def _do_place(self, model: str, motion: ModelMotion) -> None:
        to_model = self._do_model_motion(model).pose.inverse()
        for body, place in self._built.bodies[model]:
            if body.floats:
                base = self._do_base(body, place)
                base.put(motion.at(to_model @ base().pose))
        self._moved(model)

    def _do_set_joints(self, model: str, positions: Mapping[str, float]) -> None:
        states = self._do_joint_states(model)
        now = dict(zip(states.names, states.positions.tolist(), strict=True))
        places = self._built.joints[model]
        for joint in self.scene.model(model).joints:
            given = [positions[name] for name in joint.coordinates if name in positions]
            if given and joint.kind == "ball":
                x, y, z = (positions.get(name, now[name]) for name in joint.coordinates)
                self._do_put_ball(places[joint.coordinates[0]], rotation_by((x, y, z)))
            elif given:
                self._do_put_joint(places[joint.name], given[0])
        self._moved(model)

    def _continue(self, model: str | None = None) -> None:
        """Accept a state of a model, by default of all models, that was not reached by steps."""
        for (owner, _), drive in self._drives.items():
            if model in (owner, None):
                drive.forget()

    # -- for backends

    @abstractmethod
    def _moved(self, model: str) -> None:
        """Continue from the new pose of a model."""

    @abstractmethod
    def _do_motion_of(self, body: Body, place: Any, offset: Pose) -> MotionOf:
        """Return the reader of the motion of a frame at an offset from a moving body."""

    @abstractmethod
    def _do_base(self, body: Body, place: Any) -> Base:
        """Return a body that floats freely."""

    @abstractmethod
    def _do_put_joint(self, place: Any, position: float) -> None:
        """Set the position of a joint, at rest."""

    @abstractmethod
    def _do_put_ball(self, place: Any, orientation: Quaternion) -> None:
        """Set the rotation of a ball joint, at rest; the handle is that of its first coordinate."""


class PhysicsBackend(WorldBackend):
    """The entry point of a physics engine with joints, contacts and cameras.

    Attributes:
        engine_name: name of the engine, for messages.
        remedy: command that installs it.
        releases_gil: whether it releases the GIL while it steps.
        own_actuators: whether it has the actuators and sensors that elements for it describe.
        muscles: whether it has muscles along straight lines.
        wrapping: whether it has muscles of MJCF that wrap around shapes.
    """

    options: ClassVar[type[PhysicsOptions]]
    engine_name: ClassVar[str]
    remedy: ClassVar[str]
    releases_gil: ClassVar[bool] = False
    own_actuators: ClassVar[bool] = False
    muscles: ClassVar[bool] = False
    wrapping: ClassVar[bool] = False

    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        assert isinstance(options, PhysicsOptions)
        auto = options.renderer == "auto"
        return WorldCapabilities(
            step_ns=options.timestep,
            determinism=Determinism.MACHINE,
            renderers=(*SHARED, *self._own_renderers()) if auto else (options.renderer,),
            snapshot=True,
            links=True,
            contacts=True,
            joint_control=True,
            joint_wrenches=True,
            ball_joints=True,
            ball_control=True,
            loops=True,
            coupled_joints=True,
            changes=True,
            own_actuators=self.own_actuators,
            muscles=self.muscles,
            wrapping=self.wrapping,
            slip=float(options.drive == "physical"),
            releases_gil=self.releases_gil,
        )

    def diagnose(self) -> list[Diagnosis]:
        own = "".join(f", {name}" for name in self._own_renderers())
        meaning = f"{RASTER} (flat colours), {REALISTIC} (light and shadows){own}"
        return [Diagnosis("renderers of cameras", True, meaning)]

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        assert isinstance(options, self.options)
        try:
            engine = self._engine_class()
        except ImportError as error:
            raise BackendLoadError(
                f"{self.engine_name} does not import: {error}", remedy=self.remedy
            ) from error
        return engine(scene, seed=seed, capabilities=self.capabilities(options), options=options)

    def _own_renderers(self) -> tuple[str, ...]:
        """Return the engine's own renderers that work on this machine."""
        return ()

    @abstractmethod
    def _engine_class(self) -> Callable[..., JointedEngine]:
        """Import the engine and return its class."""
