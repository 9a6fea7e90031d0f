"""Mass properties of the homogeneous solid that a closed surface bounds.

Sums over the tetrahedra between the triangles and the origin; see for example J. Tonon, "Explicit exact
formulas for the 3-D tetrahedron inertia tensor", Journal of Mathematics and Statistics 1 (2005).
"""

from __future__ import annotations

import numpy as np

from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.meshes.triangles import Triangles
from nrp_core.world.scene.model import Inertial


def solid_of(triangles: Triangles, density: float) -> Inertial | None:
    """Return the mass properties; None if the surface does not enclose a volume."""
    a, b, c = triangles.swapaxes(0, 1)
    sixfold = np.einsum("ij,ij->i", a, np.cross(b, c))
    volume = float(sixfold.sum()) / 6
    extent = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())
    if abs(volume) <= 1e-12 * extent**3:
        return None
    middle = sixfold @ (a + b + c) / 24 / volume
    corners = np.stack([a, b, c, a + b + c], axis=1)
    spread = np.einsum("i,ijk,ijl->kl", sixfold, corners, corners) / 120 - volume * np.outer(middle, middle)
    scale = density * (1.0 if volume > 0 else -1.0)  # a mirrored surface is seen from inside
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = (scale * spread).tolist()
    x, y, z = middle.tolist()
    return Inertial(density * abs(volume), Pose((x, y, z)), (yy + zz, xx + zz, xx + yy, -xy, -xz, -yz))
