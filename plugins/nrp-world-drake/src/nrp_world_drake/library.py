"""The modules of Drake that are used, and conversions of poses and masses; the one place that imports it."""

from __future__ import annotations

import logging
from typing import Any

import numpy as np
from pydrake import geometry as drake_geometry
from pydrake.common import MemoryFile
from pydrake.common.cpp_param import List
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody import plant as multibody
from pydrake.multibody import tree
from pydrake.multibody.math import SpatialForce
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import DiagramBuilder

from nrp_core.scene.inertia import inertia_tensor
from nrp_core.world import Inertial, Pose, Quaternion, Vector, matrix_of

__all__ = ["DiagramBuilder", "InitializeParams", "List", "MemoryFile", "Simulator", "Value", "applied_force",
           "drake_geometry", "multibody", "scalar_first", "spatial_inertia", "transform", "tree"]  # fmt: skip

logging.getLogger("drake").setLevel(logging.ERROR)  # it warns of half spaces, which no soft body here touches


def transform(pose: Pose) -> Any:
    """Return a pose as Drake's type."""
    return RigidTransform(matrix_of(pose))


def scalar_first(orientation: Quaternion) -> tuple[float, float, float, float]:
    """Return a quaternion as w, x, y, z."""
    x, y, z, w = orientation
    return w, x, y, z


def spatial_inertia(inertial: Inertial) -> Any:
    """Return a mass about the origin of its body, along the body's axes.

    Drake refuses moments that no solid body has; files contain them, and other engines take them.
    """
    mass, centre = inertial.mass, np.array(inertial.pose.position)
    about_origin = inertia_tensor(inertial) / mass + centre.dot(centre) * np.eye(3) - np.outer(centre, centre)
    moments = (about_origin[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    return tree.SpatialInertia(mass, centre, tree.UnitInertia(*moments), skip_validity_check=True)


def applied_force(body: Any, point: Vector, force: Vector, torque: Vector) -> Any:
    """Return a force and a torque in the world (N, N m) on a body, at a point in its frame (m)."""
    applied = multibody.ExternallyAppliedSpatialForce()
    applied.body_index, applied.p_BoBq_B = body.index(), np.array(point)
    applied.F_Bq_W = SpatialForce(np.array(torque), np.array(force))
    return applied
