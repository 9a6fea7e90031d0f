"""The wrenches on the bodies of a scene, by their owners."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from nrp_core.scene.merged_bodies import Body, lever_of
from nrp_core.scene.rigid import BodyPath, Pose, Vector, Wrench

Row = Sequence[float]
"""A force, N, and a torque, N m: six numbers along the axes of the world."""
Pulls = dict[tuple[str, str], Row]
"""The wrench of each link and owner that acts on a body."""


class Group(NamedTuple):
    """Links to which an owner applies wrenches at the centres of mass of their bodies.

    Args:
        bodies: their bodies.
        pulls: all wrenches on each body.
        keys: the key of the owner among these.
    """

    bodies: tuple[BodyPath, ...]
    pulls: tuple[Pulls, ...]
    keys: tuple[tuple[str, str], ...]


class ExternalWrenches:
    """The wrenches on the bodies of a scene, each kept until its owner replaces it."""

    def __init__(self) -> None:
        self._by_body: dict[BodyPath, Pulls] = {}
        self._levers: dict[tuple[BodyPath, str], tuple[Pose, Vector]] = {}

    def add(
        self, path: BodyPath, body: Body, link: str, pose: Callable[[], Pose], wrench: Wrench, of: str
    ) -> tuple[Wrench, bool]:
        """Set the wrench that an owner applies to a link at its centre of mass.

        Args:
            path: the model, and the index of the body.
            body: the body that the link is part of.
            link: the link.
            pose: returns the pose of the link in the world, m; called only if the centre of mass of the link
                is not that of the body.
            wrench: the wrench in the axes of the world, N and N m.
            of: the owner.

        Returns:
            The sum of all wrenches at the body's centre of mass, and whether the lever arm of this one turns
            with the body, so that it must be set again in each step.
        """
        to_body, lever = self._lever(path, body, link)
        pulls, turns = self._by_body.setdefault(path, {}), any(lever) and any(wrench.force)
        own = _moved(wrench, (pose() @ to_body).rotate(lever)) if turns else wrench
        pulls[link, of] = *own.force, *own.torque
        return own if len(pulls) == 1 else wrench_of(_total(pulls)), turns

    def clear(self) -> None:
        """Remove all wrenches, but keep the groups."""
        for pulls in self._by_body.values():
            pulls.clear()

    def group(self, links: Sequence[tuple[BodyPath, Body, str]], of: str) -> Group | None:
        """Return a group of links; None if the centre of mass of one is not that of its body."""
        if any(any(self._lever(*each)[1]) for each in links):
            return None
        pulls = tuple(self._by_body.setdefault(path, {}) for path, _, _ in links)
        return Group(tuple(path for path, _, _ in links), pulls, tuple((link, of) for _, _, link in links))

    def add_all(self, group: Group, rows: Sequence[Row]) -> Sequence[Row]:
        """Set the wrench of each link of a group, and return the sums on their bodies."""
        for pulls, key, row in zip(group.pulls, group.keys, rows, strict=True):
            pulls[key] = row
        if all(len(pulls) == 1 for pulls in group.pulls):
            return rows
        return [_total(pulls) for pulls in group.pulls]

    def _lever(self, path: BodyPath, body: Body, link: str) -> tuple[Pose, Vector]:
        """Return the pose of the body in a link, and the lever from its centre of mass to the link's."""
        if (path, link) not in self._levers:
            part, lever = lever_of(body, link)
            self._levers[path, link] = part.pose.inverse(), lever
        return self._levers[path, link]


def wrench_of(row: Row) -> Wrench:
    """Return the wrench that six numbers give."""
    fx, fy, fz, tx, ty, tz = row
    return Wrench((fx, fy, fz), (tx, ty, tz))


def _total(pulls: Pulls) -> Row:
    rows = [row for _, row in sorted(pulls.items())]
    return rows[0] if len(rows) == 1 else tuple(map(sum, zip(*rows, strict=True)))


def _moved(wrench: Wrench, lever: Vector) -> Wrench:
    """Return a wrench at the end of a lever as one about the start of the lever."""
    (x, y, z), (fx, fy, fz), (tx, ty, tz) = lever, wrench.force, wrench.torque
    return Wrench(wrench.force, (tx + y * fz - z * fy, ty + z * fx - x * fz, tz + x * fy - y * fx))
