"""Forces that drives do not exert, and measurements: servos, efforts, wrenches, contacts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from math import ceil, log
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.small_matrices import product
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.model import Joint, Model, Scene
from nrp_core.scene.rigid import (
    BodyPath,
    JointStates,
    JointTargets,
    Pose,
    Quaternion,
    ServoTarget,
    Touch,
    Vector,
    Wrench,
)
from nrp_core.world.drives.muscles import muscles_of
from nrp_core.world.engine_kit.firm_joints import JointPath, firm_joints
from nrp_core.world.engine_kit.joint_servo import ExplicitServos, Stops, servoed_joints
from nrp_core.world.engine_kit.simulated import Decay
from nrp_core.world.engine_kit.soft_constraints import SoftConstraints, armatures_of, gains_of
from nrp_world_pybullet.build import FAR_AWAY, BodyHandle, Built
from nrp_world_pybullet.firm import BulletFirmJoints
from nrp_world_pybullet.inertia import Inertia
from nrp_world_pybullet.library import bullet
from nrp_world_pybullet.motion import JointReader, Moving
from nrp_world_pybullet.muscles import Muscles

USUAL: Final = 50
"""PyBullet's own number of iterations."""
_MOST: Final = 500
_LEFT: Final = 1e-6
"""The share of an error of a velocity that may be left after a step."""


def iterations_for(inertia: FloatArray) -> int:
    """Return the number of iterations for motors of joints.

    Args:
        inertia: the joint-space inertia that the motors move, ``(n, n)``.
    """
    try:
        coupling = np.linalg.inv(inertia)
        lower = np.tril(coupling)
        left = np.abs(np.linalg.eigvals(np.linalg.solve(lower, lower - coupling))).max()
    except np.linalg.LinAlgError:  # links without inertia
        return USUAL
    if not 0.0 < left < 1.0:
        return USUAL
    return min(max(USUAL, 2 * ceil(log(_LEFT) / log(left) / 2)), _MOST)


_CENTRE = Pose()
STRONG = 0.1
"""The share of a joint's velocity removed in a step above which a damper is strong."""


