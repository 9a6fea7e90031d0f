"""The limits, couplings and dry friction of joints as MuJoCo has them: constraints that yield.

The limits of PyBullet are hard, and those of Drake are springs of their own. Muscles press joints
against them for long, so that engines differ by as much as a radian after a second. These are the
equations of MuJoCo's documentation ("Computation", "Constraint model"): a constraint whose error is
``r`` pushes with a force ``f`` such that ::

    low <= f <= high,    J a + R f = -b J v - k d r    between these,    R = (1 - d) / d * mobility

with the acceleration ``a``, the impedance ``d`` at ``r``, and stiffness and damping of the reference. The
force of a coupling has no bounds, that of an exceeded limit is at least 0, and that of dry friction is
between minus and plus the friction of the joint, with ``k = 0``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import inf, isfinite
from typing import NamedTuple

import numpy as np

from nrp_core._support.arrays import BoolArray, FloatArray
from nrp_core._support.small_matrices import product
from nrp_core.scene.model import Joint, Model
from nrp_core.scene.origin import Native
from nrp_core.world.engine_kit.elimination import solve
from nrp_core.world.engine_kit.firm_joints import firm_names

_SMALLEST, _LARGEST = 1e-4, 0.9999
"""The range of impedances."""
_ROUNDS = 10
"""Rounds in which the search for forces at their bounds changes all wrong ones; later rounds change one."""
_USUAL = {"solref": "0.02 1", "solimp": "0.9 0.95 0.001 0.5 2"}
"""The reference and impedance of elements that state none, or only the first numbers."""
_SINGLE = ("revolute", "continuous", "prismatic")


class Reference(NamedTuple):
    """How a constraint yields: MuJoCo's ``solref`` and ``solimp``, and its ``margin``."""

    solref: FloatArray
    solimp: FloatArray
    margin: float = 0.0

    @classmethod
    def read(cls, element: Native, suffix: str = "") -> Reference:
        """Read the reference of an element from the attributes with a suffix."""
        values = dict(element.attributes)
        stated = [values.get(f"{name}{suffix}", "").split() for name in _USUAL]
        usual = (text.split() for text in _USUAL.values())
        solref, solimp = (np.array(a + b[len(a) :], float) for a, b in zip(stated, usual, strict=True))
        return cls(solref, solimp, float(values.get("margin", 0.0)) if suffix == "limit" else 0.0)

    def constants(self, step_s: float) -> tuple[float, float]:
        """Return stiffness (1/s^2) and damping (1/s); the time constant is at least two steps."""
        first, second = self.solref.tolist()
        largest = min(max(float(self.solimp[1]), _SMALLEST), _LARGEST)
        if first <= 0.0:
            return -first / largest**2, -second / largest
        first = max(first, 2.0 * step_s)
        return 1.0 / (largest * first * second) ** 2, 2.0 / (largest * first)


class Coupling(NamedTuple):
    """A joint that follows a polynomial of another, or keeps its position.

    Args:
        coordinates: the numbers of the joint and of the other, if there is one.
        polynomial: the coefficients from the constant one on.
        reference: how it yields.
    """

    coordinates: tuple[int, ...]
    polynomial: tuple[float, ...]
    reference: Reference

    def linearize(self, positions: FloatArray, row: FloatArray) -> float:
        """Return the error at the positions of all coordinates; write its derivatives to a row of them."""
        follower, *leader = self.coordinates
        x = float(positions[leader[0]]) if leader else 0.0
        value, slope = 0.0, 0.0
        for coefficient in reversed(self.polynomial):
            value, slope = value * x + coefficient, slope * x + value
        row[leader], row[follower] = -slope, 1.0
        return float(positions[follower]) - value


def armatures_of(model: Model) -> Mapping[str, float]:
    """Return the inertia of the motors of joints (kg m^2 or kg) that the file of a model states, by joint."""
    elements = [each for each in model.native if each.full_tag == "mujoco:joint"]
    return {each.attribute("name") or "": float(each.attribute("armature") or 0.0) for each in elements}


