"""A model as rigid bodies: links that cannot move against each other are one body.

Every body and joint costs time in an engine; links that are fixed to each other are merged here, in the same
way for all engines.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from nrp_core._support.small_matrices import principal_axes, product
from nrp_core.errors import SceneError
from nrp_core.scene.consistency import WORLD
from nrp_core.scene.devices import Pid
from nrp_core.scene.inertia import inertia_tensor, sum_inertials
from nrp_core.scene.model import Inertial, Joint, Link, Model
from nrp_core.scene.rigid import Pose, Vector

WORLD_FRAME = 0
"""The name of the fixed body."""


@dataclass(frozen=True, slots=True)
class Body:
    """One or more links that move as one body.

    Args:
        name: the name of its first link, or ``world`` for a fixed body.
        parent: index of the parent among the model's bodies, None for a root.
        joint: the joint to the parent, movable, measured or preserved; its frame is the body's frame.
        fixed: whether it is a root that does not move; other roots float freely.
        pose: the body's frame in the parent's with the joint at 0; a root's in the world.
        in_model: the body's frame in the model's frame with all joints at 0; a root's is the same.
        inertial: mass in the body's frame, along principal axes; None if it is fixed.
        links: the links, with their poses in the body's frame.
    """

    name: str
    parent: int | None
    joint: Joint | None
    fixed: bool
    pose: Pose
    in_model: Pose
    inertial: Inertial | None
    links: tuple[Link, ...]

    @property
    def floats(self) -> bool:
        """Whether it is a root that floats freely."""
        return self.parent is None and not self.fixed

    @property
    def weightless(self) -> Inertial | None:
        """The part of its mass that gravity does not pull, in its frame; None if gravity pulls all."""
        return sum_inertials(_masses([link for link in self.links if not link.gravity]))

    @property
    def pulled(self) -> Inertial | None:
        """The part of its mass that gravity pulls, in its frame, or None."""
        return sum_inertials(_masses([link for link in self.links if link.gravity]))

    @property
    def decay(self) -> tuple[float, float]:
        """The rates at which its velocities decay, 1/s: the means of its links by mass."""
        masses = [(link.inertial.mass, link.decay) for link in self.links if link.inertial is not None]
        if not any(any(rates) for _, rates in masses):
            return 0.0, 0.0
        whole = sum(mass for mass, _ in masses)
        linear, angular = (sum(mass * rates[i] for mass, rates in masses) / whole for i in (0, 1))
        return linear, angular


def bodies_of(model: Model) -> tuple[Body, ...]:
    """Return the bodies of a model, parents before children, roots in the order of the links.

    Raises:
        SceneError: a movable body has no mass.
    """
    return tuple(_Merger(model).bodies())


def body_of(bodies: Sequence[Body], link: str) -> int:
    """Return the index of the body that a link is part of."""
    return next(i for i, body in enumerate(bodies) if any(part.name == link for part in body.links))


def lever_of(body: Body, link: str) -> tuple[Link, Vector]:
    """Return a link of a body with mass, and the offset from the body's centre of mass to the link's."""
    assert body.inertial is not None
    part = next(each for each in body.links if each.name == link)
    centre = (part.pose @ part.inertial.pose if part.inertial else part.pose).position
    x, y, z = (a - b for a, b in zip(centre, body.inertial.pose.position, strict=True))
    return part, (x, y, z)


def tree_of(root: int, bodies: Sequence[Body]) -> list[int]:
    """Return the indices of a root and of all its descendants, parents before children."""
    tree = [root]
    for index, body in enumerate(bodies):
        if body.parent in tree:
            tree.append(index)
    return tree


def place_in_frame(body: Body) -> Pose:
    """Return the pose of a body in its own frame, or in the world's if it is fixed."""
    return body.pose if body.fixed else Pose()