class Tree:
    """The joints of one multi-body, with servos and springs.

    PyBullet computes the forces of dampers at the start of a step, which is unstable if a damper removes much
    of a joint's velocity in a step. In such a tree, and in models with muscles, the servos replace all
    dampers. In models with muscles, where all other efforts are known, they also add the inertia of motors
    and the constraints of joints that MJCF describes.

    Args:
        joints: all movable joints with their handles, in PyBullet's order.
        model: their model.
        inertia: the inertia of the joints.
        client: the physics client.
        step_s: the physics step.
        muscles: the muscles of the scene.

    Attributes:
        has_muscles: whether the model has muscles.
        exact: whether the tree moves as in MuJoCo, with its constraints of joints and inertia of motors.
    """

    def __init__(
        self,
        joints: Sequence[tuple[Joint, BodyHandle]],
        model: Model,
        inertia: Inertia,
        client: int,
        step_s: float,
        muscles: Muscles,
    ) -> None:
        ways = [joint for joint, _ in joints for _ in joint.coordinates]
        self.paths = [(model.name, name) for joint, _ in joints for name in joint.coordinates]
        self._multibody, self._links = joints[0][1].multibody, [place.link for _, place in joints]
        self._inertia, self._client = inertia, client
        self._single = len(ways) == len(joints)
        self._stiffness, self._rest = np.array([(joint.stiffness, joint.rest) for joint in ways]).T
        dampers = np.array([joint.damping for joint in ways])
        self._muscles, self._columns = muscles, muscles.columns(self.paths)
        self.has_muscles = bool(muscles_of(model))
        self.strongly_damped = self.has_muscles or bool(self._share(dampers) * step_s > STRONG)
        if self.strongly_damped:
            for link in self._links:
                bullet.changeDynamics(self._multibody, link, jointDamping=0, physicsClientId=client)
        self._dampers = dampers.copy()
        self._link_of = [place.link for joint, place in joints for _ in joint.coordinates]
        self._undamped = set[int]()
        limits = [joint.effort for joint in ways]
        self.exact = self.has_muscles and not (inertia.floats and muscles.pull_at_world(model.name))
        motors = armatures_of(model) if self.exact else {}
        armatures = np.array([motors.get(joint.name, 0.0) for joint in ways])
        self._own_gains = gains_of(model) if self.exact else set()
        braked = dampers if self.strongly_damped else None
        self.servos = ExplicitServos(limits, step_s, braked, armatures, limits_first=self.exact)
        self._stops = self._soft_constraints(model, ways, armatures, step_s) if self.exact else None

    def _soft_constraints(
        self, model: Model, ways: Sequence[Joint], armatures: FloatArray, step_s: float
    ) -> Stops | None:
        """Replace PyBullet's hard limits and dry friction by those of MJCF."""
        inertia = self._inertia.now(np.zeros(len(ways))) + np.diag(armatures)
        constraints, client = SoftConstraints(ways, model, inertia, step_s), self._client
        for n in constraints.limited:
            far = {"jointLowerLimit": -FAR_AWAY, "jointUpperLimit": FAR_AWAY}
            bullet.changeDynamics(self._multibody, self._link_of[n], **far, physicsClientId=client)
        for n in constraints.rubbing:
            where, mode = (self._multibody, self._link_of[n]), bullet.VELOCITY_CONTROL
            bullet.setJointMotorControl2(*where, mode, force=0.0, physicsClientId=client)
        return constraints.push if constraints else None

    @property
    def sprung(self) -> bool:
        """Whether the model has springs."""
        return bool(self._stiffness.any())

    @property
    def idle(self) -> bool:
        """Whether they have no effect."""
        return self.servos.idle and not self.sprung and not self.has_muscles

    def damp(self, number: int, damped: bool) -> None:
        """Enable or disable the damper of a joint; a firm joint has none."""
        if damped == (number not in self._undamped):
            return
        self._undamped ^= {number}
        damping = float(self._dampers[number]) if damped else 0.0
        if self.strongly_damped:
            self.servos.set_damper(number, damping)
        else:
            link, client = self._link_of[number], self._client
            bullet.changeDynamics(self._multibody, link, jointDamping=damping, physicsClientId=client)

    def set_target(self, number: int, aim: ServoTarget) -> None:
        """Set the target of a joint's servo, which MuJoCo's own servos take at the start of a step."""
        own = (self.paths[number][1], aim.stiffness, aim.damping) in self._own_gains
        self.servos.set_target(number, aim, at_start=own)

    def push(self) -> tuple[FloatArray, FloatArray]:
        """Return the efforts of the servos, and those of dampers and springs, in the next step."""
        positions, velocities = np.array(self._states()).T
        springs = self._stiffness * (self._rest - positions)
        if self.servos.idle and not self.has_muscles:
            return np.zeros(len(springs)), springs
        known: FloatArray = springs
        viscosity: FloatArray | float = 0.0
        bias: FloatArray | None = None
        if self._columns is not None:
            pulls, damping = self._muscles.loads(self._columns)
            # MuJoCo's implicitfast leaves out the damping between branches of a tree
            known, viscosity = springs + pulls, damping * self._inertia.related
            springs = springs + self._muscles.wrapping_loads(self._columns)
        if self.exact:
            inertia, bias = self._inertia.dynamics(positions, velocities)
        else:
            inertia = self._inertia.now(positions)
        efforts = self.servos.push(positions, velocities, inertia, known, viscosity, bias, self._stops)
        return efforts, self.servos.braking + springs

    def drive(self, efforts: FloatArray) -> bool:
        """Apply efforts in one call and return True; with ball joints, return False."""
        if self._single:
            forces, mode, client = efforts.tolist(), bullet.TORQUE_CONTROL, self._client
            links = self._links
            bullet.setJointMotorControlArray(
                self._multibody, links, mode, forces=forces, physicsClientId=client
            )
        return self._single

    def _states(self) -> list[tuple[float, float]]:
        """Return position and velocity of each coordinate; the position of a ball joint is not needed."""
        if self._single:
            states = bullet.getJointStates(self._multibody, self._links, self._client)
            return [state[:2] for state in states]
        found = []
        for link in self._links:
            position, velocities = bullet.getJointStateMultiDof(self._multibody, link, self._client)[:2]
            found += [(position[0] if len(velocities) == 1 else 0.0, velocity) for velocity in velocities]
        return found

    def _share(self, dampers: FloatArray) -> float:
        """Return the rate at which dampers reduce a velocity, 1/s, with all joints at 0."""
        if not dampers.any():
            return 0.0
        inertia = self._inertia.now(np.zeros(len(dampers)))
        return float(abs(np.linalg.eigvals(np.linalg.solve(inertia, np.diag(dampers)))).max())


