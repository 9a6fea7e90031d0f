"""One model in OpenSim, stepped from outside.

At the start of each step the integrator begins anew from the state alone: an adaptive integrator that
continues would keep the size of its last step, which no state contains, and a restored run would differ.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import hypot
from pathlib import Path
from typing import Any

import numpy as np
import opensim
from nrp_core.clock import seconds
from nrp_core.errors import DivergedError
from nrp_core.world import FloatArray, JointStates, Vector, Wrench

from nrp_world_opensim.library import (
    array,
    elements,
    initial_state,
    open_model,
    reason,
    triple,
    upright,
    vector_of,
)
from nrp_world_opensim.options import OpensimOptions

_TILT = 1e-9
"""The sine of the angle from which a model is tilted against gravity."""


class Simulation:
    """The model in a file, its state, and the controls of its actuators.

    Args:
        path: the file.
        options: integrator and accuracy.
        down: the direction of gravity in the frame of the model, whose z axis points up in its file.

    Attributes:
        model: OpenSim's model.
        up: the rotation that takes the axes of the file to those of a world.
        coordinates: its coordinates, in the order of the file.
        muscles: its muscles by name.

    Raises:
        SceneError: OpenSim cannot read or build it, or it has a controller of its own.
    """

    def __init__(self, path: Path, options: OpensimOptions, down: Vector = (0.0, 0.0, -1.0)) -> None:
        self.model = open_model(path)
        self.up = upright(self.model)
        if hypot(*down[:2]) > _TILT:
            x, y, z = (hypot(*triple(self.model.getGravity())) * each for each in down)
            self.model.setGravity(opensim.Vec3(*self.up.rotate_back((x, y, z))))
        self.coordinates = {each.getName(): each for each in elements(self.model.getCoordinateSet())}
        self._efforts = {name: _add_effort(self.model, each) for name, each in self.coordinates.items()}
        bodies = elements(self.model.getBodySet())
        self._pushes = {body.getName(): _add_push(self.model, body) for body in bodies}
        self._initial = initial_state(self.model, path)
        self.muscles = {muscle.getName(): muscle for muscle in elements(self.model.getMuscles())}
        self._places = dict(_places(self.model))
        self._known_indices: dict[tuple[str, ...], list[int]] = {}
        self._loads: dict[str, tuple[float, ...]] = {}
        self._first_controls = array(self.model.getDefaultControls())
        self._manager = _manager(self.model, options)
        self.reset()

    # -- time

    def reset(self) -> None:
        """Return to time 0."""
        self._controls = self._first_controls.copy()
        self.state, self.time_ns = opensim.State(self._initial), 0
        self._changed, self._is_current = True, False
        self._set_loads({})

    def step(self, step_ns: int) -> None:
        """Take a step with the present controls.

        Raises:
            DivergedError: the integrator finds no solution.
        """
        if self._changed:
            self.model.setDefaultControls(vector_of(self._controls))
            self._changed = False
        try:
            self._manager.initialize(self.state)
            self.state = self._manager.integrate(seconds(self.time_ns + step_ns))
        except RuntimeError as error:
            raise DivergedError(
                f"OpenSim cannot integrate '{self.model.getName()}': {reason(error)}", t_ns=self.time_ns
            ) from None
        self.time_ns += step_ns
        self._is_current = False

    def save(self) -> object:
        """Return time, state, controls and wrenches."""
        return self.time_ns, array(self.state.getY()), self._controls.copy(), dict(self._loads)

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        self.time_ns, values, controls, loads = saved
        self._controls = controls.copy()
        self.state = opensim.State(self._initial)
        self.state.setTime(seconds(self.time_ns))
        self.state.setY(vector_of(values))
        self._set_loads(loads)
        self._changed, self._is_current = True, False

    # -- commands

    def set_controls(self, names: Sequence[str], values: FloatArray) -> None:
        """Set the controls of actuators from the next step on."""
        self._controls[self._indices(tuple(names))] = values
        self._changed = True

    def set_effort(self, coordinate: str, effort: float) -> None:
        """Set the generalised force on a coordinate, N m or N."""
        self.set_controls((self._efforts[coordinate],), np.array([effort]))

    def push(self, body: str, wrench: Wrench, point: Vector) -> None:
        """Set the wrench on a body at a point of its frame; the wrench is in the axes of the file."""
        acts = any(wrench.force) or any(wrench.torque)
        load = {body: (*wrench.force, *wrench.torque, *point)} if acts else {}
        self._set_loads({**{name: each for name, each in self._loads.items() if name != body}, **load})

    def _set_loads(self, loads: dict[str, tuple[float, ...]]) -> None:
        """Set the wrenches on bodies: force, torque and point."""
        for name in loads.keys() | self._loads.keys():
            _set_values(self._pushes[name], loads.get(name, ()))
        self._loads = dict(loads)

    def _indices(self, names: tuple[str, ...]) -> list[int]:
        if names not in self._known_indices:
            self._known_indices[names] = [self._places[name] for name in names]
        return self._known_indices[names]

    # -- states

    def at_velocity(self) -> Any:
        """Return the present state with positions and velocities computed."""
        self.model.realizeVelocity(self.state)
        return self.state

    def joints(self) -> dict[str, list[str]]:
        """Return the joints by name, with the names of their coordinates."""
        return {
            joint.getName(): [joint.get_coordinates(n).getName() for n in range(joint.numCoordinates())]
            for joint in elements(self.model.getJointSet())
        }

    def joint_states(self) -> JointStates:
        """Return the states of coordinates; the efforts are those that commands exert."""
        state, coordinates = self.at_velocity(), self.coordinates.values()
        positions = np.array([each.getValue(state) for each in coordinates])
        velocities = np.array([each.getSpeedValue(state) for each in coordinates])
        efforts = self._controls[self._indices(tuple(self._efforts.values()))]
        return JointStates(tuple(self.coordinates), positions, velocities, efforts)

    def muscle_states(self, names: Sequence[str]) -> FloatArray:
        """Return fibre lengths and velocities, tendon forces and activations, shape ``(4, n)``."""
        if not self._is_current:
            self.model.realizeDynamics(self.state)
            self._is_current = True
        state, found = self.state, np.zeros((4, len(names)))
        for column, name in enumerate(names):
            muscle = self.muscles[name]
            found[:, column] = (
                muscle.getFiberLength(state),
                muscle.getFiberVelocity(state),
                muscle.getTendonForce(state),
                muscle.getActivation(state),
            )
        return found

    def path_of(self, muscle: str) -> list[Vector]:
        """Return the points of a muscle's path as OpenSim wraps it, in the axes of the file, m."""
        state = self.at_velocity()
        path = self.muscles[muscle].getGeometryPath().getCurrentPath(state)
        return [triple(path.get(index).getLocationInGround(state)) for index in range(path.getSize())]