def gains_of(model: Model) -> set[tuple[str, float, float]]:
    """Return joint, stiffness and damping of the servos that the file of an MJCF model itself has."""
    sections = [each.children for each in model.native if each.full_tag == "mujoco:actuator"]
    servos = [each for section in sections for each in section if each.tag in ("position", "velocity")]
    return {
        (
            each.attribute("joint") or "",
            float(each.attribute("kp") or 0.0),
            float(each.attribute("kv") or 0.0),
        )
        for each in servos
    }


def is_coupling(element: Native, joints: Sequence[str]) -> bool:
    """Return whether an element of ``<equality>`` couples some of these joints."""
    ends = [element.attribute(name) for name in ("joint1", "joint2")]
    return element.tag == "joint" and ends[0] in joints and ends[1] in (*joints, None)


def _couplings(model: Model, names: Sequence[str]) -> Iterator[Coupling]:
    """Yield the active couplings of the coordinates with these names."""
    sections = [each.children for each in model.native if each.full_tag == "mujoco:equality"]
    for each in (part for section in sections for part in section if is_coupling(part, names)):
        if each.attribute("active") == "false":
            continue
        ends = [each.attribute(end) for end in ("joint1", "joint2")]
        polynomial = tuple(float(number) for number in (each.attribute("polycoef") or "0 1").split())
        yield Coupling(tuple(names.index(end) for end in ends if end), polynomial, Reference.read(each))


def _stated(joints: Sequence[Joint], model: Model, attribute: str) -> Iterator[tuple[int, Joint, Native]]:
    """Yield the coordinates whose joints state an attribute for MuJoCo, with the elements that do."""
    elements = [each for each in model.native if each.full_tag == "mujoco:joint"]
    stated = {each.attribute("name"): each for each in elements if each.attribute(attribute)}
    for n, joint in enumerate(joints):
        if joint.name in stated and joint.kind in _SINGLE and joint.mimic is None:
            yield n, joint, stated[joint.name]


def frictions_of(joints: Sequence[Joint], model: Model) -> Iterator[tuple[int, float, Reference]]:
    """Yield the coordinates with dry friction that yields, and its effort; firm joints have their own."""
    firm = firm_names(model)
    for n, joint, element in _stated(joints, model, "solreffriction"):
        if joint.friction and joint.name not in firm:
            yield n, joint.friction, Reference.read(element, "friction")


def limits_of(joints: Sequence[Joint], model: Model) -> Iterator[tuple[int, float, float, Reference]]:
    """Yield the coordinates with limits that yield: 1 for the lower and -1 for the upper one, and where."""
    for n, joint, element in _stated(joints, model, "solreflimit"):
        for side, limit in ((1.0, joint.lower), (-1.0, joint.upper)):
            if joint.kind != "continuous" and isfinite(limit):
                yield n, side, limit, Reference.read(element, "limit")


