"""The limits of joints as MuJoCo has them: one-sided springs with dampers, which yield.

PyBullet's own limits are hard. Muscles press joints against them for long, so that the two differ by as much
as a radian after a second. These are the equations of MuJoCo's documentation ("Computation", "Constraint
model"): a limit that is passed by ``r`` (negative) pushes with a force ``f >= 0`` such that ::

    f = 0 or J a + R f = -b v - k d r,    R = (1 - d) / d * mobility

with the acceleration ``a``, the impedance ``d`` at ``r``, and stiffness and damping of the reference.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core._support.small_matrices import product
from nrp_core.scene.model import Joint, Model
from nrp_core.world.engine_kit.elimination import solve

_SMALLEST, _LARGEST = 1e-4, 0.9999
"""The range of impedances."""
_ROUNDS = 10
"""Searches for the limits that push change all wrong ones at once in so many rounds, and then one."""

Reference = tuple[FloatArray, FloatArray, float]
"""``solreflimit``, ``solimplimit`` and ``margin`` of a joint."""


def references_of(model: Model) -> Mapping[str, Reference]:
    """Return the properties of limits that the file of a model states, by joint; MJCF states all."""
    found = {}
    for each in model.native:
        values = dict(each.attributes)
        if each.namespace == "mujoco" and each.tag == "joint" and "solreflimit" in values:
            numbers = [np.array(values[name].split(), float) for name in ("solreflimit", "solimplimit")]
            found[values["name"]] = numbers[0], numbers[1], float(values.get("margin", 0.0))
    return found


def armatures_of(model: Model) -> Mapping[str, float]:
    """Return the inertia of the motors of joints (kg m^2 or kg) that the file of a model states, by joint."""
    elements = [each for each in model.native if each.full_tag == "mujoco:joint"]
    return {each.attribute("name") or "": float(each.attribute("armature") or 0.0) for each in elements}


class SoftLimits:
    """The limits of some coordinates of a tree.

    Args:
        joints: the joint of each coordinate of the tree.
        references: the properties of limits, by joint; joints without any have none here.
        inertia: the joint-space inertia at the positions 0, shape ``(n, n)``.
        step_s: the physics step.
    """

    def __init__(
        self,
        joints: Sequence[Joint],
        references: Mapping[str, Reference],
        inertia: FloatArray,
        step_s: float,
    ) -> None:
        sides = [
            (n, side, limit, *references[joint.name])
            for n, joint in enumerate(joints)
            if joint.name in references and joint.kind in ("revolute", "prismatic") and joint.mimic is None
            for side, limit in ((1.0, joint.lower), (-1.0, joint.upper))
            if isfinite(limit)
        ]
        self.coordinates = sorted({n for n, *_ in sides})
        self._places = np.array([n for n, *_ in sides], int)
        self._sides = np.array([side for _, side, *_ in sides])
        self._ends = np.array([limit for _, _, limit, *_ in sides])
        self._margins = np.array([each[-1] for each in sides])
        mobility = np.diag(solve(inertia, np.eye(len(inertia))))
        self._mobility = mobility[self._places]
        self._impedances = np.array([each[4] for each in sides]).reshape(-1, 5)
        constants = [_constants(solref, solimp, step_s) for *_, solref, solimp, _ in sides]
        self._stiffness, self._damping = np.array(constants).reshape(-1, 2).T

    def push(
        self, positions: FloatArray, velocities: FloatArray, inertia: FloatArray, free: FloatArray
    ) -> FloatArray:
        """Return the efforts of the limits in the next step, shape ``(n,)``.

        Args:
            positions: of the coordinates at its start, shape ``(n,)``.
            velocities: shape ``(n,)``.
            inertia: the joint-space inertia, shape ``(n, n)``.
            free: the efforts that accelerate the joints without the limits, shape ``(n,)``.
        """
        efforts = np.zeros(len(positions))
        depths = self._sides * (positions[self._places] - self._ends) - self._margins
        passed = np.flatnonzero(depths < 0.0)
        if not passed.size:
            return efforts
        places, sides = self._places[passed], self._sides[passed]
        pushes = np.zeros((len(positions), len(passed)))
        pushes[places, np.arange(len(passed))] = sides
        moved = solve(inertia, np.column_stack((pushes, free)))
        impedance = np.array([_impedance(self._impedances[n], abs(depths[n])) for n in passed])
        wanted = -self._damping[passed] * sides * velocities[places]
        wanted -= self._stiffness[passed] * impedance * depths[passed]
        yielding = product(pushes.T, moved[:, :-1])
        yielding.reshape(-1)[:: len(passed) + 1] += (1.0 - impedance) / impedance * self._mobility[passed]
        efforts += product(pushes, _pressures(yielding, wanted - product(pushes.T, moved[:, -1])))
        return efforts


def _constants(solref: FloatArray, solimp: FloatArray, step_s: float) -> tuple[float, float]:
    """Return stiffness (1/s^2) and damping (1/s) of a reference; its time constant is at least two steps."""
    first, second = solref.tolist()
    largest = min(max(float(solimp[1]), _SMALLEST), _LARGEST)
    if first <= 0.0:
        return -first / largest**2, -second / largest
    first = max(first, 2.0 * step_s)
    return 1.0 / (largest * first * second) ** 2, 2.0 / (largest * first)


def _impedance(solimp: FloatArray, depth: float) -> float:
    """Return the impedance at a depth: from one value to the other over a width, by two powers."""
    values: list[float] = solimp.tolist()
    start, end, width, middle, power = values
    start, end = (min(max(each, _SMALLEST), _LARGEST) for each in (start, end))
    middle, power = min(max(middle, _SMALLEST), _LARGEST), max(power, 1.0)
    if start == end or width <= 1e-15:
        return 0.5 * (start + end)
    x = depth / width
    if x >= 1.0:
        return end
    if power != 1.0:
        x = float(
            (x / middle) ** power * middle
            if x <= middle
            else 1.0 - ((1.0 - x) / (1.0 - middle)) ** power * (1.0 - middle)
        )
    return start + x * (end - start)


def _pressures(yielding: FloatArray, gaps: FloatArray) -> FloatArray:
    """Return the ``f >= 0`` of which ``yielding @ f - gaps >= 0``, where one of both is 0 for each.

    Wrong guesses are flipped all at once, and then the last one alone, which ends for every positive definite
    matrix (K. G. Murty, Note on a Bard-type scheme for solving the complementarity problem, 1974).
    """
    pushing, rounds = gaps > 0.0, 0
    while True:
        forces = np.zeros(len(gaps))
        on = np.flatnonzero(pushing)
        if on.size:
            forces[on] = solve(np.ascontiguousarray(yielding[np.ix_(on, on)]), gaps[on, None])[:, 0]
        slack = product(yielding, forces) - gaps
        wrong = np.flatnonzero(np.where(pushing, forces < 0.0, slack < -1e-12 * (1.0 + abs(gaps))))
        if not wrong.size or not np.isfinite(forces).all():
            return forces
        rounds += 1
        pushing[wrong if rounds <= _ROUNDS else wrong[-1:]] ^= True
