"""What acts on bodies and joints beside drives, and what is felt: servos, efforts, wrenches, contacts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from nrp_core.world.engine import FloatArray
from nrp_core.world.parts.base import BodyPath, JointAim, Touch, Wrench
from nrp_core.world.physics.bodies import Body
from nrp_core.world.physics.joint_servo import ExplicitServos, servoed_joints
from nrp_core.world.scene.model import Joint, Model, Scene
from nrp_core.world.scene.pose import Pose
from nrp_world_pybullet.build import Built, Place
from nrp_world_pybullet.engine import bullet
from nrp_world_pybullet.motion import Moving

JointPath = tuple[str, str]

STRONG = 0.1
"""The share of a joint's velocity that a damper takes away in a step, from which on it is strong."""


class Tree:
    """The joints of one multi-body, with servos.

    PyBullet takes the forces of dampers at the start of a step: where one takes away much of a joint's
    velocity in a step, the joints shake to pieces. There the servos do what all dampers of the tree do.

    Args:
        joints: all movable ones, in PyBullet's order.
        model: the name of their model.
        places: theirs.
        floats: whether the base does.
        client: the physics client.
        step_s: the physics step.
    """

    def __init__(
        self,
        joints: Sequence[Joint],
        model: str,
        places: Sequence[Place],
        floats: bool,
        client: int,
        step_s: float,
    ) -> None:
        self.paths = [(model, joint.name) for joint in joints]
        self._multibody, self._links = places[0].multibody, [place.link for place in places]
        self._base, self._client = 6 if floats else 0, client
        dampers = np.array([joint.damping for joint in joints])
        self.strongly_damped = bool(self._share(dampers) * step_s > STRONG)
        if self.strongly_damped:
            for link in self._links:
                bullet.changeDynamics(self._multibody, link, jointDamping=0, physicsClientId=client)
        limits = [joint.effort for joint in joints]
        self.servos = ExplicitServos(limits, step_s, dampers if self.strongly_damped else None)

    def push(self) -> tuple[Mapping[JointPath, float], Mapping[JointPath, float]]:
        """Return the efforts of the next step: of the servos, and of the dampers."""
        states = bullet.getJointStates(self._multibody, self._links, self._client)
        positions, velocities = np.array([state[:2] for state in states]).T
        efforts = self.servos.push(positions, velocities, self._inertia(positions))
        braking = self._by_path(self.servos.braking) if self.strongly_damped else {}
        return self._by_path(efforts), braking

    def _by_path(self, efforts: FloatArray) -> Mapping[JointPath, float]:
        return dict(zip(self.paths, efforts.tolist(), strict=True))

    def _inertia(self, positions: FloatArray) -> FloatArray:
        """Return the inertia of the joints against each other, the base following freely."""
        where = positions.tolist()
        mass = np.array(bullet.calculateMassMatrix(self._multibody, where, physicsClientId=self._client))
        n = self._base
        inertia: FloatArray = mass[n:, n:]
        if n:  # what the base yields
            inertia = inertia - mass[n:, :n] @ np.linalg.solve(mass[:n, :n], mass[:n, n:])
        return inertia

    def _share(self, dampers: FloatArray) -> float:
        """Return which share of a velocity the dampers take away in a second, with all joints at 0."""
        if not dampers.any():
            return 0.0
        inertia = self._inertia(np.zeros(len(dampers)))
        return float(abs(np.linalg.eigvals(np.linalg.solve(inertia, np.diag(dampers)))).max())