class SoftConstraints:
    """The constraints of the coordinates of a tree, for which MJCF states how they yield.

    Args:
        joints: the joint of each coordinate of the tree.
        model: their model.
        inertia: the joint-space inertia at the positions 0, shape ``(n, n)``.
        step_s: the physics step.

    Attributes:
        limited, rubbing: the coordinates that have limits and dry friction here, not in the engine.
    """

    def __init__(self, joints: Sequence[Joint], model: Model, inertia: FloatArray, step_s: float) -> None:
        names = [joint.name for joint in joints]
        self._couplings = list(_couplings(model, names))
        frictions, limits = list(frictions_of(joints, model)), list(limits_of(joints, model))
        self.rubbing, self.limited = [n for n, *_ in frictions], sorted({n for n, *_ in limits})
        self._references = [each.reference for each in self._couplings]
        self._references += [each[-1] for each in frictions] + [each[-1] for each in limits]
        coupled, first = len(self._couplings), len(self._couplings) + len(frictions)
        self._first_limit = first
        constants = [each.constants(step_s) for each in self._references]
        self._stiffness, self._damping = np.array(constants).reshape(-1, 2).T
        self._stiffness[coupled:first] = 0.0
        self._highest = np.full(len(constants), inf)
        self._highest[coupled:first] = [friction for _, friction, _ in frictions]
        self._lowest = np.where(np.arange(len(constants)) < first, -self._highest, 0.0)
        self._places = np.array([n for n, *_ in limits], int)
        self._sides = np.array([side for _, side, *_ in limits])
        self._ends = np.array([limit for _, _, limit, _ in limits])
        self._margins = np.array([reference.margin for *_, reference in limits])
        self._rows = np.zeros((len(constants), len(joints)))
        for row, each in enumerate(self._couplings):
            self._rows[row, list(each.coordinates)] = 1.0
        self._rows[range(coupled, first), self.rubbing] = 1.0
        self._rows[range(first, len(constants)), self._places] = self._sides
        self._mobility = product(abs(self._rows), np.diag(solve(inertia, np.eye(len(inertia)))))
        self._errors = np.zeros(len(constants))

    def __bool__(self) -> bool:
        return bool(self._references)

    def push(
        self, positions: FloatArray, velocities: FloatArray, inertia: FloatArray, free: FloatArray
    ) -> FloatArray:
        """Return the efforts of the constraints in the next step, shape ``(n,)``.

        Args:
            positions: of the coordinates at its start, shape ``(n,)``.
            velocities: shape ``(n,)``.
            inertia: the joint-space inertia, shape ``(n, n)``.
            free: the efforts that accelerate the joints without the constraints, shape ``(n,)``.
        """
        rows, errors, first = self._rows, self._errors, self._first_limit
        for row, each in enumerate(self._couplings):
            errors[row] = each.linearize(positions, rows[row])
        errors[first:] = self._sides * (positions[self._places] - self._ends) - self._margins
        acting = np.concatenate((np.arange(first), first + np.flatnonzero(errors[first:] < 0.0)))
        if not acting.size:
            return np.zeros(len(positions))
        rows, errors = rows[acting], errors[acting]
        moved = solve(inertia, np.column_stack((rows.T, free)))
        impedance = np.array(
            [
                _impedance(self._references[n].solimp, abs(error))
                for n, error in zip(acting, errors, strict=True)
            ]
        )
        wanted = -self._damping[acting] * product(rows, velocities)
        wanted -= self._stiffness[acting] * impedance * errors
        yielding = product(rows, moved[:, :-1])
        yielding.reshape(-1)[:: len(acting) + 1] += (1.0 - impedance) / impedance * self._mobility[acting]
        gaps = wanted - product(rows, moved[:, -1])
        forces = _forces(yielding, gaps, self._lowest[acting], self._highest[acting])
        efforts: FloatArray = product(rows.T, forces)
        return efforts


def _impedance(solimp: FloatArray, depth: float) -> float:
    """Return the impedance at a depth, which changes from one value to another over a width by two powers."""
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


def _forces(yielding: FloatArray, gaps: FloatArray, lowest: FloatArray, highest: FloatArray) -> FloatArray:
    """Solve ``yielding @ f = gaps`` for the forces ``f``, except where they are at a bound.

    At the lowest force ``yielding @ f`` may be larger, at the highest smaller. Wrong guesses are changed all
    at once, and then the last one alone, which ends for every positive definite matrix (K. G. Murty, Note on
    a Bard-type scheme for solving the complementarity problem, 1974; with two bounds J. J. Judice and F. M.
    Pires, A block principal pivoting algorithm for box-constrained problems, 1994).
    """
    low: BoolArray = (lowest == 0.0) & (gaps <= 0.0)
    high: BoolArray = np.zeros(len(gaps), bool)
    small, rounds = 1e-12 * (1.0 + abs(gaps)), 0
    while True:
        forces = np.where(low, lowest, np.where(high, highest, 0.0))
        on = np.flatnonzero(~(low | high))
        if on.size:
            rest = gaps[on] - product(yielding[on], forces)
            forces[on] = solve(np.ascontiguousarray(yielding[np.ix_(on, on)]), rest[:, None])[:, 0]
        slack = product(yielding, forces) - gaps
        freed = (low & (slack < -small)) | (high & (slack > small))
        inner = ~(low | high)
        below, above = inner & (forces < lowest), inner & (forces > highest)
        wrong = np.flatnonzero(freed | below | above)
        if not wrong.size or not np.isfinite(forces).all():
            return forces
        rounds += 1
        if rounds > _ROUNDS:
            wrong = wrong[-1:]
        low[wrong], high[wrong] = below[wrong], above[wrong]
