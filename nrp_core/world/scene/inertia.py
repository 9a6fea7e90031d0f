"""Mass properties of shapes and of their replacements, and the repair of impossible ones.

Moments of homogeneous solids are the textbook formulas; a capsule is its cylinder and two half spheres.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import pi, sqrt

from nrp_core.world.rigid.pose import Pose, Vector
from nrp_core.world.scene.mass import combined
from nrp_core.world.scene.meshes.solid import solid_of
from nrp_core.world.scene.meshes.stl import read_stl
from nrp_core.world.scene.model import Box, Capsule, Collision, Cylinder, Geometry, Inertial, Mesh, Sphere

WATER = 1000.0
"""Default density of shapes, kg/m^3: that of the SDF specification."""

LEAST_MOMENT = 1e-14
"""Minimum moment of inertia, kg m^2: a milligram 0.1 mm across; MuJoCo refuses moments below 1e-15."""
_MARGIN = 1e-3  # margin of a repair from the limit, for rounding in engines


def of_shape(geometry: Geometry, density: float = WATER) -> Inertial | None:
    """Return the mass properties of a homogeneous solid, in its frame; None for planes.

    A mesh is the solid that it bounds.

    Raises:
        SceneError: the file of a mesh cannot be used.
    """
    match geometry:
        case Box((x, y, z)):
            mass = density * x * y * z
            moments = (mass / 12 * (y * y + z * z), mass / 12 * (x * x + z * z), mass / 12 * (x * x + y * y))
        case Sphere(r):
            mass = density * 4 / 3 * pi * r**3
            moments = (0.4 * mass * r * r,) * 3
        case Cylinder(r, length):
            mass = density * pi * r * r * length
            across = mass / 12 * (3 * r * r + length * length)
            moments = (across, across, mass / 2 * r * r)
        case Capsule(r, length):
            barrel, caps = density * pi * r * r * length, density * 4 / 3 * pi * r**3
            mass = barrel + caps
            across = barrel / 12 * (3 * r * r + length * length)
            across += caps * (0.4 * r * r + 0.375 * r * length + length * length / 4)
            moments = (across, across, barrel / 2 * r * r + 0.4 * caps * r * r)
        case Mesh(path, scale):
            return solid_of(read_stl(path) * scale, density)
        case _:
            return None
    return Inertial(mass, Pose(), (*moments, 0.0, 0.0, 0.0))


def of_collisions(collisions: Iterable[tuple[Collision, float]]) -> Inertial | None:
    """Return the mass properties of collision shapes with their densities; None where none is solid."""
    solids = [(collision.pose, of_shape(collision.geometry, density)) for collision, density in collisions]
    return combined(replace(solid, pose=pose @ solid.pose) for pose, solid in solids if solid)


def like_shape(solid: Inertial, given: Inertial) -> Inertial:
    """Return the inertia of a solid's shape, scaled to a mass and moved to a centre of mass."""
    xx, yy, zz, xy, xz, yz = (moment * given.mass / solid.mass for moment in solid.inertia)
    return Inertial(given.mass, replace(solid.pose, position=given.pose.position), (xx, yy, zz, xy, xz, yz))


def equivalent_box(inertial: Inertial) -> tuple[Box, Pose]:
    """Return the homogeneous box with these mass properties, at least 1 mm thick, and where its centre is."""
    principal = _principal(inertial)
    moments = principal.inertia[:3]
    x, y, z = (
        max(sqrt(max(6 / inertial.mass * (sum(moments) - 2 * moment), 0.0)), 1e-3) for moment in moments
    )
    return Box((x, y, z)), principal.pose


def repaired(inertial: Inertial) -> tuple[Inertial, str]:
    """Make an inertia physically possible: positive, and each moment at most the sum of the other two.

    Returns:
        The inertia, unchanged if it is valid; and the error, empty if there is none.
    """
    principal = _principal(inertial)
    moments = principal.inertia[:3]
    listed = ", ".join(f"{moment:.3g}" for moment in moments)
    if min(moments) < LEAST_MOMENT:
        floor = max(_MARGIN * max(*moments, 1e-6 * inertial.mass), 2 * LEAST_MOMENT)
        raised = _balanced(tuple(max(moment, floor) for moment in moments))
        wrong = f"its moments ({listed}) are not all {'large enough' if min(moments) > 0 else 'positive'}"
        return replace(principal, inertia=(*raised, 0.0, 0.0, 0.0)), wrong
    if 2 * max(moments) > sum(moments) * (1 + 1e-9):
        wrong = f"its moments ({listed}) break the triangle inequality, so no distribution of mass has them"
        return replace(principal, inertia=(*_balanced(moments), 0.0, 0.0, 0.0)), wrong
    return inertial, ""


def _balanced(moments: tuple[float, ...]) -> Vector:
    """Raise the two smaller of three moments, by the same amount, until their sum exceeds the largest."""
    largest = max(range(3), key=moments.__getitem__)
    lacking = max(2 * moments[largest] * (1 + _MARGIN) - sum(moments), 0.0)
    x, y, z = (moment if i == largest else moment + lacking / 2 for i, moment in enumerate(moments))
    return x, y, z


def _principal(inertial: Inertial) -> Inertial:
    principal = combined([inertial])
    assert principal is not None, "only bodies with mass have an inertia"
    return principal
