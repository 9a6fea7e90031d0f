"""Muscles, which Drake does not have: forces on coordinates, set before each step.

The moment arms of a straight path follow from Drake's Jacobians of its points; those of muscles that wrap
come from MuJoCo's routines. Drake takes forces at the start of a step, so that the force-velocity curve of a
strong muscle would be unstable; see :mod:`~nrp_world_drake.damping`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nrp_core.scene.merged_bodies import body_of
from nrp_core.scene.rigid import Vector
from nrp_core.world import WORLD, Findings, FloatArray, Model, Pose, Scene, ViaPoint, muscles_of
from nrp_core.world.engine_kit.muscles import (
    ACTIVATION,
    LENGTH,
    TENSION,
    VELOCITY,
    activate,
    exert,
    parameters_of,
)
from nrp_core.world.engine_kit.wrapping import WrappingMuscles
from nrp_world_drake.build import Built
from nrp_world_drake.control import DrakeFirmJoints
from nrp_world_drake.damping import MuscleDamping
from nrp_world_drake.library import tree
from nrp_world_drake.motion import Running


class Muscles:
    """The muscles of a scene.

    Args:
        scene: the scene.
        built: its handles.
        running: its plant.
        firm: the joints that follow with any load, which need no damper.
        step_s: the physics step, s.
        warnings: receives a warning if a step is not found.
    """

    def __init__(
        self,
        scene: Scene,
        built: Built,
        running: Running,
        firm: DrakeFirmJoints,
        step_s: float,
        warnings: Findings,
    ) -> None:
        self._running, self._step_s = running, step_s
        owned = [(model, muscle) for model in scene.models for muscle in muscles_of(model)]
        self._parameters = parameters_of(muscle for _, muscle in owned)
        self._numbers = {(model.name, muscle.name): n for n, (model, muscle) in enumerate(owned)}
        self._groups: dict[tuple[str, tuple[str, ...]], list[int]] = {}
        straight = [(model, muscle) for model, muscle in owned if not muscle.wraps]
        self._straight = [n for n, (_, muscle) in enumerate(owned) if not muscle.wraps]
        self._wrapping = [
            self._wrap(model, built) for model in scene.models if any(m.wraps for m in muscles_of(model))
        ]
        places = [_place(built, model, point) for model, muscle in straight for point in muscle.path]
        self._points = np.array([point for _, point in places]).reshape(-1, 3)
        carriers: dict[Any, list[int]] = {}
        for row, (body, _) in enumerate(places):
            carriers.setdefault(body.index(), []).append(row)
        carriers.pop(running.plant.world_body().index(), None)
        self._carried = [
            (running.plant.get_body(index).body_frame(), rows) for index, rows in carriers.items()
        ]
        sizes = np.array([len(muscle.path) for _, muscle in straight], dtype=int)
        lasts = np.cumsum(sizes)
        self._starts = np.setdiff1d(np.arange(len(places)), lasts - 1)  # the first point of each segment
        self._firsts = lasts - sizes - np.arange(len(sizes))  # the first segment of each muscle
        self._places = self._points.copy()
        self._jacobians = np.zeros((len(places), 3, running.plant.num_velocities()))
        models = [model for model in scene.models if muscles_of(model)]
        self._damping = MuscleDamping(models, built, running, firm, step_s, warnings)
        self._controls, self._states = np.zeros(len(owned)), np.zeros((4, len(owned)))
        self._slopes = np.zeros(len(owned))
        self._moments = np.zeros((len(owned), running.plant.num_velocities()))
        self._seen: FloatArray | None = None
        self._exerted: FloatArray | None = None

    def _wrap(self, model: Model, built: Built) -> tuple[WrappingMuscles, list[int], list[int], list[int]]:
        """Return the muscles of a model that wrap, their numbers, and the joints' places in the state."""
        import mujoco

        joints = built.joints[model.name]
        muscles = WrappingMuscles(mujoco, "Drake", model, [*joints])
        return (
            muscles,
            [self._numbers[model.name, name] for name in muscles.names],
            [handle.position for handle in joints.values()],
            [handle.velocity for handle in joints.values()],
        )

    def __bool__(self) -> bool:
        return bool(self._numbers)

    # -- steps

    def push(self) -> None:
        """Set the forces of the next step, and advance the activations."""
        self._update()
        moments = self._moments
        self._exerted = -(self._states[TENSION] @ moments)
        self._damping.push(self._exerted, moments.T * self._slopes @ moments)
        activate(self._controls, self._parameters, self._states, self._step_s)

    def _update(self) -> None:
        """Compute lengths, velocities and tensions, unless they are those of the present state."""
        running = self._running
        if self._seen is not running.state:
            self._seen = running.state
            self._measure()
        exert(self._parameters, self._states, self._slopes)

    def _measure(self) -> None:
        """Compute lengths, velocities, and the derivatives of the lengths by the coordinates."""
        running = self._running
        if self._straight:
            self._measure_straight()
        for muscles, numbers, positions, speeds in self._wrapping:
            rates = running.state[running.velocities_start :][speeds]
            self._states[LENGTH, numbers], _, moments = muscles.find(running.state[positions], rates)
            self._moments[np.ix_(numbers, speeds)] = moments
        self._states[VELOCITY] = self._moments @ running.state[running.velocities_start :]

    def _measure_straight(self) -> None:
        """Compute lengths and derivatives of the muscles along straight lines."""
        running = self._running
        plant, context = running.plant, running.context
        world, by_speed = plant.world_frame(), tree.JacobianWrtVariable.kV
        for frame, rows in self._carried:
            points = self._points[rows].T
            self._places[rows] = plant.CalcPointsPositions(context, frame, points, world).T
            jacobian = plant.CalcJacobianTranslationalVelocity(context, by_speed, frame, points, world, world)
            self._jacobians[rows] = jacobian.reshape(len(rows), 3, -1)
        arrows = self._places[self._starts + 1] - self._places[self._starts]
        lengths = np.sqrt((arrows * arrows).sum(axis=1))
        directions = arrows / np.where(lengths > 0, lengths, 1.0)[:, None]
        closing = self._jacobians[self._starts + 1] - self._jacobians[self._starts]
        rates = np.einsum("si,siv->sv", directions, closing)
        self._moments[self._straight] = np.add.reduceat(rates, self._firsts, axis=0)
        self._states[LENGTH, self._straight] = np.add.reduceat(lengths, self._firsts)

    # -- commands and states

    def set_controls(self, model: str, muscles: Sequence[str], values: FloatArray) -> None:
        """Set the controls of several muscles, shape ``(n,)``."""
        self._controls[self._group(model, tuple(muscles))] = values

    def states(self, model: str, muscles: Sequence[str]) -> FloatArray:
        """Return lengths, velocities, tensions and activations now, shape ``(4, n)``."""
        self._update()
        states: FloatArray = self._states[:, self._group(model, tuple(muscles))]
        return states

    def efforts(self) -> FloatArray:
        """Return the forces on coordinates in the last step, or in the next one before the first."""
        if self._exerted is not None:
            return self._exerted
        self._update()
        pulls: FloatArray = -(self._states[TENSION] @ self._moments)
        return pulls

    def _group(self, model: str, muscles: tuple[str, ...]) -> list[int]:
        path = model, muscles
        if path not in self._groups:
            self._groups[path] = [self._numbers[model, muscle] for muscle in muscles]
        return self._groups[path]

    def release(self) -> None:
        """Remove all controls and activations, as at the start."""
        self._damping.forget()
        self.restore((0.0, 0.0, self._damping.save()))

    def save(self) -> object:
        """Return controls, activations and what is known of the last step."""
        return self._controls.copy(), self._states[ACTIVATION].copy(), self._damping.save()

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        self._controls[:], self._states[ACTIVATION], damping = saved
        self._damping.restore(damping)
        self._exerted = None
        self._running.pulls[:] = 0.0


def _place(built: Built, model: Model, point: ViaPoint) -> tuple[Any, Vector]:
    """Return the body of a point and where it is in the frame of that; the world's if fixed."""
    world = built.plant.world_body()
    if point.link == WORLD:
        return world, (model.pose @ Pose(point.position)).position
    bodies = built.bodies[model.name]
    body, place = bodies[body_of([body for body, _ in bodies], point.link)]
    held = next(link.pose for link in body.links if link.name == point.link) @ Pose(point.position)
    return (world, (body.pose @ held).position) if body.fixed else (place, held.position)
