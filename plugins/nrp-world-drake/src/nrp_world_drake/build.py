"""A scene as a plant of Drake."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, isfinite
from typing import Any, Final

import numpy as np

from nrp_core.clock import seconds
from nrp_core.errors import SceneError
from nrp_core.findings import Code, Findings
from nrp_core.scene.merged_bodies import Body, body_of
from nrp_core.scene.rigid import BodyPath, Pose
from nrp_core.world import WORLD, FloatArray, Joint, Model, Scene, muscles_of
from nrp_core.world.engine_kit.firm_joints import FirmJoint, firm_joints
from nrp_core.world.engine_kit.joint_servo import servoed_joints
from nrp_core.world.engine_kit.planar_servo import PlanarServo, planar_drives, servo_of
from nrp_core.world.engine_kit.simulated import simulated_bodies
from nrp_core.world.engine_kit.soft_constraints import armatures_of, frictions_of, limits_of
from nrp_world_drake.elements import report_mechanisms
from nrp_world_drake.library import DiagramBuilder, multibody, scalar_first, spatial_inertia, transform, tree
from nrp_world_drake.shapes import Shapes, parts_of

HOLDING: Final = 1e9
"""Damping (N m s/rad, N s/m) of motors that hold a velocity with any load: Drake takes the hardest that its
solver resolves."""

JointPath = tuple[str, str]


@dataclass(frozen=True, slots=True)
class JointHandle:
    """A coordinate of a joint: where it is in Drake's positions and velocities.

    ``axis`` is one of the three coordinates of a ball joint (0, 1, 2), whose places are those of the first;
    None for another joint.
    """

    joint: Any
    position: int
    velocity: int
    axis: int | None = None


@dataclass(frozen=True, slots=True)
class Motor:
    """An actuator, and its number in the input ports."""

    actuator: Any
    number: int

    def set_gains(self, stiffness: float, damping: float) -> None:
        """Set the gains; with both at 0 it only passes on its input."""
        self.actuator.set_controller_gains(tree.PdControllerGains(p=stiffness, d=damping))


@dataclass(slots=True)
class Built:
    """A loaded scene and the handles of its parts in the engine.

    Args:
        plant, diagram: Drake's systems.
        bodies: bodies of each model with Drake's.
        joints: handles of the coordinates of each model's joints, in the order of its file.
        placed: Drake's joint above each body, by the index of the body.
        drives: the servo of each drive, by model and drive.
        spins: the motors of the wheels of each drive.
        servos: the motors with gains, by model and joint.
        firm: the joints that follow with any load, and their motors.
        rubbing: the motors that act as dry friction.
        owners, fields: see :class:`~nrp_world_drake.shapes.Shapes`.
        start: positions and velocities at the start, with all joints at 0.
        warnings: what Drake does not have.
    """

    plant: Any
    diagram: Any
    bodies: dict[str, list[tuple[Body, Any]]] = field(default_factory=dict)
    joints: dict[str, dict[str, JointHandle]] = field(default_factory=dict)
    placed: dict[Any, Any] = field(default_factory=dict)
    drives: dict[tuple[str, str], PlanarServo] = field(default_factory=dict)
    spins: dict[tuple[str, str], list[Motor]] = field(default_factory=dict)
    servos: dict[JointPath, Motor] = field(default_factory=dict)
    firm: dict[JointPath, tuple[FirmJoint, Motor]] = field(default_factory=dict)
    rubbing: dict[JointPath, Motor] = field(default_factory=dict)
    owners: Mapping[Any, BodyPath] = field(default_factory=dict)
    fields: Mapping[Any, tuple[float, float]] = field(default_factory=dict)
    start: FloatArray = field(default_factory=lambda: np.zeros(0))
    warnings: Findings = field(default_factory=Findings)


def build(scene: Scene, *, timestep_ns: int, physical: bool = False) -> Built:
    """Load a scene.

    Args:
        scene: the scene.
        timestep_ns: the physics step.
        physical: whether wheels move the robot by friction.

    Raises:
        SceneError: Drake refuses it, or it is inconsistent.
    """
    try:
        return _Builder(scene, seconds(timestep_ns), physical).built()
    except RuntimeError as error:
        raise SceneError(f"Drake cannot build the scene: {error}") from error


class _Builder:
    """Loads a scene into a plant, which is complete after it is finalized."""

    def __init__(self, scene: Scene, step_s: float, physical: bool) -> None:
        self._scene, self._step_s, self._physical = scene, step_s, physical
        self._systems = DiagramBuilder()
        self._plant, self._scene_graph = multibody.AddMultibodyPlantSceneGraph(self._systems, step_s)
        self._plant.set_discrete_contact_approximation(multibody.DiscreteContactApproximation.kLagged)
        self._plant.set_contact_model(multibody.ContactModel.kHydroelasticWithFallback)
        self._plant.mutable_gravity_field().set_gravity_vector(np.array(scene.gravity))
        self._built = Built(self._plant, None)
        self._placed: dict[str, dict[str, Any]] = {}  # Drake's joints of each model
        self._post: Any = None
        self._limited, self._rubbing = set[str](), set[str]()  # joints whose limits and friction are MuJoCo's

    def built(self) -> Built:
        for model in self._scene.models:
            self._add_model(model)
        for model in self._scene.models:
            self._close_loops(model)
        self._tie_models()
        shapes = Shapes(self._plant, self._scene_graph)
        shapes.register(
            [
                part
                for name, bodies in self._built.bodies.items()
                for part in parts_of(name, bodies, self._plant.world_body(), self._step_s)
            ]
        )
        self._plant.Finalize()
        self._built.diagram = self._systems.Build()
        self._built.owners, self._built.fields = shapes.owners, shapes.fields
        self._locate()
        return self._built

    # -- bodies and joints

    def _add_model(self, model: Model) -> None:
        bodies = simulated_bodies(model, self._step_s, self._physical)
        placed: list[tuple[Body, Any]] = []
        self._built.bodies[model.name] = placed
        self._placed[model.name] = {}
        joints = [body.joint for body in bodies if body.joint is not None] if muscles_of(model) else []
        self._limited = {joints[n].name for n, *_ in limits_of(joints, model)}
        self._rubbing = {joints[n].name for n, *_ in frictions_of(joints, model)}
        for body in bodies:
            placed.append((body, self._add_body(model.name, body)))
            if body.parent is not None:
                self._join(model.name, body, placed)
        self._couple(model)
        for drive in planar_drives(model):
            self._add_drive(model, drive, bodies)
        self._add_motors(model, bodies)
        report_mechanisms(model, [each.name for each in joints if each.coordinates], self._built.warnings)

    def _add_body(self, model: str, body: Body) -> Any:
        if body.fixed:
            return self._plant.world_body()
        assert body.inertial is not None
        return self._plant.AddRigidBody(f"{model}/{body.name}", spatial_inertia(body.inertial))

    def _join(self, model: str, body: Body, placed: Sequence[tuple[Body, Any]]) -> None:
        """Add the joint that connects the last body with its parent."""
        joint, (parent, holder), (_, place) = body.joint, placed[body.parent or 0], placed[-1]
        assert joint is not None
        at = parent.pose @ body.pose if parent.fixed else body.pose
        name = f"{model}/{joint.name}"
        frame = self._plant.AddFrame(
            tree.FixedOffsetFrame(f"{name}/frame", holder.body_frame(), transform(at))
        )
        ends = frame, place.body_frame()
        free = replace(joint, lower=-inf, upper=inf) if joint.name in self._limited else joint
        self._placed[model][joint.name] = self._plant.AddJoint(_joint(name, free, ends))
        self._built.placed[place.index()] = self._placed[model][joint.name]
        if joint.stiffness:
            spring = tree.PrismaticSpring if joint.kind == "prismatic" else tree.RevoluteSpring
            self._plant.AddForceElement(spring(self._placed[model][joint.name], joint.rest, joint.stiffness))

    def _couple(self, model: Model) -> None:
        """Couple joints to the joints that they mimic."""
        placed = self._placed[model.name]
        for joint in model.joints:
            if joint.mimic is not None and joint.name in placed:
                leader, mimic = placed[joint.mimic.leader], joint.mimic
                self._plant.AddCouplerConstraint(placed[joint.name], leader, mimic.multiplier, mimic.offset)

    # -- motors

    def _add_drive(self, model: Model, drive: Any, bodies: Sequence[Body]) -> None:
        path = model.name, drive.name
        servo = servo_of(model, drive, bodies, self._scene.gravity, self._physical)
        self._built.drives[path] = servo
        self._built.spins[path] = [
            self._motor(model.name, wheel.joint, "wheel", wheel.limit, damping=wheel.gain)
            for wheel in servo.wheels
        ]

    def _add_motors(self, model: Model, bodies: Sequence[Body]) -> None:
        placed = self._placed[model.name]
        for name in servoed_joints(model):
            if name in placed and model.joint(name).takes_commands:
                limit = model.joint(name).effort
                self._built.servos[model.name, name] = self._motor(model.name, name, "servo", limit)
        armatures = armatures_of(model)
        for name, firm in firm_joints(model, bodies, armatures).items():
            motor = self._motor(model.name, name, "firm", firm.joint.effort)
            self._built.firm[model.name, name] = firm, motor
        for joint in (body.joint for body in bodies if body.joint is not None):
            if joint.name in self._rubbing:
                continue
            if joint.friction and joint.takes_commands:
                motor = self._motor(model.name, joint.name, "friction", joint.friction, damping=HOLDING)
                self._built.rubbing[model.name, joint.name] = motor
            elif joint.friction and joint.kind == "ball":
                message = (
                    f"Drake does not have the dry friction of the ball joint '{joint.name}' of '{model.name}'"
                )
                self._built.warnings.add(Code.NRP264, message, subject=joint.name)

        for name, inertia in armatures.items():
            if inertia > 0 and name in placed and model.joint(name).takes_commands:
                path = model.name, name
                led = self._built.servos.get(path) or self._built.rubbing.get(path)
                motor = led or self._motor(model.name, name, "armature", np.inf)
                motor.actuator.set_default_rotor_inertia(inertia)

    def _motor(self, model: str, joint: str, use: str, limit: float, damping: float = 0.0) -> Motor:
        """Add an actuator."""
        placed = self._placed[model][joint]
        actuator = self._plant.AddJointActuator(f"{model}/{joint}/{use}", placed, max(limit, 1e-12))
        motor = Motor(actuator, self._plant.num_actuators() - 1)
        motor.set_gains(0.0, damping)
        return motor

    # -- loops and ties

    def _close_loops(self, model: Model) -> None:
        """Keep the links of loops together at the points where they meet with all joints at 0."""
        for loop in model.loops:
            ends = [self._end(model, link) for link in (loop.child, loop.parent)]
            for point in loop.points:
                self._connect(*((place, (to @ Pose(point)).position) for place, to in ends))

    def _tie_models(self) -> None:
        """Hold models together at the points of their ties."""
        for tie in self._scene.ties:
            if tie.freedoms:
                message = f"the joint '{tie.name}' between two models is {tie.kind}: Drake leaves them apart"
                self._built.warnings.add(Code.NRP260, message, subject=tie.name)
                continue
            (holder, to_parent), (held, to_child) = (
                self._end(self._scene.model(name), link) for name, link in (tie.parent, tie.child)
            )
            for there, here in tie.points:
                self._connect(
                    (held, (to_child @ Pose(here)).position), (holder, (to_parent @ Pose(there)).position)
                )

    def _end(self, model: Model, link: str) -> tuple[Any, Pose]:
        """Return the body of a link, and the pose of the model's frame in that, with all joints at 0."""
        if link == WORLD:
            return self._anchor(), model.pose
        body, place = self._built.bodies[model.name][self._index(model.name, link)]
        if body.fixed:
            return self._anchor(), body.pose @ body.in_model.inverse()
        return place, body.in_model.inverse()

    def _index(self, model: str, link: str) -> int:
        return body_of([body for body, _ in self._built.bodies[model]], link)

    def _anchor(self) -> Any:
        """Return a body welded to the world: a constraint with the world itself crashes Drake 1.51."""
        if self._post is None:
            self._post = self._plant.AddRigidBody("post")
            self._plant.WeldFrames(self._plant.world_frame(), self._post.body_frame())
        return self._post

    def _connect(self, one: tuple[Any, Any], other: tuple[Any, Any]) -> None:
        """Keep two points of bodies together, unless they are one body."""
        if one[0].index() != other[0].index():
            self._plant.AddBallConstraint(one[0], np.array(one[1]), other[0], np.array(other[1]))

    # -- places in Drake's state

    def _locate(self) -> None:
        """Find the places of joints and free bodies in the state, and put these at their poses."""
        plant = self._plant
        self._built.start = np.concatenate(
            [plant.GetPositions(plant.CreateDefaultContext()), np.zeros(plant.num_velocities())]
        )
        for model in self._scene.models:
            joints = self._placed[model.name]
            self._built.joints[model.name] = {
                name: handle
                for joint in model.joints
                if joint.name in joints
                for name, handle in _coordinates(joint, joints[joint.name])
            }
            for body, place in self._built.bodies[model.name]:
                if body.floats:
                    first = place.floating_positions_start()
                    pose = (*scalar_first(body.pose.orientation), *body.pose.position)
                    self._built.start[first : first + 7] = pose


def _joint(name: str, joint: Joint, ends: tuple[Any, Any]) -> Any:
    limited = joint.kind != "continuous" and (isfinite(joint.lower) or isfinite(joint.upper))
    limits = (joint.lower, joint.upper) if limited else (-np.inf, np.inf)
    match joint.kind:
        case "fixed":
            return tree.WeldJoint(name, *ends, transform(Pose()))
        case "ball":
            return tree.BallRpyJoint(name, *ends, damping=joint.damping)
        case "prismatic":
            return tree.PrismaticJoint(name, *ends, np.array(joint.axis), *limits, damping=joint.damping)
    return tree.RevoluteJoint(name, *ends, np.array(joint.axis), *limits, damping=joint.damping)


def _coordinates(joint: Joint, placed: Any) -> Iterator[tuple[str, JointHandle]]:
    """Yield the coordinates of a joint with their handles."""
    names = joint.coordinates
    for axis, name in enumerate(names):
        places = placed.position_start(), placed.velocity_start()
        yield name, JointHandle(placed, *places, axis if len(names) > 1 else None)
