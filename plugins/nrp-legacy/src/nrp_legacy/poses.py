"""The initial poses of robots, in every historical form."""

from __future__ import annotations

from math import sqrt

from nrp_core._support.xml import Element
from nrp_core.world.rigid import Pose
from nrp_legacy.elements import number

PoseNumbers = tuple[float, float, float, float, float, float]
"""x, y, z in m; roll, pitch, yaw in rad."""


def pose_of(element: Element) -> PoseNumbers:
    """Return a ``<robotPose>``: angles, or the quaternion ``ux uy uz theta``, theta its real part.

    If both are given, the angles are used; missing values are 0.

    Raises:
        ExperimentError: a value is not a number.
    """
    x, y, z = (number(element, name) or 0.0 for name in ("x", "y", "z"))
    angles = [number(element, name) for name in ("roll", "pitch", "yaw")]
    vector = [number(element, name) or 0.0 for name in ("ux", "uy", "uz")]
    real = number(element, "theta")
    if all(angle is None for angle in angles) and (real is not None or any(vector)):
        return (x, y, z, *_rpy(vector, real))
    roll, pitch, yaw = (angle or 0.0 for angle in angles)
    return (x, y, z, roll, pitch, yaw)


def _rpy(vector: list[float], real: float | None) -> tuple[float, float, float]:
    """Return the angles of a quaternion, which need not be of length 1."""
    squares = sum(part * part for part in vector)
    w = sqrt(max(0.0, 1.0 - squares)) if real is None else real
    length = sqrt(squares + w * w)
    if length == 0.0:
        return 0.0, 0.0, 0.0
    qx, qy, qz = (part / length for part in vector)
    return Pose((0.0, 0.0, 0.0), (qx, qy, qz, w / length)).rpy
