"""Models of OpenSim as the engine of a world."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import opensim
from nrp_core.errors import CapabilityError, DivergedError
from nrp_core.world import (
    BodyPath,
    BodyVelocity,
    Engine,
    FloatArray,
    JointStates,
    Model,
    ModelMotion,
    Pose,
    Scene,
    ServoTarget,
    Vector,
    WorldCapabilities,
    Wrench,
)

from nrp_world_opensim.library import elements, pose_of, triple
from nrp_world_opensim.options import OpensimOptions
from nrp_world_opensim.simulation import Simulation

_SUFFIX = ".osim"


class OpensimEngine(Engine):
    """The models of a scene, each with its own integrator; they do not touch each other.

    Args:
        scene: robots in files of OpenSim, and static models, which are only drawn.
        capabilities: the capabilities of the backend.
        seed: the seed of the world; nothing here is random.
        options: the options of the experiment.

    Raises:
        CapabilityError: a model is not one of OpenSim, and is not a static model without collisions.
        SceneError: OpenSim cannot read or build a model.
    """

    def __init__(
        self, scene: Scene, capabilities: WorldCapabilities, *, seed: int, options: OpensimOptions
    ) -> None:
        identity = f"opensim {opensim.GetVersion()} {options.model_dump_json()}"
        super().__init__(scene, capabilities, seed=seed, identity=identity)
        self._bodies_in = {
            model.name: OpensimModel(model, options) for model in scene.models if is_simulated(model)
        }

    # -- required by the interface

    def _do_advance(self, steps: int) -> None:
        for _ in range(steps):
            for each in self._bodies_in.values():
                each.simulation.step(self.step_ns)

    def _do_reset(self, seed: int) -> None:
        for each in self._bodies_in.values():
            each.reset()

    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        raise self.lacks("has no drives")

    def _do_model_motion(self, model: str) -> ModelMotion:
        return ModelMotion(self.scene.model(model).pose)

    # -- optional

    def check_state(self, t_ns: int) -> None:
        for name, each in self._bodies_in.items():
            if not np.isfinite(each.simulation.state.getY().to_numpy()).all():
                raise DivergedError(f"model '{name}' has a state that is not finite", t_ns=t_ns)

    def _do_link_motion(self, model: str, link: str) -> ModelMotion:
        if model not in self._bodies_in:
            return ModelMotion(self.scene.model(model).pose @ self.scene.model(model).link(link).pose)
        return self._bodies_in[model].link_motion(link)

    def _do_joint_states(self, model: str) -> JointStates:
        return self._bodies_in[model].simulation.joint_states()

    def _do_actuator_states(self, model: str, actuators: Sequence[str]) -> FloatArray:
        return self._bodies_in[model].simulation.muscle_states(actuators)

    def muscle_path(self, model: str, muscle: str) -> Sequence[Vector]:
        each = self._bodies_in[model]
        return [(each.place @ Pose(point)).position for point in each.simulation.path_of(muscle)]

    def set_control(self, model: str, actuator: str, value: float) -> None:
        self._bodies_in[model].simulation.set_controls((actuator,), np.array([value]))

    def set_controls(self, model: str, actuators: Sequence[str], values: FloatArray) -> None:
        self._bodies_in[model].simulation.set_controls(actuators, values)

    def _do_set_servo_target(self, model: str, joint: str, aim: ServoTarget) -> None:
        if aim.stiffness or aim.damping or aim.firm:
            raise self.lacks(
                f"does not lead the coordinate '{joint}' of '{model}' to positions or velocities; "
                "command efforts, muscles or other actuators"
            )
        self._bodies_in[model].set_effort(joint, "servo", aim.effort)

    def _do_set_joint_effort(self, model: str, joint: str, effort: float) -> None:
        self._bodies_in[model].set_effort(joint, "force", effort)

    def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        model, index = body
        part = self._bodies_of(model)[index]
        assert part.inertial is not None
        link = part.links[0]
        self._bodies_in[model].push(link.name, wrench, (link.pose.inverse() @ part.inertial.pose).position)

    def _do_save(self) -> object:
        return {name: each.save() for name, each in self._bodies_in.items()}

    def _do_restore(self, saved: Any) -> None:
        for name, each in self._bodies_in.items():
            each.restore(saved[name])


class OpensimModel:
    """A model of OpenSim at its place in a world.

    Attributes:
        simulation: the model, which has the axes of its file.
        place: the pose of these axes in the world.
    """

    def __init__(self, model: Model, options: OpensimOptions) -> None:
        assert model.source is not None
        self.simulation = Simulation(model.source.file, options, model.pose.rotate_back((0.0, 0.0, -1.0)))
        self.place = model.pose @ self.simulation.up
        opened = self.simulation.model
        bodies = {each.getName(): each for each in (opened.getGround(), *elements(opened.getBodySet()))}
        children = {joint.child: joint for joint in model.joints}
        self._frames: dict[str, Any] = {}
        for link in model.links:
            name = link.name
            while name not in bodies:  # a link between two coordinates
                name = next(joint.child for joint in children.values() if joint.parent == name)
            self._frames[link.name] = bodies[name]
        self._efforts: dict[tuple[str, str], float] = {}

    def link_motion(self, link: str) -> ModelMotion:
        """Return pose and velocity of a body in the world."""
        state, frame = self.simulation.at_velocity(), self._frames[link]
        velocity = frame.getVelocityInGround(state)
        return ModelMotion(
            self.place @ pose_of(frame.getTransformInGround(state)),
            self.place.rotate(triple(velocity.get(1))),
            self.place.rotate(triple(velocity.get(0))),
        )

    def set_effort(self, coordinate: str, of: str, effort: float) -> None:
        """Set an effort on a coordinate, N m or N, in addition to those of others."""
        self._efforts[coordinate, of] = effort
        total = sum(each for (name, _), each in sorted(self._efforts.items()) if name == coordinate)
        self.simulation.set_effort(coordinate, total)

    def push(self, link: str, wrench: Wrench, point: Vector) -> None:
        """Set the wrench on a body at a point of its frame; the wrench is in the axes of the world."""
        back = self.place.rotate_back
        turned = Wrench(back(wrench.force), back(wrench.torque))
        self.simulation.push(self._frames[link].getName(), turned, point)

    def reset(self) -> None:
        self._efforts.clear()
        self.simulation.reset()

    def save(self) -> object:
        return dict(self._efforts), self.simulation.save()

    def restore(self, saved: Any) -> None:
        self._efforts, state = dict(saved[0]), saved[1]
        self.simulation.restore(state)


def is_simulated(model: Model) -> bool:
    """Return whether OpenSim moves a model; a static one is only drawn.

    Raises:
        CapabilityError: the model is neither.
    """
    if model.source is not None and model.source.file.suffix.lower() == _SUFFIX:
        return True
    if not model.static:
        raise CapabilityError(
            f"OpenSim cannot simulate '{model.name}': only models in files of its own (.osim) move; "
            "make it static, or use another world"
        )
    if any(link.collisions for link in model.links):
        raise CapabilityError(
            f"OpenSim cannot let bodies touch '{model.name}': they touch only the contact geometry of their "
            "own file; remove its collisions"
        )
    return False