class Control:
    """Forces in one scene; PyBullet forgets them after each step, so they are set before each.

    Args:
        built: the scene.
        scene: the same as data.
        readers: the readers of the joints of each model.
        muscles: the muscles of the scene.
        client: the physics client.
        step_s: the physics step.
    """

    def __init__(
        self,
        built: Built,
        scene: Scene,
        readers: Mapping[str, JointReader],
        muscles: Muscles,
        client: int,
        step_s: float,
    ) -> None:
        self._built, self._client, self._step_s = built, client, step_s
        self._muscles = muscles
        self._iterations = USUAL
        self._trees = [tree for model in scene.models for tree in self._trees_of(model)]
        self._firm = [firm for model in scene.models for firm in self._firm_of(model, readers)]
        self._firm_by_path = {path: firm for firm in self._firm for path in firm.paths}
        self._numbers = {path: (tree, n) for tree in self._trees for n, path in enumerate(tree.paths)}
        self._efforts: dict[JointPath, float] = {}
        self._wrenches: dict[BodyPath, Wrench] = {}
        self._applied: dict[JointPath, float] = {}  # to joints outside of the trees that follow
        self._pushed: list[tuple[Tree, FloatArray]] = []
        self._lifts = list(self._lifts_of(scene.gravity))
        places = [each for bodies in built.bodies.values() for each in bodies]
        decays = [(body, place, Decay.of(body, step_s)) for body, place in places]
        self._decays = [(body, place, decay) for body, place, decay in decays if decay is not None]

    def _lifts_of(self, gravity: Vector) -> Iterator[tuple[BodyHandle, Wrench, Pose]]:
        """Yield the bodies that gravity does not pull, or not in full, with the forces that hold them.

        The last are the centres of the masses that it does not pull, relative to the bodies' centres of mass.
        """
        for body, place in (each for bodies in self._built.bodies.values() for each in bodies):
            if body.inertial is not None and (lifted := body.weightless):
                x, y, z = (-lifted.mass * part for part in gravity)
                yield place, Wrench((x, y, z)), body.inertial.pose.inverse() @ Pose(lifted.pose.position)

    def _trees_of(self, model: Model) -> Iterator[Tree]:
        """Yield the trees of a model with servos, springs, muscles or strong dampers."""
        places, bodies = self._built.joints[model.name], self._built.bodies[model.name]
        movable = [(body.joint, place) for body, place in bodies if body.joint and body.joint.coordinates]
        led = set(servoed_joints(model))
        servoed = {place.multibody for body, place in bodies if body.joint and body.joint.name in led}
        for multibody in sorted({place.multibody for place in places.values()}):
            joints = [(joint, place) for joint, place in movable if place.multibody == multibody]
            joints.sort(key=lambda each: each[1].link)
            inertia = Inertia(bodies, multibody, self._client)
            tree = Tree(joints, model, inertia, self._client, self._step_s, self._muscles)
            if multibody in servoed or tree.strongly_damped or tree.sprung:
                yield tree

    def exact_joints(self, model: str) -> list[str]:
        """Return the coordinates of a model in trees that move as in MuJoCo."""
        return [name for tree in self._trees if tree.exact for owner, name in tree.paths if owner == model]

    def _firm_of(self, model: Model, readers: Mapping[str, JointReader]) -> Iterator[BulletFirmJoints]:
        """Yield the firm joints of each multi-body of a model."""
        places = self._built.joints[model.name]
        found = firm_joints(model, [body for body, _ in self._built.bodies[model.name]])
        for multibody in sorted({places[name].multibody for name in found}):
            own = {name: firm for name, firm in found.items() if places[name].multibody == multibody}
            joints = {(model.name, name): (firm, places[name]) for name, firm in own.items()}
            self._settle(self._iterations_of(model, multibody))
            yield BulletFirmJoints(joints, readers[model.name], self._client, self._step_s)

    def _iterations_of(self, model: Model, multibody: int) -> int:
        """Return the number of iterations for the motors of a multi-body, at its positions now."""
        places = self._built.joints[model.name].values()
        links = sorted({place.link for place in places if place.multibody == multibody})
        states = bullet.getJointStates(multibody, links, self._client)
        inertia = Inertia(self._built.bodies[model.name], multibody, self._client)
        return iterations_for(inertia.now(np.array([state[0] for state in states])))

    def _settle(self, iterations: int) -> None:
        """Set the least number of iterations of PyBullet's solver; it stops earlier when it has converged."""
        if iterations > self._iterations:
            self._iterations = iterations
            bullet.setPhysicsEngineParameter(numSolverIterations=iterations, physicsClientId=self._client)

    def add_efforts(self, model: str, states: JointStates) -> None:
        """Add the efforts of the last step to the states of a model's joints."""
        for (owner, joint), effort in self._all_applied().items():
            if owner == model:
                states.efforts[states.names.index(joint)] += effort
        for firm in self._firm:
            firm.add_efforts(model, states)

    def set_target(self, model: str, joint: str, aim: ServoTarget) -> None:
        """Set the target of a joint's servo."""
        path = model, joint
        if path in self._firm_by_path and self._firm_by_path[path].set_target(path, aim):
            return
        tree, number = self._numbers[path]
        tree.damp(number, aim.firm is None)
        tree.set_target(number, ServoTarget() if aim.firm is not None else aim)

    def orient(self, model: str, joint: str, orientation: Quaternion | None) -> None:
        """Lead a ball joint to an orientation, or release it."""
        for axis in "xyz":
            tree, number = self._numbers[model, f"{joint}_{axis}"]
            tree.damp(number, orientation is None)
        self._firm_by_path[model, f"{joint}_x"].orient(model, joint, orientation)

    def retarget(self, model: str, targets: JointTargets) -> bool:
        """Change the targets of firm joints of one multi-body, if all have one; return whether all do."""
        firm = self._firm_by_path.get((model, targets.joints[0]))
        return firm is not None and firm.retarget(model, targets)

    def set_effort(self, model: str, joint: str, effort: float) -> None:
        """Apply an effort to a joint."""
        self._efforts[model, joint] = effort
        if not effort:
            del self._efforts[model, joint]

    def set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        """Apply a wrench to a body."""
        self._wrenches[body] = wrench
        if wrench == Wrench():
            del self._wrenches[body]

    def pushes(self) -> list[Callable[[], None]]:
        """Return the functions that set a step's forces; call them before each until a target changes."""
        trees = [tree for tree in self._trees if not tree.idle]
        self._applied, self._pushed = {}, []
        found: list[Callable[[], None]] = [partial(self._push, trees)] if trees or self._efforts else []
        found += [firm.step for firm in self._firm if firm.active]
        return [*found, self._pull_all] if self._wrenches or self._lifts or self._decays else found

    def _push(self, trees: Sequence[Tree]) -> None:
        """Apply the efforts of joints, and those of trees of joints with servos, springs or dampers."""
        joints, self._pushed = self._built.joints, []
        self._applied = dict(self._efforts)
        for tree in trees:
            efforts, brakes = tree.push()
            if self._applied:
                efforts = efforts + [self._applied.pop(path, 0.0) for path in tree.paths]
            self._pushed.append((tree, efforts))
            total = efforts + brakes
            if not tree.drive(total):
                places = [joints[model][name] for model, name in tree.paths]
                self._drive(zip(places, total.tolist(), strict=True))
        self._drive((joints[model][name], effort) for (model, name), effort in self._applied.items())

    def _all_applied(self) -> dict[JointPath, float]:
        """Return the efforts of the last step, without dampers and springs of trees."""
        found = dict(self._applied)
        for tree, efforts in self._pushed:
            found |= zip(tree.paths, efforts.tolist(), strict=True)
        return found

    def _pull_all(self) -> None:
        """Apply the wrenches on bodies."""
        for (model, index), wrench in self._wrenches.items():
            _, place = self._built.bodies[model][index]
            self._pull(place, wrench)
        for lift in self._lifts:
            self._pull(*lift)
        for _, place, decay in self._decays:
            motion = Moving(place, Pose(), self._client)()  # of its centre of mass and principal axes
            self._pull(place, decay.wrench(motion.pose, motion.linear, motion.angular))

    def _drive(self, efforts: Iterable[tuple[BodyHandle, float]]) -> None:
        """Apply efforts to joints, those of a multi-body in one call."""
        mode, client = bullet.TORQUE_CONTROL, self._client
        trees: dict[int, tuple[list[int], list[float]]] = {}
        for place, effort in efforts:
            if place.axis is None:
                links, forces = trees.setdefault(place.multibody, ([], []))
                links.append(place.link)
                forces.append(effort)
            else:
                where, torque = (place.multibody, place.link), [0.0, 0.0, 0.0]
                torque[place.axis] = effort
                bullet.setJointMotorControlMultiDof(*where, mode, force=torque, physicsClientId=client)
        for multibody, (links, forces) in trees.items():
            bullet.setJointMotorControlArray(multibody, links, mode, forces=forces, physicsClientId=client)

    def _pull(self, place: BodyHandle, wrench: Wrench, at: Pose = _CENTRE) -> None:
        """Apply a wrench at a place relative to a body's centre of mass and principal axes."""
        where, client = (place.multibody, place.link), self._client
        point, _ = Moving(place, at, client).place()
        bullet.applyExternalForce(*where, wrench.force, point, bullet.WORLD_FRAME, physicsClientId=client)
        bullet.applyExternalTorque(*where, wrench.torque, bullet.WORLD_FRAME, physicsClientId=client)

    def touches(self) -> Iterator[Touch]:
        """Return the contacts of the last step."""
        owners = self._built.owners
        for contact in bullet.getContactPoints(physicsClientId=self._client):
            one, other = owners[contact[1], contact[3]], owners[contact[2], contact[4]]
            distance, pressure = contact[8], contact[9]
            if one[0] == other[0] or pressure <= 0.0:
                continue
            (ax, ay, az), (bx, by, bz), normal = contact[5], contact[6], contact[7]
            force = np.multiply(pressure, normal)
            force += np.multiply(contact[10], contact[11]) + np.multiply(contact[12], contact[13])
            fx, fy, fz = force.tolist()
            position = (ax + bx) / 2, (ay + by) / 2, (az + bz) / 2
            yield Touch((one, other), position, normal, -distance, (fx, fy, fz))

    def save(self) -> object:
        """Return the state that is kept between steps."""
        firm = [each.save() for each in self._firm]
        return [tree.servos.save() for tree in self._trees], firm, self._all_applied()

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        servos, firm, applied = saved
        self._applied, self._pushed = dict(applied), []
        for tree, kept in zip(self._trees, servos, strict=True):
            tree.servos.restore(kept)
        for each, paths in zip(self._firm, firm, strict=True):
            each.restore(paths)
            for tree, number in (self._numbers[each.paths[on]] for on in each.on.tolist()):
                tree.damp(number, False)

    def forget(self, model: str) -> None:
        """Forget the last motion of a model's joints, because they were moved from outside."""
        for tree in self._trees:
            if tree.paths[0][0] == model:
                tree.servos.forget()
        for firm in self._firm:
            firm.forget(model)

    def joint_wrench(self, body: Body, place: BodyHandle) -> Wrench:
        """Return the wrench of a body on its parent in the last step, at the body's origin.

        PyBullet reports the wrench of the joint on the body, at its centre of mass and along its inertial
        axes, without the motor, which is friction.
        """
        assert body.inertial is not None
        assert body.joint is not None
        state = bullet.getJointStateMultiDof(place.multibody, place.link, self._client)
        reaction, moment = np.array(state[2][:3]), np.array(state[2][3:])
        x, y, z = state[3] if body.joint.kind == "ball" else np.multiply(state[3][:1] or 0.0, body.joint.axis)
        friction = np.array(body.inertial.pose.rotate_back((x, y, z)))
        if body.joint.kind == "prismatic":
            reaction += friction
        else:
            moment += friction
        _, orientation = bullet.getLinkState(place.multibody, place.link, 0, 1, self._client)[:2]
        turn = np.reshape(bullet.getMatrixFromQuaternion(orientation), (3, 3))
        force, torque = product(turn, reaction), product(turn, moment)
        to_origin = product(turn, np.array(body.inertial.pose.inverse().position))
        torque = torque - np.cross(to_origin, force)
        fx, fy, fz = (-force).tolist()
        tx, ty, tz = (-torque).tolist()
        return Wrench((fx, fy, fz), (tx, ty, tz))