def _manager(model: Any, options: OpensimOptions) -> Any:
    """Return an integrator that records nothing."""
    manager = opensim.Manager(model)
    manager.setIntegratorMethod(getattr(opensim.Manager, f"IntegratorMethod_{options.integrator}"))
    manager.setIntegratorAccuracy(options.accuracy)
    manager.setWriteToStorage(False)
    manager.setRecordStatesTrajectory(False)
    manager.setPerformAnalyses(False)
    return manager


def _places(model: Any) -> Iterator[tuple[str, int]]:
    """Yield the actuators with one control, and its place among the controls of the model."""
    for actuator in elements(model.getActuators()):
        if actuator.numControls() == 1:
            found = opensim.Vector(model.getNumControls(), 0.0)
            actuator.addInControls(opensim.Vector(1, 1.0), found)
            yield actuator.getName(), int(array(found).argmax())


def _add_effort(model: Any, coordinate: Any) -> str:
    """Add an actuator whose control is the generalised force on a coordinate, and return its name."""
    actuator = opensim.CoordinateActuator(coordinate.getName())
    actuator.setName(f"nrp_effort_{coordinate.getName()}")
    actuator.setOptimalForce(1.0)
    model.addForce(actuator)
    name: str = actuator.getName()
    return name


def _add_push(model: Any, body: Any) -> Any:
    """Add a force on a body that does not act yet, and return it."""
    force = opensim.PrescribedForce(f"nrp_push_{body.getName()}", body)
    force.setForceIsInGlobalFrame(True)
    force.setPointIsInGlobalFrame(False)
    model.addForce(force)
    return force


def _set_values(push: Any, values: Sequence[float]) -> None:
    """Set force, torque and point of a force of :func:`_add_push`; without values it does not act."""
    parts = push.setForceFunctions, push.setTorqueFunctions, push.setPointFunctions
    clears = push.clearForceFunctions, push.clearTorqueFunctions, push.clearPointFunctions
    for index, (fill, clear) in enumerate(zip(parts, clears, strict=True)):
        if values:
            fill(*(opensim.Constant(value) for value in values[3 * index : 3 * index + 3]))
        else:
            clear()
