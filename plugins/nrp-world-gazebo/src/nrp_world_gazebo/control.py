"""Forces that drives do not exert, and measurements: servos, efforts, wrenches, contacts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from nrp_core.scene.merged_bodies import Body, joint_inertias
from nrp_core.world import (
    BodyPath,
    FloatArray,
    Model,
    Quaternion,
    Scene,
    ServoTarget,
    Touch,
    Vector,
    Wrench,
)
from nrp_core.world.engine_kit.firm_joints import FirmJoints, firm_joints
from nrp_core.world.engine_kit.firm_kinds import FREE
from nrp_core.world.engine_kit.joint_servo import ExplicitServos, servoed_joints
from nrp_world_gazebo.build import BodyHandle, Built
from nrp_world_gazebo.drive import STRONG
from nrp_world_gazebo.motion import motion_of
from nrp_world_gazebo.wire import contacts, operation


class GazeboFirmJoints(FirmJoints):
    """The firm joints of a scene: motors of ODE, which are constraints with a bounded force."""

    def __init__(self, built: Built, scene: Scene, step_s: float) -> None:
        self._gazebo = built.gazebo
        found = [
            ((model.name, name), firm, built.joints[model.name][name].number)
            for model in scene.models
            for name, firm in firm_joints(model, [body for body, _ in built.bodies[model.name]]).items()
        ]
        super().__init__({path: firm for path, firm, _ in found}, step_s)
        self._joints = np.array([number for _, _, number in found], dtype=int)
        self._limits = [min(firm.joint.effort, STRONG) for _, firm, _ in found]

    def _do_step(self, steps: int) -> None:
        self._gazebo.refresh()
        positions, velocities, _ = self._gazebo.joints[self._joints].T
        if self.servos.moving:
            self.servos.step(positions, velocities)
        wanted = self.servos.velocities(positions)
        for number in self.on.tolist():
            self._set(number, float(wanted[number]))

    def _do_efforts(self) -> FloatArray:
        self._gazebo.refresh()
        efforts: FloatArray = np.where(self.servos.kinds == FREE, 0.0, self._gazebo.joints[self._joints, 2])
        return efforts

    def _do_select(self, number: int) -> None:
        if self.servos.kinds[number] == FREE:
            self._gazebo.do(operation("m", int(self._joints[number]), values=(0, 1, 0)))

    def _set(self, number: int, velocity: float) -> None:
        row = (velocity, 1.0, self._limits[number])
        self._gazebo.do(operation("m", int(self._joints[number]), values=row))


class Tree:
    """The joints of one model, with servos.

    Args:
        built: the scene.
        model: the model.
        step_s: the physics step.
    """

    def __init__(self, built: Built, model: Model, step_s: float) -> None:
        self._gazebo, places = built.gazebo, built.joints[model.name]
        bodies = [body for body, _ in built.bodies[model.name]]
        inertias = joint_inertias(bodies) if servoed_joints(model) else {}
        self._inertia = np.diag([inertias.get(name, 1.0) for name in places])
        self._places = {name: (index, place.number) for index, (name, place) in enumerate(places.items())}
        self._numbers = np.array([place.number for place in places.values()], dtype=int)
        self._given = np.zeros(len(places))
        self._sent = np.zeros(len(places))
        self.servos = ExplicitServos([place.joint.effort for place in places.values()], step_s)

    def set_target(self, joint: str, aim: ServoTarget) -> None:
        """Set the target of a joint."""
        self.servos.set_target(self._places[joint][0], aim)
        if self.servos.idle:
            self._send(self._given)

    def set_effort(self, joint: str, effort: float) -> None:
        """Apply an effort to a joint, in addition to its servo."""
        self._given[self._places[joint][0]] = effort
        if self.servos.idle:
            self._send(self._given)

    def push(self) -> None:
        """Set the efforts of the next step."""
        self._gazebo.refresh()
        positions, velocities, _ = self._gazebo.joints[self._numbers].T
        self._send(self.servos.push(positions, velocities, self._inertia) + self._given)

    def _send(self, efforts: FloatArray) -> None:
        for index in np.flatnonzero(efforts != self._sent).tolist():
            self._gazebo.do(operation("e", int(self._numbers[index]), values=(efforts[index],)))
        self._sent = efforts.copy()


class Control:
    """Forces in one scene.

    Args:
        built: the scene.
        scene: the same as data.
        step_s: the physics step.
    """

    def __init__(self, built: Built, scene: Scene, step_s: float) -> None:
        self._built, self._gazebo = built, built.gazebo
        self.firm = GazeboFirmJoints(built, scene, step_s)
        self._firm = set(self.firm.paths)
        self._trees = {model.name: Tree(built, model, step_s) for model in scene.models}
        self._moving = [tree for name, tree in self._trees.items() if built.joints[name]]
        self._lifts = dict(self._lifts_of(scene.gravity))
        for path in self._lifts:
            self.set_wrench(path, Wrench())

    def _lifts_of(self, gravity: Vector) -> Iterator[tuple[BodyPath, Wrench]]:
        """Yield the forces that hold bodies which gravity does not pull, or not in full.

        Gazebo reads from a user's own file which links have no gravity. The forces act at the centre of the
        whole body, which differs from that of the lifted part where links were merged.
        """
        for model, bodies in self._built.bodies.items():
            if model in self._built.own:
                continue
            for index, (body, _) in enumerate(bodies):
                if body.inertial is not None and (lifted := body.weightless):
                    x, y, z = (-lifted.mass * part for part in gravity)
                    yield (model, index), Wrench((x, y, z))

    @property
    def active(self) -> bool:
        """Whether efforts must be computed before each step."""
        return self.firm.active or any(not tree.servos.idle for tree in self._moving)

    def push(self) -> None:
        """Set the efforts of the next step."""
        if self.firm.active:
            self.firm.step()
        for tree in self._moving:
            if not tree.servos.idle:
                tree.push()

    def set_target(self, model: str, joint: str, aim: ServoTarget) -> None:
        """Set the target of a joint's servo."""
        if (model, joint) in self._firm:
            self.firm.set_target((model, joint), aim)
        self._trees[model].set_target(joint, ServoTarget() if aim.firm is not None else aim)

    def orient(self, model: str, joint: str, orientation: Quaternion | None) -> None:
        raise AssertionError(f"Gazebo has no ball joints, such as '{model}/{joint}'")  # refused before

    def set_effort(self, model: str, joint: str, effort: float) -> None:
        """Apply an effort to a joint."""
        self._trees[model].set_effort(joint, effort)

    def forget(self, model: str) -> None:
        """Forget the last motion of a model's joints, because they were moved from outside."""
        self.firm.forget(model)
        self._trees[model].servos.forget()

    def save(self) -> object:
        """Return the state that is kept between steps."""
        return self.firm.save(), {name: tree.servos.save() for name, tree in self._trees.items()}

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        firm, servos = saved
        self.firm.restore(firm)
        for name, kept in servos.items():
            self._trees[name].servos.restore(kept)

    def set_wrench(self, path: BodyPath, wrench: Wrench) -> None:
        """Apply a wrench to a body."""
        lift = self._lifts.get(path, Wrench())
        force = np.add(wrench.force, lift.force).tolist()
        model, index = path
        body, place = self._built.bodies[model][index]
        assert body.inertial is not None  # only moving bodies are pulled
        point = (place.held @ body.inertial.pose).position
        self._gazebo.do(operation("w", place.link, values=(*force, *wrench.torque, *point)))

    def touches(self) -> Iterator[Touch]:
        """Return the contacts of the last step."""
        links, rows, _ = contacts(self._gazebo.ask(operation("c")))
        for (one, other), row in zip(links, rows.tolist(), strict=True):
            x, y, z, nx, ny, nz, depth, fx, fy, fz = row
            bodies = self._built.owners[one], self._built.owners[other]
            yield Touch(bodies, (x, y, z), (nx, ny, nz), depth, (fx, fy, fz))

    def joint_wrench(self, body: Body, place: BodyHandle) -> Wrench:
        """Return the wrench of a body on its parent in the last step, at the body's origin."""
        assert body.joint is not None
        model, _ = self._built.owners[place.link]
        number = self._built.gazebo.joint(model, body.joint.name)
        row = np.frombuffer(self._gazebo.ask(operation("q", number)))
        turn = (motion_of(self._gazebo.links[place.link]).pose).rotate
        return Wrench(turn(tuple(row[:3].tolist())), turn(tuple(row[3:].tolist())))
