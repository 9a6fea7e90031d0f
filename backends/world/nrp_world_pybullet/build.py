"""A scene as PyBullet bodies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, combinations_with_replacement, product
from math import isfinite

from nrp_core._support.quiet import quiet
from nrp_core.clock import seconds
from nrp_core.errors import SceneError
from nrp_core.findings import Findings
from nrp_core.scene.merged_bodies import Body, tree_of
from nrp_core.scene.model import Collision, Inertial, Joint, Model, Scene
from nrp_core.scene.rigid import BodyPath, Pose
from nrp_core.world.engine_kit.planar_servo import PlanarServo, planar_drives, servo_of
from nrp_core.world.engine_kit.simulated import simulated_bodies
from nrp_world_pybullet.library import bullet
from nrp_world_pybullet.shapes import (
    NO_SHAPE,
    add_collisions,
    close_loops,
    collisions_of,
    friction_factors,
    set_contacts,
    tie_models,
)

BASE = -1
UNLIMITED_SPEED = 1e6
UNLIMITED_FORCE = 1e6
FIRM = 0.9  # the share of a position error that a coupling corrects in a step
FAR_AWAY = 1e9
MASSLESS = Inertial(0.0)


@dataclass(frozen=True, slots=True)
class BodyHandle:
    """The handle of a body in PyBullet: its multi-body and its link, -1 for the base.

    ``axis`` is one of the three coordinates of a ball joint (0, 1, 2), else None.
    """

    multibody: int
    link: int
    axis: int | None = None


@dataclass(frozen=True, slots=True)
class Built:
    """A loaded scene and the handles of its parts in the engine.

    Args:
        bodies: bodies of each model with their handles.
        joints: handles of the coordinates of each model's joints, in the order of its file.
        drives: the servo of each drive, by model and drive.
        owners: model and body of each multi-body's links, the base being -1.
        warnings: elements for PyBullet that are not used.
    """

    bodies: Mapping[str, list[tuple[Body, BodyHandle]]]
    joints: Mapping[str, dict[str, BodyHandle]]
    drives: Mapping[tuple[str, str], PlanarServo]
    owners: Mapping[tuple[int, int], BodyPath]
    warnings: Findings


def build(scene: Scene, *, timestep_ns: int, client: int, physical: bool = False) -> Built:
    """Load a scene.

    Args:
        scene: the scene.
        timestep_ns: the physics step.
        client: the physics client.
        physical: whether wheels move the robot by friction.

    Raises:
        SceneError: PyBullet refuses it, or it is inconsistent.
    """
    bullet.resetSimulation(physicsClientId=client)
    bullet.setGravity(*scene.gravity, physicsClientId=client)
    bullet.setPhysicsEngineParameter(
        fixedTimeStep=seconds(timestep_ns), deterministicOverlappingPairs=1, physicsClientId=client
    )
    try:
        with quiet():
            return _Builder(scene, client, physical, seconds(timestep_ns)).built()
    except bullet.error as error:
        raise SceneError(f"PyBullet cannot build the scene: {error}") from error


@dataclass(frozen=True, slots=True)
class _Link:
    """A link of a multi-body; the base is one, too.

    Args:
        parent: number of the parent among all links, the base being 0; None for the base.
        pose: pose in the parent's frame; for a base, in the world.
        collisions: its collisions, all with the same frictions and bits.
        inertial: its mass; 0 for fixed links and for additional collisions of the parent.
        joint: its joint; None if it is fixed.
    """

    parent: int | None
    pose: Pose
    collisions: Sequence[Collision]
    inertial: Inertial = MASSLESS
    joint: Joint | None = None


class _Builder:
    """Loads a scene into a client."""

    def __init__(self, scene: Scene, client: int, physical: bool, step_s: float) -> None:
        self._scene, self._client = scene, client
        self._physical, self._step_s = physical, step_s
        self._bodies: dict[str, list[tuple[Body, BodyHandle]]] = {}
        self._joints: dict[str, dict[str, BodyHandle]] = {}
        self._drives: dict[tuple[str, str], PlanarServo] = {}
        self._owners: dict[tuple[int, int], BodyPath] = {}
        self._kinds: dict[tuple[int, int], list[tuple[BodyHandle, Collision]]] = {}
        self._warnings = Findings()
        self._simulated = {each.name: simulated_bodies(each, step_s, physical) for each in scene.models}
        self._frictions = friction_factors(scene, self._simulated, self._warnings)

    def built(self) -> Built:
        for model in self._scene.models:
            self._add_model(model)
        placed = {
            name: [(body, (place.multibody, place.link)) for body, place in bodies]
            for name, bodies in self._bodies.items()
        }
        tie_models(self._scene, placed, self._client, self._warnings)
        self._filter()
        return Built(self._bodies, self._joints, self._drives, self._owners, self._warnings)

    def _add_model(self, model: Model) -> None:
        bodies = self._simulated[model.name]
        places: dict[int, BodyHandle] = {}
        roots = [root for root, body in enumerate(bodies) if body.parent is None]
        added = [each for root in roots for each in self._add_tree(model.name, root, bodies, places)]
        if not model.static:
            self._separate(added)
        self._bodies[model.name] = [(body, places[index]) for index, body in enumerate(bodies)]
        self._feel(model, bodies, places)
        where = {index: (place.multibody, place.link) for index, place in places.items()}
        links = {link.name: where[index] for index, body in enumerate(bodies) for link in body.links}
        set_contacts(model, links, self._client, self._warnings)
        joints = {body.joint.name: places[i] for i, body in enumerate(bodies) if body.joint}
        self._joints[model.name] = {
            name: place
            for joint in model.joints
            if joint.name in joints
            for name, place in _coordinates(joint, joints[joint.name])
        }
        self._couple(model)
        close_loops(model, [(body, where[index]) for index, body in enumerate(bodies)], self._client)
        for drive in planar_drives(model):
            self._drives[model.name, drive.name] = servo_of(
                model, drive, bodies, self._scene.gravity, self._physical
            )

    def _add_tree(
        self, model: str, root: int, bodies: Sequence[Body], places: dict[int, BodyHandle]
    ) -> Iterator[int]:
        """Add a root and its descendants as one multi-body, and yield the multi-bodies that were added.

        The shapes of a fixed root that do not fit into its base are multi-bodies of their own: PyBullet tests
        links of a fixed base against static bodies.
        """
        links: list[_Link] = []
        numbers: dict[int, int] = {}
        owners: list[int] = []
        beside: list[Sequence[Collision]] = []
        for index in tree_of(root, bodies):
            body = bodies[index]
            numbers[index] = len(links)
            parent = None if body.parent is None else numbers[body.parent]
            collisions, *more = collisions_of(body)
            links.append(_Link(parent, body.pose, collisions, body.inertial or MASSLESS, body.joint))
            if parent is None and body.fixed:
                beside, more = more, []
            links.extend(_Link(numbers[index], Pose(), collisions) for collisions in more)
            owners += [index] * (1 + len(more))
        multibody = self._place(links, [(model, index) for index in owners])
        places.update({index: BodyHandle(multibody, number - 1) for index, number in numbers.items()})
        yield multibody
        for collisions in beside:
            yield self._place([_Link(None, bodies[root].pose, collisions)], [(model, root)])

    def _place(self, links: Sequence[_Link], owners: Sequence[BodyPath]) -> int:
        """Add links as one multi-body."""
        multibody = self._create(links)
        for number, (link, owner) in enumerate(zip(links, owners, strict=True), start=BASE):
            place = BodyHandle(multibody, number)
            self._owners[multibody, number] = owner
            for collision in link.collisions[:1]:  # the others have the same bits
                self._kinds.setdefault((collision.category, collision.touched), []).append((place, collision))
            self._set_dynamics(place, link)
        return multibody

    def _create(self, links: Sequence[_Link]) -> int:
        base, *others = links
        collisions = [add_collisions(link.collisions, self._client) for link in links]
        multibody = bullet.createMultiBody(
            baseMass=base.inertial.mass,
            baseCollisionShapeIndex=collisions[0],
            basePosition=base.pose.position,
            baseOrientation=base.pose.orientation,
            baseInertialFramePosition=base.inertial.pose.position,
            baseInertialFrameOrientation=base.inertial.pose.orientation,
            linkMasses=[link.inertial.mass for link in others],
            linkCollisionShapeIndices=collisions[1:],
            linkVisualShapeIndices=[NO_SHAPE] * len(others),
            linkPositions=[link.pose.position for link in others],
            linkOrientations=[link.pose.orientation for link in others],
            linkInertialFramePositions=[link.inertial.pose.position for link in others],
            linkInertialFrameOrientations=[link.inertial.pose.orientation for link in others],
            linkParentIndices=[link.parent for link in others],
            linkJointTypes=[_joint_type(link.joint) for link in others],
            linkJointAxis=[(0, 0, 1) if link.joint is None else link.joint.axis for link in others],
            physicsClientId=self._client,
        )
        return int(multibody)

    def _set_dynamics(self, place: BodyHandle, link: _Link) -> None:
        where, client = (place.multibody, place.link), self._client
        bullet.changeDynamics(*where, linearDamping=0, angularDamping=0, physicsClientId=client)
        bullet.changeDynamics(*where, maxJointVelocity=UNLIMITED_SPEED, physicsClientId=client)
        if link.collisions:
            surface = link.collisions[0]
            friction, largest = self._frictions[surface.friction], max(self._frictions.values())
            bullet.changeDynamics(*where, lateralFriction=friction, physicsClientId=client)
            # a contact has the sum of both bodies' values, each times the friction of the other body
            for kind, value in (("spinningFriction", surface.torsion), ("rollingFriction", surface.rolling)):
                if friction and value:
                    bullet.changeDynamics(*where, **{kind: value / largest}, physicsClientId=client)
        if link.inertial.mass:
            moments = link.inertial.inertia[:3]
            bullet.changeDynamics(*where, localInertiaDiagonal=moments, physicsClientId=client)
        if link.joint is not None and link.joint.kind != "fixed":
            self._set_joint(place, link.joint)

    def _set_joint(self, place: BodyHandle, joint: Joint) -> None:
        where, client = (place.multibody, place.link), self._client
        bullet.changeDynamics(*where, jointDamping=joint.damping, physicsClientId=client)
        # a new joint has a motor that acts as friction
        friction = joint.friction
        if joint.kind == "ball":
            bullet.setJointMotorControlMultiDof(
                *where,
                bullet.POSITION_CONTROL,
                targetPosition=(0, 0, 0, 1),
                positionGain=0,
                velocityGain=1,
                force=[friction] * 3,
                physicsClientId=client,
            )
            return
        bullet.setJointMotorControl2(*where, bullet.VELOCITY_CONTROL, force=friction, physicsClientId=client)
        if joint.kind != "continuous" and (isfinite(joint.lower) or isfinite(joint.upper)):
            bullet.changeDynamics(  # together with other arguments the limits would be ignored
                *where,
                jointLowerLimit=max(joint.lower, -FAR_AWAY),
                jointUpperLimit=min(joint.upper, FAR_AWAY),
                physicsClientId=client,
            )

    def _couple(self, model: Model) -> None:
        """Couple joints to the joints that they mimic."""
        places, client = self._joints[model.name], self._client
        for joint in model.joints:
            if joint.mimic is not None and joint.name in places:
                ends = [(p.multibody, p.link) for p in (places[joint.name], places[joint.mimic.leader])]
                origin = (0.0, 0.0, 0.0)
                coupling = bullet.createConstraint(
                    *ends[0], *ends[1], bullet.JOINT_GEAR, (1, 0, 0), origin, origin, physicsClientId=client
                )
                bullet.changeConstraint(
                    coupling,
                    gearRatio=-joint.mimic.multiplier,
                    relativePositionTarget=joint.mimic.offset,
                    erp=FIRM,
                    maxForce=UNLIMITED_FORCE,
                    physicsClientId=client,
                )

    def _feel(self, model: Model, bodies: Sequence[Body], places: Mapping[int, BodyHandle]) -> None:
        """Enable the force sensors of joints with a force-torque sensor."""
        felt = {joint for link in model.links for s in link.sensors for joint in s.measured_joints}
        for index, body in enumerate(bodies):
            if body.joint is not None and body.joint.name in felt:
                where = places[index].multibody, places[index].link
                bullet.enableJointForceTorqueSensor(*where, physicsClientId=self._client)

    def _filter(self) -> None:
        """Exclude contacts between shapes whose bits do not let them collide.

        PyBullet's own groups and masks let two shapes collide only if both ask for it.
        """
        for ones, others in combinations_with_replacement(self._kinds.values(), 2):
            if ones[0][1].touches(others[0][1]):
                continue
            for (one, _), (other, _) in product(ones, others):
                if one.multibody != other.multibody:
                    places = one.multibody, other.multibody, one.link, other.link
                    bullet.setCollisionFilterPair(*places, 0, physicsClientId=self._client)

    def _separate(self, multibodies: Sequence[int]) -> None:
        """Exclude contacts between the parts of one model."""
        for pair in combinations(multibodies, 2):
            links = [range(BASE, bullet.getNumJoints(each, physicsClientId=self._client)) for each in pair]
            for one, other in product(*links):
                bullet.setCollisionFilterPair(*pair, one, other, 0, physicsClientId=self._client)


def _coordinates(joint: Joint, place: BodyHandle) -> Iterator[tuple[str, BodyHandle]]:
    """Yield the coordinates of a joint with their handles."""
    names = joint.coordinates
    for axis, name in enumerate(names):
        yield name, replace(place, axis=axis) if len(names) > 1 else place


def _joint_type(joint: Joint | None) -> int:
    types = {"fixed": bullet.JOINT_FIXED, "prismatic": bullet.JOINT_PRISMATIC, "ball": bullet.JOINT_SPHERICAL}
    return int(bullet.JOINT_FIXED if joint is None else types.get(joint.kind, bullet.JOINT_REVOLUTE))
