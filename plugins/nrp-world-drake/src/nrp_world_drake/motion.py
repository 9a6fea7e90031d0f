"""The state of a plant: its inputs and its steps, poses and velocities of bodies, states of joints."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from math import asin, atan2, sqrt
from typing import Any, Final

import numpy as np

from nrp_core.clock import seconds
from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.rigid import (
    JointStates,
    ModelMotion,
    Pose,
    Quaternion,
    Vector,
    rotate_vector,
    rotation_vector,
)
from nrp_core.world import FloatArray
from nrp_world_drake.build import Built, JointHandle
from nrp_world_drake.library import (
    InitializeParams,
    List,
    Simulator,
    Value,
    applied_force,
    multibody,
    scalar_first,
    tree,
)

_PULLS: Final = Value[List[multibody.ExternallyAppliedSpatialForce]]
QUIETLY: Final = InitializeParams(suppress_initialization_events=True)


class Running:
    """A plant with a state that can be stepped.

    Args:
        built: the scene.
        timestep_ns: the physics step.

    Attributes:
        plant, context: Drake's.
        desired: the positions and velocities that motors lead their joints to, shape ``(2, m)``.
        forces: forces on coordinates, in addition to motors, shape ``(v,)``.
        pulls: those of muscles, in addition to these.
    """

    def __init__(self, built: Built, timestep_ns: int) -> None:
        self.plant = built.plant
        self._step_s, self._steps = seconds(timestep_ns), 0
        self._positions = self.plant.num_positions()
        root = built.diagram.CreateDefaultContext()
        self._root, self.context = root, self.plant.GetMyMutableContextFromRoot(root)
        self._simulator = Simulator(built.diagram, root)
        self._diagram, self._ahead = built.diagram, built.diagram.CreateDefaultContext()
        self._inputs: list[Any] = []
        self._wrenches: list[Any] = []
        motors = self.plant.num_actuators()
        self._open(self.plant.get_actuation_input_port(), motors)
        instance = built.plant.world_body().model_instance()
        for model in range(self.plant.num_model_instances()):
            index = type(instance)(model)
            if self.plant.num_actuators(index):
                self.desired = self._open(self.plant.get_desired_state_input_port(index), 2 * motors)
                self.desired = self.desired.reshape(2, motors)
        if not motors:
            self.desired = np.zeros((2, 0))
        count = self.plant.num_velocities()
        self.forces, self.pulls = np.zeros(count), np.zeros(count)
        self._applied = self._open(self.plant.get_applied_generalized_force_input_port(), count)
        self._contacts = self.plant.get_contact_results_output_port()
        self._reactions = self.plant.get_reaction_forces_output_port()
        self._actuation = self.plant.get_net_actuation_output_port()
        self._state: FloatArray | None = None
        self.put(built.start)

    def _open(self, port: Any, size: int) -> FloatArray:
        """Return an array whose values a port has after :meth:`touch`."""
        if not size:
            return np.zeros(0)
        fixed = port.FixValue(self.context, np.zeros(size))
        self._inputs.append(fixed)
        values: FloatArray = fixed.GetMutableData().get_mutable_value().get_mutable_value()
        return values

    def touch(self) -> None:
        """Let Drake read the inputs again, which have changed."""
        np.add(self.forces, self.pulls, out=self._applied)
        for fixed in self._inputs:
            fixed.GetMutableData()

    def pull(self, wrenches: Iterable[tuple[Any, tuple[Vector, Vector, Vector]]]) -> None:
        """Apply forces and torques to bodies from now on.

        Args:
            wrenches: bodies with a point in their frame (m), and a force (N) and torque (N m) in the world.
        """
        self._wrenches = [applied_force(body, *wrench) for body, wrench in wrenches]
        port = self.plant.get_applied_spatial_force_input_port()
        port.FixValue(self.context, _PULLS(self._wrenches))

    def efforts(self) -> FloatArray:
        """Return the forces on coordinates now, shape ``(v,)``, without those of motors and constraints."""
        plant, context = self.plant, self.context
        forces = tree.MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, forces)  # gravity, springs and dampers
        for each in self._wrenches:
            body = plant.get_body(each.body_index)
            at = plant.EvalBodyPoseInWorld(context, body).rotation().multiply(each.p_BoBq_B)
            body.AddInForce(context, at, each.F_Bq_W, plant.world_frame(), forces)
        efforts: FloatArray = plant.CalcGeneralizedForces(context, forces) - plant.CalcBiasTerm(context)
        return efforts + self.forces + self.pulls

    def step(self, steps: int = 1) -> None:
        """Take physics steps."""
        self._steps += steps
        self._simulator.AdvanceTo(self._steps * self._step_s)
        self._state = None

    def trial(self) -> FloatArray:
        """Return the velocities after a step with the present forces, without taking it, shape ``(v,)``."""
        self.touch()
        self._diagram.CalcForcedUnrestrictedUpdate(self._root, self._ahead.get_mutable_state())
        velocities: FloatArray = self.plant.GetVelocities(self.plant.GetMyContextFromRoot(self._ahead))
        return velocities

    @property
    def state(self) -> FloatArray:
        """All positions, then all velocities; not to be changed."""
        if self._state is None:
            self._state = self.plant.GetPositionsAndVelocities(self.context)
        return self._state

    @property
    def velocities_start(self) -> int:
        """The place of the first velocity in the state."""
        return int(self._positions)

    def put(self, state: FloatArray) -> None:
        """Continue from another state, at Drake's time 0: only the state decides about the future."""
        self._steps, self._state = 0, None
        self._root.SetTime(0.0)
        self.plant.SetPositionsAndVelocities(self.context, state)
        self._simulator.Initialize(QUIETLY)

    def change(self, first: int, values: FloatArray | tuple[float, ...]) -> None:
        """Change a part of the state."""
        state = self.state.copy()
        state[first : first + len(values)] = values
        self.plant.SetPositionsAndVelocities(self.context, state)
        self._state = None

    def contacts(self) -> Any:
        """Return the contacts of the last step."""
        return self._contacts.Eval(self.context)

    def reaction(self, joint: Any) -> Any:
        """Return the spatial force of a joint on its child in the last step, in the child's frame."""
        return self._reactions.Eval(self.context)[int(joint.index())]

    def actuation(self) -> FloatArray:
        """Return the efforts of the motors in the last step, shape ``(m,)``."""
        efforts: FloatArray = self._actuation.Eval(self.context)
        return efforts