class Control:
    """Forces in one scene; PyBullet forgets them after each step, so they are set before each.

    Args:
        built: the scene.
        scene: the same as data.
        client: the physics client.
        step_s: the physics step.
    """

    def __init__(self, built: Built, scene: Scene, client: int, step_s: float) -> None:
        self._built, self._client, self._step_s = built, client, step_s
        self._trees = [tree for model in scene.models for tree in self._trees_of(model)]
        self._numbers = {path: (tree, n) for tree in self._trees for n, path in enumerate(tree.paths)}
        self._efforts: dict[JointPath, float] = {}
        self._wrenches: dict[BodyPath, Wrench] = {}
        self._applied: dict[JointPath, float] = {}

    def _trees_of(self, model: Model) -> Iterator[Tree]:
        """Yield the trees of a model that have something to do."""
        places = self._built.joints[model.name]
        told = {body.joint.name: body.joint for body, _ in self._built.bodies[model.name] if body.joint}
        floating = {place.multibody for body, place in self._built.bodies[model.name] if body.floats}
        servoed = {places[name].multibody for name in servoed_joints(model) if name in places}
        for multibody in sorted({place.multibody for place in places.values()}):
            names = sorted(
                (name for name, place in places.items() if place.multibody == multibody),
                key=lambda name: places[name].link,
            )
            joints, where = [told[name] for name in names], [places[name] for name in names]
            tree = Tree(joints, model.name, where, multibody in floating, self._client, self._step_s)
            if multibody in servoed or tree.strongly_damped:
                yield tree

    @property
    def active(self) -> bool:
        """Whether anything is to be set before each step."""
        return bool(self._efforts or self._wrenches or any(not tree.servos.idle for tree in self._trees))

    @property
    def applied(self) -> Mapping[JointPath, float]:
        """The efforts of the last step."""
        return self._applied

    def aim(self, model: str, joint: str, aim: JointAim) -> None:
        """Let the servo of a joint aim at something."""
        tree, number = self._numbers[model, joint]
        tree.servos.aim(number, aim)

    def set_effort(self, model: str, joint: str, effort: float) -> None:
        """Put an effort on a joint."""
        self._efforts[model, joint] = effort
        if not effort:
            del self._efforts[model, joint]

    def set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        """Let a wrench act on a body."""
        self._wrenches[body] = wrench
        if wrench == Wrench():
            del self._wrenches[body]

    def push(self) -> None:
        """Set the forces of the next step."""
        client, joints = self._client, self._built.joints
        self._applied = dict(self._efforts)
        braking: dict[JointPath, float] = {}
        for tree in self._trees:
            if not tree.servos.idle:
                efforts, brakes = tree.push()
                braking |= brakes
                for path, effort in efforts.items():
                    self._applied[path] = self._efforts.get(path, 0.0) + effort
        for path, effort in self._applied.items():
            (model, joint), force = path, effort + braking.get(path, 0.0)
            place = joints[model][joint]
            bullet.setJointMotorControl2(
                place.multibody, place.link, bullet.TORQUE_CONTROL, force=force, physicsClientId=client
            )
        for (model, index), wrench in self._wrenches.items():
            self._pull(*self._built.bodies[model][index], wrench)

    def _pull(self, body: Body, place: Place, wrench: Wrench) -> None:
        where, client = (place.multibody, place.link), self._client
        point, _ = Moving(place, Pose(), client).place()
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
        """Return what is kept between steps."""
        return [tree.servos.save() for tree in self._trees], dict(self._applied)

    def restore(self, saved: Any) -> None:
        """Return to what :meth:`save` gave."""
        servos, applied = saved
        self._applied = dict(applied)
        for tree, kept in zip(self._trees, servos, strict=True):
            tree.servos.restore(kept)

    def forget(self, model: str) -> None:
        """Forget how the joints of a model moved, because they were put elsewhere."""
        for tree in self._trees:
            if tree.paths[0][0] == model:
                tree.servos.forget()

    def joint_wrench(self, body: Body, place: Place) -> Wrench:
        """Return what a body did to its parent in the last step, at the body's origin.

        PyBullet tells what the joint does to the body, at its centre of mass and along its inertial axes, but
        for what its motor does, which is friction.
        """
        assert body.inertial is not None
        assert body.joint is not None
        state = bullet.getJointState(place.multibody, place.link, self._client)
        reaction, moment = np.array(state[2][:3]), np.array(state[2][3:])
        friction = state[3] * np.array(body.inertial.pose.rotate_back(body.joint.axis))
        if body.joint.kind == "prismatic":
            reaction += friction
        else:
            moment += friction
        _, orientation = bullet.getLinkState(place.multibody, place.link, 0, 1, self._client)[:2]
        turn = np.reshape(bullet.getMatrixFromQuaternion(orientation), (3, 3))
        force, torque = turn @ reaction, turn @ moment
        to_origin = turn @ np.array(body.inertial.pose.inverse().position)
        torque = torque - np.cross(to_origin, force)
        fx, fy, fz = (-force).tolist()
        tx, ty, tz = (-torque).tolist()
        return Wrench((fx, fy, fz), (tx, ty, tz))
