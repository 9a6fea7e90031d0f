"""Damping between joints, which muscles have and Drake's joints do not.

The force-velocity curve of muscles makes a damping matrix ``K``: the slopes of the curves, by the moment
arms at two coordinates. MuJoCo's ``implicitfast`` takes all of it at the end of a step. Drake so takes
the dampers of single joints, ``(M + h D) dv = h f`` with the joint-space inertia ``M``, the step ``h``
and a diagonal ``D``. With the force ``(D - K) dv`` added to ``f`` this is the step with ``K``. Without
contacts, motors and loops ``dv`` is known before the step. Their forces are Drake's: the step is tried,
and tried again with the ``dv`` of the last trial, until both agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from nrp_core.scene.merged_bodies import tree_of
from nrp_core.world import Code, Findings, FloatArray, Model
from nrp_core.world.engine_kit.elimination import remove_first, solve
from nrp_core.world.engine_kit.soft_constraints import SoftConstraints
from nrp_world_drake.build import Built, JointPath
from nrp_world_drake.control import DrakeFirmJoints
from nrp_world_drake.motion import Running

_BASE = 6
SHARE = 0.6
"""The damping added to a joint, as a share of the sum of its row; trials need half, and more slows them."""
TOLERANCE = 1e-4
"""The error of the forces of damping after trials, as a share of the largest effort in its model.

It is less than what the contacts of engines differ by; without contacts, the first trial is exact.
"""
MOST_TRIALS = 100
"""MyoSuite's legs on the ground need tens of trials in a step, its hand with an object a few."""
REMEMBERED = 6
"""The trials that the next one is made of: with fewer, more are needed."""


class _Damper(NamedTuple):
    """The damper of a joint.

    Args:
        joint: Drake's.
        columns: the numbers of its coordinates.
        own: its damping in the file.
        path: its first coordinate, as of a firm joint.
    """

    joint: Any
    columns: list[int]
    own: float
    path: JointPath


class _Tree:
    """The coordinates of a model: those of free bodies, then those of joints."""

    def __init__(self, model: Model, built: Built, running: Running, step_s: float) -> None:
        placed, handles = built.bodies[model.name], built.joints[model.name]
        bodies = [body for body, _ in placed]
        self.columns, owners = list[int](), list[int]()
        for number, (body, place) in enumerate(placed):
            if body.floats:
                first = place.floating_velocities_start_in_v()
                self.columns += range(first, first + _BASE)
                owners += [number] * _BASE
        self._free, self._ways, self._positions = len(owners), [], list[int]()
        self.dampers = list[_Damper]()
        for number, (body, _) in enumerate(placed):
            if (joint := body.joint) is None or not joint.coordinates:
                continue
            own = [handles[name] for name in joint.coordinates]
            columns = [each.velocity + (each.axis or 0) for each in own]
            path = model.name, joint.coordinates[0]
            self.dampers.append(_Damper(own[0].joint, columns, joint.damping, path))
            self.columns += columns
            self._positions += [each.position + (each.axis or 0) for each in own]
            self._ways += [joint] * len(own)
            owners += [number] * len(own)
        below = [set(tree_of(number, bodies)) for number in range(len(bodies))]
        self.related = np.array([[b in below[a] or a in below[b] for b in owners] for a in owners], float)
        """1 for two coordinates one of which moves the other's body, else 0, shape ``(n, n)``."""
        self.block = np.ix_(self.columns, self.columns)
        """Their rows and columns in matrices of all coordinates."""
        context = running.plant.CreateDefaultContext()
        running.plant.SetPositionsAndVelocities(context, built.start)
        inertia = running.plant.CalcMassMatrix(context)[self.block]
        self._stops = SoftConstraints(
            self._ways, model, remove_first(self._free, inertia, np.zeros(len(inertia)))[0], step_s
        )

    def stop(
        self, state: FloatArray, rates: FloatArray, inertia: FloatArray, efforts: FloatArray
    ) -> FloatArray:
        """Return the efforts of limits, couplings and dry friction as MuJoCo has them, shape ``(n,)``."""
        stopped = np.zeros(len(efforts))
        if self._stops:
            stopped[self._free :] = self._stops.push(
                state[self._positions], rates[self._free :], *remove_first(self._free, inertia, efforts)
            )
        return stopped


