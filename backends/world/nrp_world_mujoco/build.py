"""A scene as a MuJoCo model."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, combinations, count
from math import isfinite
from sys import float_info
from typing import Any

from nrp_core.clock import seconds
from nrp_core.errors import SceneError
from nrp_core.findings import Findings
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.model import Inertial, Joint, Link, Model, Scene
from nrp_core.scene.origin import Native
from nrp_core.scene.rigid import BodyPath, Pose
from nrp_core.world.engine_kit.firm_joints import FirmJoint, firm_joints
from nrp_core.world.engine_kit.joint_servo import servoed_joints
from nrp_core.world.engine_kit.planar_servo import PlanarServo, planar_drives, servo_of
from nrp_core.world.engine_kit.simulated import simulated_bodies
from nrp_core.world.robot_setup import HELD
from nrp_world_mujoco.library import compile_spec, mujoco, pos_quat, scalar_first
from nrp_world_mujoco.mechanisms import FREE, BuiltParts, touches_itself
from nrp_world_mujoco.muscles import add_muscles
from nrp_world_mujoco.native import NativeElements, let_weigh_nothing, neighbours
from nrp_world_mujoco.one_file import settings_of_scene
from nrp_world_mujoco.shapes import (
    FAR_AWAY,
    FIRMEST,
    HARD,
    SMALLEST,
    Shapes,
    add_joint,
    close_loops,
    shortest,
    tie_models,
)

FEW_GEOMS = 64  # with fewer, testing each pair is faster than bounding volumes
SAME_CONTACTS = mujoco.mjtDisableBit.mjDSBL_MIDPHASE  # has no bounding volumes, and the same contacts
MANY_GEOMS = 1000  # from here on, the poses of those that never move take longer than the rest of a step
FEW_FREEDOMS = 24  # up to here, solving all constraints at once is faster than finding which are connected
STRONG = 1.0  # step times damping over inertia, from which on contacts have to be computed with a damper
MAX_IMPEDANCE = 0.9999  # MuJoCo's
AHEAD, ASIDE = [1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0]


@dataclass(frozen=True, slots=True)
class Built:
    """A compiled scene and the ids of its parts in the engine.

    Args:
        model: the compiled model.
        bodies: bodies of each model with their ids (0 for fixed ones).
        joints: the degree of freedom of each coordinate of a model's joints, in the order of its file.
        drives: the servo of each drive, by model and drive, and the ids of its actuators: those of the
            servo's points, then those of the wheels.
        servos: ids of the actuators of servoed joints, by model and joint.
        declared: stiffness and damping of the servos that MJCF itself defines.
        firm: the joints among them, and the coordinates of ball joints, that follow with any load.
        owners: model and body of each geom; a geom without contacts may have none.
        actuators: ids of the muscles and of the actuators of MuJoCo's own elements, by model and name.
        sensors: ids of the sensors of MuJoCo's own elements, in the same form.
        warnings: elements for MuJoCo that are not used.
    """

    model: Any
    bodies: Mapping[str, list[tuple[Body, int]]]
    joints: Mapping[str, dict[str, int]]
    drives: Mapping[tuple[str, str], tuple[PlanarServo, list[int]]]
    servos: Mapping[tuple[str, str], int]
    declared: Mapping[tuple[str, str], Sequence[tuple[float, float]]]
    firm: Mapping[tuple[str, str], FirmJoint]
    owners: Sequence[BodyPath]
    actuators: Mapping[tuple[str, str], int]
    sensors: Mapping[tuple[str, str], int]
    warnings: Findings


def build(scene: Scene, *, timestep_ns: int, physical: bool = False, impratio: float | None = None) -> Built:
    """Compile a scene.

    Args:
        scene: the scene.
        timestep_ns: the physics step.
        physical: whether wheels move the robot by friction.
        impratio: the ratio of the impedances of friction and contacts; None for that of the scene.

    Raises:
        SceneError: MuJoCo refuses it, or it is inconsistent.
    """
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.option.timestep = seconds(timestep_ns)
    spec.option.gravity = scene.gravity
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST  # stable for servos with any gain
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC  # isotropic friction
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET  # divergence is an error
    settings = settings_of_scene(scene)
    builder = _Builder(scene, spec, physical, settings)
    try:
        built = builder.built()
    except ValueError as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(f"MuJoCo cannot build the scene: {' '.join(str(error).split())}") from error
    if impratio is not None:
        built.model.opt.impratio = impratio
    return built


class _Builder:
    """Builds a specification; its elements have ids after it is compiled."""

    def __init__(self, scene: Scene, spec: Any, physical: bool, settings: Native | None) -> None:
        self._scene, self._spec, self._physical, self._settings = scene, spec, physical, settings
        self._stiff = shortest(spec)
        self._native = NativeElements(spec)
        self._shapes = Shapes(spec, scene, self._native.warnings)
        self._bodies: dict[str, list[tuple[Body, Any]]] = {}
        self._joints: dict[str, list[tuple[Joint, Any]]] = {}
        self._drives: dict[tuple[str, str], tuple[PlanarServo, list[Any]]] = {}
        self._servos: dict[tuple[str, str], Any] = {}
        self._firm: dict[tuple[str, str], FirmJoint] = {}
        self._owners: list[tuple[BodyPath, Any]] = []
        self._collisions: dict[str, list[Any]] = {}
        self._links: dict[str, tuple[Any, Pose]] = {}
        self._links_of: dict[str, dict[str, tuple[Any, Pose]]] = {}

    def built(self) -> Built:
        for model in self._scene.models:
            self._add_model(model)
        tie_models(self._scene, self._links_of, self._spec)
        actuators = add_muscles(self._scene, self._links_of, self._spec, self._native.finish())
        # MuJoCo takes longer to list many geoms than to compile some
        if self._settings is not None:
            self._native.keep(self._settings, self._has_own_servos())
        elif len(self._owners) < FEW_GEOMS and len(self._spec.geoms) < FEW_GEOMS:
            self._spec.option.disableflags |= SAME_CONTACTS
        self._check_friction()
        model = compile_spec(self._spec)
        if model.ngeom >= MANY_GEOMS:
            _place_once(model)
        if self._native.without_friction is None:
            _damp_with_contacts(model, self._touching(model))
        if (
            self._firm and model.nv <= FEW_FREEDOMS and self._settings is None
        ):  # firm joints are constrained in each step
            _solve_at_once(model.opt)
        bodies = {name: [(body, part.id) for body, part in each] for name, each in self._bodies.items()}
        let_weigh_nothing(model, chain.from_iterable(bodies.values()))
        return Built(
            model,
            bodies,
            {name: dict(_freedoms(each, model)) for name, each in self._joints.items()},
            {path: (servo, [e.id for e in each]) for path, (servo, each) in self._drives.items()},
            {path: element.id for path, element in self._servos.items()},
            self._native.declared,
            self._firm,
            self._owners_of(model),
            {path: element.id for path, element in actuators.items()},
            {path: element.id for path, element in self._native.sensors.items()},
            self._native.warnings,
        )

    def _check_friction(self) -> None:
        """Move joints by gains if a file disables dry friction; refuse ball joints, which have no gains."""
        taker = self._native.without_friction
        if taker is None:
            return
        for (model, _), firm in self._firm.items():
            if firm.axis == 0:
                raise taker.error(
                    f"dry friction is disabled, by which MuJoCo leads the ball joint '{firm.joint.name}' of "
                    f"'{model}': enable <flag frictionloss> and <flag constraint>, or do not control it"
                )
        self._firm.clear()

    def _add_model(self, model: Model) -> None:
        # a step of 0 s leaves springs undamped
        step_s = self._spec.option.timestep if self._settings is None else 0.0
        bodies = simulated_bodies(model, step_s, self._physical)
        self._collisions, self._links = {}, {}
        self._links_of[model.name] = self._links
        elements: list[Any] = []
        joints: dict[str, Any] = {}
        for index, body in enumerate(bodies):
            elements.append(self._add_body(model.name, index, bodies, elements))
            if body.joint is not None and body.joint.kind != "fixed":
                joints[body.joint.name] = add_joint(
                    elements[-1], f"{model.name}/{body.joint.name}", body.joint, self._stiff
                )
        self._bodies[model.name] = list(zip(bodies, elements, strict=True))
        self._joints[model.name] = [(j, joints[j.name]) for j in model.joints if j.name in joints]
        self._couple(model, joints)
        for drive in planar_drives(model):
            servo = servo_of(model, drive, bodies, self._scene.gravity, self._physical)
            actuators = self._add_servo(f"{model.name}/{drive.name}", servo, elements[servo.body], joints)
            self._drives[model.name, drive.name] = servo, actuators
        for name in servoed_joints(model):
            if name in joints and model.joint(name).takes_commands:
                limit = model.joint(name).effort
                self._servos[model.name, name] = self._add_joint_servo(joints[name], limit)
        close_loops(model, self._links, self._spec)
        self._native.apply(BuiltParts(model, self._links, joints, self._collisions))
        self._separate(model, bodies, elements)
        armatures = {name: float(joint.armature) for name, joint in joints.items()}
        for name, firm in firm_joints(model, bodies, armatures).items():
            joints[firm.joint.name].solimp_friction = FIRMEST
            # what sleeps has no constraints, and a target wakes nothing
            _root_of(joints[firm.joint.name]).sleep = mujoco.mjtSleepPolicy.mjSLEEP_NEVER
            self._firm[model.name, name] = firm

    def _has_own_servos(self) -> bool:
        """Return whether all servos have the gains of the file, with which its integrator is stable."""
        servos = [
            ((model.name, each.joint), (0.0, gains.p) if each.kind == "velocity" else (gains.p, gains.d))
            for model in self._scene.models
            for each in model.controllers
            if each.kind != "effort" and (gains := each.gains) is not None
        ]
        return all(gains in self._native.declared.get(path, ()) for path, gains in servos)

    def _touching(self, model: Any) -> Iterator[int]:
        """Yield the degrees of freedom of models with contacts, without those of MJCF models."""
        for part in self._scene.models:
            if not part.native and any(link.collisions for link in part.links):
                for name, dof in _freedoms(self._joints[part.name], model):
                    if (part.name, name) not in self._firm:
                        yield dof

    def _owners_of(self, model: Any) -> Sequence[BodyPath]:
        owners = [("", 0)] * model.ngeom
        for path, element in self._owners:
            owners[element.id] = path
        return owners

    def _add_body(self, model: str, index: int, bodies: Sequence[Body], elements: Sequence[Any]) -> Any:
        body = bodies[index]
        if body.fixed and len(bodies) == 1:
            element, frame = self._spec.worldbody, body.pose  # geoms of the world body are the cheapest
        else:
            parent = self._spec.worldbody if body.parent is None else elements[body.parent]
            element, frame = (
                parent.add_body(name=f"{model}/{body.name}", **pos_quat(body.pose)),
                Pose(),
            )
        if body.inertial is not None:
            pulled, weightless = body.pulled, body.weightless
            element.gravcomp = float(pulled is None)
            if pulled is not None and weightless is not None:  # each has a centre of its own
                _set_inertial(element, pulled)
                lifted = element.add_body(name=f"{model}/{body.name}/weightless", gravcomp=1)
                _set_inertial(lifted, weightless)
            else:
                _set_inertial(element, body.inertial)
        if body.floats:
            element.add_freejoint(name=f"{model}/{body.name}/{FREE}")
        for link in body.links:
            self._add_link((model, index), element, link, frame @ link.pose)
        return element

    def _add_link(self, owner: BodyPath, element: Any, link: Link, place: Pose) -> None:
        model, _ = owner
        self._links[link.name] = element, place
        for collision in link.collisions:
            name = f"{model}/{link.name}/{collision.name}"
            geoms = self._shapes.add_collision(element, collision, place, name)
            self._collisions.setdefault(link.name, []).extend(geoms)
            self._owners += [(owner, geom) for geom in geoms]

    def _add_servo(self, path: str, servo: PlanarServo, body: Any, joints: Mapping[str, Any]) -> list[Any]:
        kinds = mujoco.mjtTrn
        actuators = []
        for number, (point, gear) in enumerate(zip(servo.points, (AHEAD, AHEAD, ASIDE, ASIDE), strict=True)):
            site = body.add_site(name=f"{path}/{number}", pos=point)
            actuator = self._spec.add_actuator(target=site.name, trntype=kinds.mjTRN_SITE, gear=gear)
            _set_velocity_servo(actuator, servo.gain, servo.limit)
            actuators.append(actuator)
        for wheel in servo.wheels:
            actuator = self._spec.add_actuator(target=joints[wheel.joint].name, trntype=kinds.mjTRN_JOINT)
            _set_velocity_servo(actuator, wheel.gain, wheel.limit)
            actuators.append(actuator)
        return actuators

    def _add_joint_servo(self, joint: Any, limit: float) -> Any:
        """Add an actuator whose gains are set with each target."""
        actuator = self._spec.add_actuator(target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        _set_velocity_servo(actuator, SMALLEST, limit)
        actuator.gainprm[0] = 1.0  # the control is an effort
        return actuator

    def _couple(self, model: Model, joints: Mapping[str, Any]) -> None:
        """Couple joints to the joints that they mimic."""
        for joint in model.joints:
            if joint.mimic is not None and joint.name in joints:
                polynomial = [joint.mimic.offset, joint.mimic.multiplier]
                self._spec.add_equality(
                    type=mujoco.mjtEq.mjEQ_JOINT,
                    objtype=mujoco.mjtObj.mjOBJ_JOINT,
                    name1=joints[joint.name].name,
                    name2=joints[joint.mimic.leader].name,
                    data=[*polynomial, *[0.0] * (mujoco.mjNEQDATA - len(polynomial))],
                    solref=self._stiff,
                    solimp=HARD,
                )

    def _separate(self, model: Model, bodies: Sequence[Body], elements: Sequence[Any]) -> None:
        """Exclude contacts between the parts of a model, or only of neighbours if it may touch itself.

        In MuJoCo a base that the file fixes to the world touches its neighbours. One that an experiment fixes
        does not, as if it were free.
        """
        pairs = list(combinations(range(len(bodies)), 2))
        if touches_itself(model):
            filters = not self._spec.option.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT
            kept = any(joint.name == HELD for joint in model.joints)
            near = neighbours(bodies) if filters else ()
            pairs = [(one, by) for one, by, seen in near if kept or not (seen or bodies[by].fixed)]
        for pair in pairs:
            one, other = (elements[index] for index in pair)
            if self._spec.worldbody not in (one, other):
                self._spec.add_exclude(bodyname1=one.name, bodyname2=other.name)


def _set_inertial(element: Any, inertial: Inertial) -> None:
    element.explicitinertial = True
    element.mass = inertial.mass
    element.inertia = _not_too_flat(inertial.inertia[:3])
    element.ipos = inertial.pose.position
    element.iquat = scalar_first(inertial.pose.orientation)


def _not_too_flat(moments: Sequence[float]) -> list[float]:
    """Raise the smaller moments of a flat body by the rounding for which MuJoCo would refuse them."""
    largest = max(range(3), key=moments.__getitem__)
    lacking = 2 * moments[largest] - sum(moments) + 8 * float_info.epsilon * moments[largest]
    raised = max(lacking, 0.0) / 2
    return [moment if i == largest else moment + raised for i, moment in enumerate(moments)]


def _freedoms(joints: Sequence[tuple[Joint, Any]], model: Any) -> Iterator[tuple[str, int]]:
    """Yield the coordinates of joints, each with its degree of freedom."""
    for joint, element in joints:
        first = int(model.jnt_dofadr[element.id])
        yield from zip(joint.coordinates, count(first))


def _damp_with_contacts(model: Any, dofs: Iterable[int]) -> None:
    """Make strong dampers constraints of the same force, so that contacts are computed with them.

    MuJoCo integrates dampers implicitly, but computes the forces of constraints as if there were none. With a
    damper ``D``, for which ``h D`` exceeds the inertia that it moves, contacts are far too weak, and a robot
    falls that stands with fixed joints. A constraint of friction without a limit has a force ``f`` with
    ``R f = -b v - a``, which for ``R = 1 / (h D)`` and ``b = 1 / h`` is ``f = -D (v + h a)``: the damper at
    the end of the step. In MuJoCo ``R`` is the inverse inertia times ``(1 - d) / d``, and ``b`` is
    ``-solref[1] / d``.
    """
    for dof in dofs:
        mobility, damping = float(model.dof_invweight0[dof]), float(model.dof_damping[dof])
        share = model.opt.timestep * damping * mobility
        if share > STRONG and not model.dof_frictionloss[dof]:
            d = min(share / (1 + share), MAX_IMPEDANCE)
            model.dof_damping[dof], model.dof_frictionloss[dof] = 0.0, FAR_AWAY
            model.dof_solref[dof] = -1.0, -d / model.opt.timestep
            model.dof_solimp[dof, :2] = d


def _solve_at_once(option: Any) -> None:
    """Solve all constraints together; sleeping bodies need islands of connected constraints."""
    if not option.enableflags & mujoco.mjtEnableBit.mjENBL_SLEEP:
        option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND


def _place_once(model: Any) -> None:
    """Compute poses of geoms that never move only once; MuJoCo does this where bodies may sleep."""
    option, sleep = model.opt, mujoco.mjtEnableBit.mjENBL_SLEEP
    if option.enableflags & sleep or option.disableflags & mujoco.mjtDisableBit.mjDSBL_ISLAND:
        return
    option.enableflags |= sleep
    model.tree_sleep_policy[:] = mujoco.mjtSleepPolicy.mjSLEEP_NEVER


def _root_of(joint: Any) -> Any:
    """Return the first body that moves, on the way from the world to a joint."""
    body = root = joint.parent
    while body is not None:
        root = body if body.joints else root
        body = body.parent
    return root


def _set_velocity_servo(actuator: Any, gain: float, limit: float) -> None:
    actuator.set_to_velocity(kv=gain)
    if isfinite(limit):
        limit = max(limit, SMALLEST)
        actuator.forcelimited = True
        actuator.forcerange = [-limit, limit]