class _Merger:
    """Groups links by the first link of their body, ``world`` for fixed links."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._joints: Mapping[str, Joint] = {} if model.static else {j.child: j for j in model.joints}
        self._kept = {
            joint for link in model.links for sensor in link.sensors for joint in sensor.measured_joints
        } | {joint.name for joint in model.joints if joint.preserved}
        self._first = {link.name: WORLD if model.static else self._top(link.name) for link in model.links}
        self._members: dict[str, set[str]] = {WORLD: {WORLD}}
        for link, first in self._first.items():
            self._members.setdefault(first, set()).add(link)

    def bodies(self) -> list[Body]:
        bodies: list[Body] = []
        for first in self._roots():
            self._add(first, None, bodies)
        return bodies

    def _top(self, link: str) -> str:
        """Return the link at the upper end of the fixed joints that hold a link."""
        joint = self._joints.get(link)
        return link if joint is None or self._parts(joint) else self._top(joint.parent)

    def _parts(self, joint: Joint) -> bool:
        """Return whether a joint separates two bodies: it moves, is preserved or measured."""
        return joint.kind != "fixed" or joint.name in self._kept

    def _roots(self) -> Iterator[str]:
        if WORLD in self._first.values() or any(joint.parent == WORLD for joint in self._joints.values()):
            yield WORLD
        for first in dict.fromkeys(self._first.values()):
            if first != WORLD and first not in self._joints:
                yield first

    def _add(self, first: str, parent: int | None, bodies: list[Body]) -> None:
        """Append a body and then its descendants."""
        joint = self._joints.get(first)
        in_model = Pose() if joint is None else joint.pose
        pose = self._model.pose if parent is None else bodies[parent].in_model.inverse() @ in_model
        to_body, members = in_model.inverse(), self._members[first]
        links = [
            replace(link, pose=to_body @ link.pose) for link in self._model.links if link.name in members
        ]
        fixed = first == WORLD
        inertial = None if fixed else sum_inertials(_masses(links))
        if inertial is None and not fixed:
            raise SceneError(f"the link '{first}' of the model '{self._model.name}' can move but has no mass")
        index = len(bodies)
        bodies.append(Body(first, parent, joint, fixed, pose, in_model, inertial, tuple(links)))
        for child, held in self._joints.items():
            if self._parts(held) and held.parent in members:
                self._add(child, index, bodies)


def _masses(links: Sequence[Link]) -> Iterator[Inertial]:
    for link in links:
        if link.inertial is not None:
            yield replace(link.inertial, pose=link.pose @ link.inertial.pose)


STIFF_TIME_CONSTANT_S = 0.04
"""Time constant of joints without gains in their files, s."""


def joint_inertias(bodies: Sequence[Body]) -> Mapping[str, float]:
    """Return the inertia (kg m^2) or mass (kg) that each movable joint has to move, with all joints at 0.

    That of a ball joint is the one about the axis about which it is the largest.
    """
    return {
        body.joint.name: _inertia(index, bodies)
        for index, body in enumerate(bodies)
        if body.joint is not None
    }


def _inertia(index: int, bodies: Sequence[Body]) -> float:
    body = bodies[index]
    assert body.joint is not None
    to_joint = body.in_model.inverse()
    masses = [
        Inertial(part.inertial.mass, to_joint @ part.in_model @ part.inertial.pose, part.inertial.inertia)
        for part in (bodies[each] for each in tree_of(index, bodies))
        if part.inertial is not None
    ]
    whole = sum_inertials(masses)
    assert whole is not None  # movable bodies have mass
    if body.joint.kind == "prismatic":
        return whole.mass
    if body.joint.kind == "ball":
        to_centre = np.array(whole.pose.position)
        outer = product(to_centre, to_centre) * np.eye(3) - np.outer(to_centre, to_centre)
        return float(principal_axes(inertia_tensor(whole) + whole.mass * outer)[0][-1])
    axis = np.array(body.joint.axis)
    lever = np.cross(axis, whole.pose.position)
    about_centre = product(product(axis, inertia_tensor(whole)), axis)
    return float(about_centre + whole.mass * product(lever, lever))


def stiff_gains(inertia: float, *, velocity: bool = False) -> Pid:
    """Return gains with which a joint follows quickly with any load: critically damped."""
    rate = inertia / STIFF_TIME_CONSTANT_S
    return Pid(p=rate) if velocity else Pid(p=rate / STIFF_TIME_CONSTANT_S, d=2 * rate)