class MuscleDamping:
    """Steps of the joints of models with muscles.

    Args:
        models: the models.
        built: the handles of the scene.
        running: its plant.
        firm: the joints that follow with any load, which need no damper.
        step_s: the physics step, s.
        warnings: receives a warning if a step is not found.
    """

    def __init__(
        self,
        models: Sequence[Model],
        built: Built,
        running: Running,
        firm: DrakeFirmJoints,
        step_s: float,
        warnings: Findings,
    ) -> None:
        self._running, self._firm, self._step_s = running, firm, step_s
        self._warnings = warnings
        self._trees = [_Tree(model, built, running, step_s) for model in models]
        self._dampers = [each for tree in self._trees for each in tree.dampers]
        self._load = np.zeros(running.plant.num_velocities())
        self._expected = np.full(len(self._load), np.nan)

    def push(self, efforts: FloatArray, damping: FloatArray) -> None:
        """Set the forces of the next step.

        Args:
            efforts: of the muscles at its start, shape ``(v,)``.
            damping: the damping of the muscles, shape ``(v, v)``.
        """
        running, step_s = self._running, self._step_s
        rates = running.state[running.velocities_start :]
        if not np.array_equal(rates, self._expected):  # somebody moved the bodies
            self._load[:] = 0.0
        between = np.zeros_like(damping)
        for tree in self._trees:
            between[tree.block] = damping[tree.block] * tree.related
        added, owned = self._damp(between)
        running.pulls[:] = efforts + added * rates
        inertia = running.plant.CalcMassMatrix(running.context)
        known, changes = running.efforts(), np.zeros(len(efforts))
        limits = np.full(len(efforts), np.inf)
        for tree in self._trees:
            where, mass = tree.columns, inertia[tree.block]
            stops = tree.stop(running.state, rates[where], mass, known[where] + self._load[where])
            running.pulls[where] += stops
            known[where] += stops
            limits[where] = TOLERANCE * abs(known[where]).max(initial=1e-12)
            mass = mass + step_s * (between[tree.block] + np.diag(owned[where]))
            right = step_s * (known[where] + self._load[where])
            changes[where] = solve(mass, right[:, None])[:, 0]
        split = np.diag(added) - between
        correction, self._expected = self._try(changes, split, running.pulls.copy(), limits)
        found = self._expected - rates
        for tree in self._trees:
            where = tree.columns
            moved = inertia[tree.block] @ found[where] / step_s + (owned + added)[where] * found[where]
            self._load[where] = moved - known[where] - correction[where]

    def _try(
        self, changes: FloatArray, split: FloatArray, pulls: FloatArray, limits: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Try the step until the forces between joints are those of its changes of velocities.

        The next trial has the combination of the last ones whose error is the least (D. G. Anderson,
        Iterative procedures for nonlinear integral equations, J. ACM 12:547, 1965).

        Args:
            changes: a guess of the changes, shape ``(v,)``.
            split: the forces for a change of velocities, shape ``(v, v)``.
            pulls: the other forces of muscles, shape ``(v,)``.
            limits: the largest errors of the forces, shape ``(v,)``.

        Returns:
            The forces between joints and the velocities after the step, each of shape ``(v,)``.
        """
        running, tries, errors = self._running, list[FloatArray](), list[FloatArray]()
        rates = running.state[running.velocities_start :].copy()
        for _ in range(MOST_TRIALS):
            forces = split @ changes
            running.pulls[:] = pulls + forces
            velocities = running.trial()
            tries.append(velocities - rates)
            errors.append(tries[-1] - changes)
            if (abs(split @ errors[-1]) <= limits).all():
                return forces, velocities
            changes = tries[-1]
            if len(tries) > 1:
                del tries[:-REMEMBERED], errors[:-REMEMBERED]
                shares = np.linalg.lstsq(np.diff(errors, axis=0).T, errors[-1], rcond=1e-10)[0]
                changes = changes - shares @ np.diff(tries, axis=0)
        message = f"Drake did not find the damping of muscles in {MOST_TRIALS} trials of a step"
        self._warnings.add(Code.NRP277, message)
        return forces, velocities

    def _damp(self, between: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Set the dampers of joints; return what is added to them for muscles, and their own damping.

        A trial is a step of proximal forward-backward splitting, so that trials converge if twice the added
        damping exceeds that of the muscles (P. L. Combettes and V. R. Wajs, Signal recovery by proximal
        forward-backward splitting, Multiscale Model. Simul. 4:1168, 2005). Half of the sums of its rows does,
        by Gershgorin's theorem.
        """
        added, owned = np.zeros(len(between)), np.zeros(len(between))
        enough = np.maximum(between.diagonal(), SHARE * abs(between).sum(axis=1))
        for joint, columns, own, path in self._dampers:
            owned[columns] = 0.0 if self._firm.leads(path) else own
            added[columns] = enough[columns].max()
            joint.SetDampingVector(self._running.context, owned[columns] + added[columns])
        return added, owned

    def save(self) -> object:
        """Return the forces of contacts, motors and loops in the last step."""
        return self._load.copy(), self._expected.copy()

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""
        self._load[:], self._expected[:] = saved

    def forget(self) -> None:
        """Forget the last step."""
        self._load[:] = 0.0
