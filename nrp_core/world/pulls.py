"""Wrenches that several owners apply to the links of one body, added up at its centre of mass."""

from __future__ import annotations

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.world.rigid.matrices import rotation_matrix
from nrp_core.world.rigid.motion import BodyPath, Wrench
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.merged_bodies import Body, lever_of


class Pulls:
    """The wrenches on the bodies of a scene, each kept until its owner replaces it."""

    def __init__(self) -> None:
        self._by_body: dict[BodyPath, dict[tuple[str, str], FloatArray]] = {}

    def add(
        self, path: BodyPath, body: Body, link: str, link_pose: Pose, wrench: Wrench, of: str
    ) -> tuple[Wrench, bool]:
        """Set the wrench that an owner applies to a link at its centre of mass.

        Args:
            path: the model, and the index of the body.
            body: the body, which the link is part of.
            link: the link.
            link_pose: its pose in the world, m.
            wrench: the wrench in the axes of the world, N and N m.
            of: the owner.

        Returns:
            The sum of all wrenches at the body's centre of mass, and whether the lever arm of this one turns
            with the body, so that it must be set again in each step.
        """
        part, lever = lever_of(body, link)
        turn = rotation_matrix((link_pose @ part.pose.inverse()).orientation)
        pulls = self._by_body.setdefault(path, {})
        pulls[link, of] = np.array([wrench.force, np.cross(turn @ lever, wrench.force) + wrench.torque])
        (fx, fy, fz), (tx, ty, tz) = np.sum([pulls[name] for name in sorted(pulls)], axis=0).tolist()
        return Wrench((fx, fy, fz), (tx, ty, tz)), bool(np.any(lever) and np.any(wrench.force))