class Frame:
    """A frame fixed to a body that moves.

    Args:
        running: the plant.
        place: Drake's body.
        offset: pose of the frame in the body's frame.
    """

    def __init__(self, running: Running, place: Any, offset: Pose) -> None:
        self._running, self._place, self._offset = running, place, offset
        self._fixed = offset == Pose()

    def __call__(self) -> ModelMotion:
        plant, context = self._running.plant, self._running.context
        at = plant.EvalBodyPoseInWorld(context, self._place)
        velocity = plant.EvalBodySpatialVelocityInWorld(context, self._place)
        x, y, z = at.translation().tolist()
        qw, qx, qy, qz = at.rotation().ToQuaternion().wxyz().tolist()
        (vx, vy, vz), (wx, wy, wz) = velocity.translational().tolist(), velocity.rotational().tolist()
        motion = ModelMotion(Pose((x, y, z), (qx, qy, qz, qw)), (vx, vy, vz), (wx, wy, wz))
        return motion if self._fixed else motion.at(self._offset)


class Base:
    """The frame of a body that floats freely.

    Attributes:
        velocity: place of its velocities in the state: angular, then linear, in the world.
        coordinate: place of these among all velocities.
    """

    def __init__(self, running: Running, place: Any) -> None:
        self._running, self._position = running, place.floating_positions_start()
        self.coordinate = place.floating_velocities_start_in_v()
        self.velocity = running.velocities_start + self.coordinate

    def __call__(self) -> ModelMotion:
        state = self._running.state
        qw, qx, qy, qz, x, y, z = state[self._position : self._position + 7].tolist()
        wx, wy, wz, vx, vy, vz = state[self.velocity : self.velocity + 6].tolist()
        size = sqrt(qw * qw + qx * qx + qy * qy + qz * qz)  # Drake lets it grow
        turn = qx / size, qy / size, qz / size, qw / size
        return ModelMotion(Pose((x, y, z), turn), (vx, vy, vz), (wx, wy, wz))

    def put(self, motion: ModelMotion) -> None:
        """Set pose and velocity."""
        pose = motion.pose
        self._running.change(self._position, (*scalar_first(pose.orientation), *pose.position))
        self.set_velocity(motion)

    def set_velocity(self, motion: ModelMotion) -> None:
        """Set the velocity."""
        self._running.change(self.velocity, (*motion.angular, *motion.linear))


def motion_of(running: Running, body: Body, place: Any, offset: Pose) -> Callable[[], ModelMotion]:
    """Return the reader of the motion of a frame fixed to a moving body."""
    if not body.floats:
        return Frame(running, place, offset)
    base = Base(running, place)
    return base if offset == Pose() else lambda: base().at(offset)


class JointReader:
    """Reads the movable joints of one model.

    Args:
        running: the plant.
        joints: handles of the coordinates by name, in the order of the file.
    """

    def __init__(self, running: Running, joints: Mapping[str, JointHandle]) -> None:
        self._running, self.names = running, tuple(joints)
        places = joints.values()
        self._positions = np.array([each.position + (each.axis or 0) for each in places], dtype=int)
        self._velocities = np.array([each.velocity + (each.axis or 0) for each in places], dtype=int)
        self._velocities += running.velocities_start
        self._balls = [number for number, each in enumerate(places) if each.axis == 0]

    def states(self) -> JointStates:
        """Return positions and velocities; the efforts are 0."""
        state = self._running.state
        positions, velocities = state.take(self._positions), state.take(self._velocities)
        for first in self._balls:
            three = slice(first, first + 3)
            positions[three] = rotation_vector(quaternion_of(*positions[three].tolist()))
        return JointStates(self.names, positions, self._turned(velocities), np.zeros(len(positions)))

    def efforts(self, forces: FloatArray) -> FloatArray:
        """Return forces on all coordinates of the plant as efforts of the joints."""
        return self._turned(forces.take(self._velocities - self._running.velocities_start))

    def _turned(self, values: FloatArray) -> FloatArray:
        """Turn velocities or torques of ball joints, which Drake has in the parent, into the child's axes."""
        state = self._running.state
        for first in self._balls:
            three = slice(first, first + 3)
            x, y, z, w = quaternion_of(*state[self._positions[three]].tolist())
            values[three] = rotate_vector(-x, -y, -z, w, tuple(values[three].tolist()))
        return values


def quaternion_of(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the orientation of a ball joint by Drake's three angles."""
    return Pose.from_rpy((0.0, 0.0, 0.0), roll, pitch, yaw).orientation


def angles_of(orientation: Quaternion) -> tuple[float, float, float]:
    """Return Drake's three angles (roll, pitch, yaw) of an orientation."""
    x, y, z, w = orientation
    roll = atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = asin(min(max(2 * (w * y - z * x), -1.0), 1.0))
    return roll, pitch, atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
