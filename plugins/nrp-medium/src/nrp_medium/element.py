"""The force element: links in a medium, which pushes, slows and loads them.

A wrench is along the axes of a link and about its origin: a force (N) and then a torque (N m), shape
``(6,)``. The wrench on a link is ``W = Q - D v - A dv/dt``. Here ``v`` is its velocity (m/s, rad/s) against
the medium, ``Q`` any other wrench, ``D`` the damping and ``A`` the added mass (T. I. Fossen, Handbook of
Marine Craft Hydrodynamics and Motion Control, 2011, chapter 6).

Engines are given ``W`` for a whole step. Evaluated at its start, it makes a light body in a viscous medium
unstable as soon as the step exceeds ``2 M / D``, and a body with an added mass above its own at any step. So
it is evaluated at the end of the step, with the velocity that the link will have::

    (M + A + h D) a = F + Q - D v        W = Q - D v - (A + h D) a

``h`` is the step, ``M`` the link's own inertia, and ``F`` everything else that acts on it: ``M dv/dt - W`` of
the last step. ``M`` is at most the inertia that the link has in its mechanism, and therefore this converges
for any ``D``, ``A`` and mechanism: the factor by which the error of ``W`` shrinks per step is below 1, and
its limit is exact. Servos with gains that estimate their loads in the same way, those of PyBullet, are not
such a mechanism: in stiff drag a chain of them diverges, and its joints must be firm.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from nrp_core.clock import seconds
from nrp_core.errors import SceneError
from nrp_core.scene.inertia import inertia_tensor
from nrp_core.scene.merged_bodies import Body, bodies_of, body_of, joint_inertias
from nrp_core.world import (
    Drive,
    Engine,
    FloatArray,
    Model,
    Part,
    ServoTarget,
    Vector,
)

_IMMOVABLE = 1e12
"""The mass (kg) of a link that is fixed to the world."""
_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])
_GRIP = 100.0
"""In a step, a shaft corrects a share of its velocity error: this number divided by itself plus 1."""


@dataclass(frozen=True, slots=True)
class Immersed(Drive):
    """Links of a model in a medium.

    Args:
        links: the links on which it acts.
        shafts: the joints that it turns.
    """

    joint_fields: ClassVar[tuple[str, ...]] = ("shafts",)

    links: tuple[str, ...] = ()
    shafts: tuple[str, ...] = ()

    @property
    def needs(self) -> tuple[str, ...]:
        return "links", "joint_control"

    def renamed(self, named: Any) -> Any:
        links, shafts = tuple(map(named, self.links)), tuple(map(named, self.shafts))
        return replace(self, name=named(self.name), links=links, shafts=shafts)

    def check(self, model: Any) -> None:
        for link in self.links:
            model.link(link)


@dataclass(frozen=True, slots=True)
class Flow:
    """The state of ``n`` links in a medium.

    Args:
        turns: from the axes of each link to those of the world, shape ``(n, 3, 3)``.
        origins: in the world, m, shape ``(n, 3)``.
        velocities: of the origins against the medium, along the axes of the links: m/s, then rad/s, shape
            ``(n, 6)``.
    """

    turns: FloatArray
    origins: FloatArray
    velocities: FloatArray


class MediumPart(Part):
    """Applies the wrenches of a medium to links of a model, in each physics step.

    A subclass returns ``Q`` by :meth:`_push` and ``D`` by :meth:`_damping`, and sets ``added_mass``.

    Args:
        drive: the drive that it runs.
        links: the links.
        model: their model.
        engine: the engine.

    Attributes:
        added_mass: ``A`` of each link, kg, kg m and kg m^2, shape ``(n, 6, 6)``; None: none.
        current: the velocity of the medium in the world, m/s.
        state: what changes in a run besides; replaced, never changed in place.
    """

    def __init__(self, drive: Immersed, links: Sequence[str], model: Model, engine: Engine) -> None:
        self._links, self._model, self._engine = tuple(links), model.name, engine
        drives = enumerate((*model.drives, *engine.scene.drives))
        self._name = next(f"{number} {each.name}" for number, each in drives if each is drive)
        self._step_s = seconds(engine.step_ns)
        bodies = bodies_of(model)
        self._inertias = np.array([_inertia(bodies[body_of(bodies, link)], link) for link in links])
        centres = [model.link(link).inertial for link in links]
        self._centres = np.array([each.pose.position if each else (0.0, 0.0, 0.0) for each in centres])
        self._shafts = joint_inertias(bodies)
        self.added_mass: FloatArray | None = None
        self.current: Vector = (0.0, 0.0, 0.0)
        self.state: Any = None
        self._rates: dict[str, float] = {}  # of the shafts
        self._wrenches = np.zeros((len(links), 6))  # of the present step
        self._before: FloatArray | None = None  # velocities at its start

    # -- for subclasses

    @abstractmethod
    def _push(self, flow: Flow) -> FloatArray:
        """Return the wrenches that need not be evaluated at the end of the step, shape ``(n, 6)``."""

    def _damping(self, flow: Flow) -> FloatArray | None:
        """Return ``D`` of each link, N s/m, N s and N m s, shape ``(n, 6, 6)``; None: none."""
        return None

    def _start(self) -> Any:
        """Return :attr:`state` at time 0."""
        return None

    def _turn(self, joint: str, rate: float) -> None:
        """Turn a shaft (rad/s), if the engine moves joints."""
        if self._engine.capabilities.joint_control and joint in self._shafts:
            self._rates = {**self._rates, joint: rate}
            grip = _GRIP * self._shafts[joint] / self._step_s
            self._engine.set_servo_target(self._model, joint, ServoTarget(damping=grip, velocity=rate))

    # -- the part

    def begin(self) -> None:
        self._apply(self._engine.now_ns)

    def at_deadline(self, now_ns: int) -> None:
        self._apply(now_ns)

    def on_model_moved(self) -> None:
        self._before = None

    def reset(self) -> None:
        self.state, self._before, self.deadline_ns, self._rates = self._start(), None, None, {}

    def save(self) -> object:
        return self.state, self.current, self._wrenches, self._before, self.deadline_ns, self._rates

    def restore(self, saved: Any) -> None:
        self.state, self.current, wrenches, self._before, self.deadline_ns, self._rates = saved
        if self.deadline_ns is not None:
            self._set(self._flow(), wrenches)
        for joint, rate in self._rates.items():
            self._turn(joint, rate)

    def _apply(self, now_ns: int) -> None:
        """Apply the wrenches for the next step."""
        flow = self._flow()
        wrenches = self._push(flow)
        damping = self._damping(flow)
        if damping is not None or self.added_mass is not None:
            wrenches = self._at_the_end(flow, wrenches, damping)
        self._set(flow, wrenches)
        self.deadline_ns = now_ns + self._engine.step_ns

    def _flow(self) -> Flow:
        positions, orientations, rates = self._engine.link_motions(self._model, self._links)
        turns = rotations(orientations)
        rates[:, 0] -= self.current
        velocities = np.einsum("nji,nkj->nki", turns, rates).reshape(-1, 6)
        return Flow(turns, positions, velocities)

    def _at_the_end(self, flow: Flow, push: FloatArray, damping: FloatArray | None) -> FloatArray:
        """Return the wrenches that damping and added mass exert at the end of the step."""
        step_s, drag = self._step_s, np.zeros((1, 6, 6)) if damping is None else damping
        drift = np.einsum("nji,j->ni", flow.turns, np.array(self.current))
        load = step_s * drag
        if self.added_mass is not None:
            load = load + self.added_mass
            turning = np.zeros_like(push)  # the axes in which the current is constant turn against the link's
            turning[:, :3] = cross(flow.velocities[:, 3:], drift)
            push = push - _times(self.added_mass, turning)
        push = push - _times(drag, flow.velocities)
        absolute = flow.velocities.copy()
        absolute[:, :3] += drift
        rest = np.zeros_like(push)
        if self._before is not None:
            rest = _times(self._inertias, (absolute - self._before) / step_s) - self._wrenches
        gain = np.linalg.solve(self._inertias + load, (rest + push)[..., None])[..., 0].astype(np.float64)
        self._before = absolute
        wrenches: FloatArray = push - _times(load, gain)
        return wrenches

    def _set(self, flow: Flow, wrenches: FloatArray) -> None:
        """Apply wrenches; an engine applies them at centres of mass, along the axes of the world."""
        self._wrenches = wrenches
        torques = wrenches[:, 3:] - cross(self._centres, wrenches[:, :3])
        both = np.stack([wrenches[:, :3], torques], axis=1)
        in_world = np.einsum("nij,nkj->nki", flow.turns, both).reshape(-1, 6)
        self._engine.set_wrenches(self._model, self._links, in_world, self._name)


def _times(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    product: FloatArray = np.einsum("nij,nj->ni", np.broadcast_to(matrices, (len(vectors), 6, 6)), vectors)
    return product


def rotations(quaternions: FloatArray) -> FloatArray:
    """Return the rotation matrices of unit quaternions (x, y, z, w), shape ``(n, 3, 3)``."""
    x, y, z, w = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def _inertia(body: Body, link: str) -> FloatArray:
    """Return the spatial inertia of the body of a link about the link's origin, along its axes."""
    if body.inertial is None:
        return _IMMOVABLE * np.eye(6)
    place = next(each.pose for each in body.links if each.name == link)
    own = replace(body.inertial, pose=place.inverse() @ body.inertial.pose)
    arm = cross_matrix(own.pose.position)
    whole = own.mass * np.eye(6)
    whole[:3, 3:], whole[3:, :3] = -own.mass * arm, own.mass * arm
    whole[3:, 3:] = inertia_tensor(own) - own.mass * arm @ arm
    return whole


def cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the cross products of vectors, shape ``(..., 3)``; NumPy's takes ten times as long."""
    product: FloatArray = first[..., _NEXT] * second[..., _LAST] - first[..., _LAST] * second[..., _NEXT]
    return product


def cross_matrix(vector: Sequence[float]) -> FloatArray:
    """Return the matrix whose product with a vector is the cross product, shape ``(3, 3)``."""
    x, y, z = vector
    return np.array([(0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)])


def require_stable(part: MediumPart, owner: str) -> None:
    """Refuse an added mass that cancels the inertia of a link.

    Raises:
        SceneError: the sum of both has a direction without inertia, as where the signs of a file are wrong.
    """
    assert part.added_mass is not None
    symmetric = part.added_mass + part.added_mass.swapaxes(1, 2)
    if np.linalg.eigvalsh(part._inertias + symmetric / 2).min() <= 0:
        raise SceneError(
            f"{owner}: its added mass is negative and more than the mass of the link; "
            "derivatives such as <xDotU> are the negative of an added mass"
        )
