"""Surfaces that are not convex as MuJoCo's height fields, or as convex geoms behind them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.findings import Code, Findings
from nrp_core.scene.meshes.shapes import heights_of
from nrp_core.scene.model import ConcaveMesh, Geometry, Heightmap, Mesh, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.scene.tessellation import box_around, triangles_of
from nrp_world_mujoco.library import mujoco, pos_quat

if TYPE_CHECKING:
    from nrp_world_mujoco.ground import Ground

MAX_CELLS = 15_000
"""Maximum number of convex geoms of all surfaces; more are merged. These take MuJoCo 1.5 s to compile."""
THICKNESS = 1.0
"""Thickness of the ground below the lowest point of a height map, m."""
MIN_EXTENT = 1e-6
"""Minimum height of a height map in MuJoCo, m."""


@dataclass(frozen=True)
class Part:
    """A surface or a convex part of one.

    Args:
        pose: its pose in the frame of the surface.
        shape: the arguments of its geoms.
    """

    pose: Pose
    shape: Mapping[str, Any]

    def placed(self, pose: Pose) -> dict[str, Any]:
        """Return the arguments of its geom for a pose of the surface."""
        return {**self.shape, **pos_quat(pose @ self.pose)}


class Surfaces:
    """Loads the surfaces of a scene into a specification, each once.

    Args:
        spec: the specification.
        scene: the scene.
        warnings: receives a finding if parts are merged, because the surfaces have too many convex parts.
    """

    def __init__(self, spec: Any, scene: Scene, warnings: Findings) -> None:
        self._spec, self._scene, self._warnings = spec, scene, warnings
        self._fields: dict[Mesh, Part] = {}
        self._parts: dict[str, list[Part]] = {}

    def parts(self, name: str) -> list[Part]:
        """Return the parts of a concave collision; a single part for a ground without space beneath it."""
        if not self._parts:
            self._load()
        return self._parts[name]

    def height_map(self, ground: Heightmap) -> Part:
        """Return a height map as a height field."""
        x, y, z = ground.scale
        high = np.array([x / 2, y / 2])
        return self._field(ground, heights_of(ground) * z, -high, high)

    def _field(self, mesh: Mesh, heights: FloatArray, low: FloatArray, high: FloatArray) -> Part:
        lowest, extent = float(heights.min()), max(float(np.ptp(heights)), MIN_EXTENT)
        rows, columns = heights.shape
        name = f"ground{len(self._fields)}"
        if mesh not in self._fields:
            self._spec.add_hfield(
                name=name, nrow=rows, ncol=columns, size=[*((high - low) / 2).tolist(), extent, THICKNESS],
                userdata=((heights - lowest) / extent).ravel(),
            )  # fmt: skip
            x, y = ((low + high) / 2).tolist()
            shape = {"type": mujoco.mjtGeom.mjGEOM_HFIELD, "hfieldname": name}
            self._fields[mesh] = Part(Pose((x, y, lowest)), shape)
        return self._fields[mesh]

    def _load(self) -> None:
        shapes = {
            f"{model.name}/{link.name}/{each.name}": (model.pose @ link.pose @ each.pose, each.geometry)
            for model in self._scene.models
            for link in model.links
            for each in link.collisions
        }
        from nrp_world_mujoco.ground import ground_of  # compiled code takes time to load

        surfaces = {name: each for name, (_, each) in shapes.items() if isinstance(each, ConcaveMesh)}
        grounds = {each: ground_of(*triangles_of(each)) for each in dict.fromkeys(surfaces.values())}
        cut: dict[str, ConcaveMesh] = {}
        for name, surface in surfaces.items():
            ground = grounds[surface]
            if ground is None or self._is_above_another(ground, name, shapes):
                cut[name] = surface
            else:
                self._parts[name] = [self._field(surface, ground.heights, ground.low, ground.high)]
        found = self._cells_of(Counter(cut.values()))
        parts = {surface: self._geoms(number, each) for number, (surface, each) in enumerate(found.items())}
        self._parts |= {name: parts[surface] for name, surface in cut.items()}

    def _is_above_another(
        self, ground: Ground, name: str, shapes: Mapping[str, tuple[Pose, Geometry]]
    ) -> bool:
        """Return whether there is another shape beneath a ground; cells leave this space free."""
        back = shapes[name][0].inverse()
        others = [place for other, place in shapes.items() if other != name]
        boxes = (box_around([(back @ pose, each)]) for pose, each in others)
        middles = np.array([(low + high) / 2 for low, high in filter(None, boxes)]).reshape(-1, 3)
        return ground.is_above(middles)

    def _cells_of(self, uses: Mapping[ConcaveMesh, int]) -> dict[ConcaveMesh, list[FloatArray]]:
        """Return the convex cells of surfaces; if there are too many, merge small neighbours.

        Args:
            uses: number of collisions with each surface.
        """
        from nrp_core.scene.meshes.cells import cells_of_surfaces  # compiled code takes time to load

        found, errors = cells_of_surfaces(uses, MAX_CELLS)
        if len(errors):
            message = f"{len(errors)} concave meshes have too many convex parts for MuJoCo"
            self._warnings.add(
                Code.NRP258, f"{message}: parts are merged, which moves surfaces by up to {max(errors):.2g} m"
            )
        return dict(zip(uses, found, strict=True))

    def _geoms(self, number: int, cells: Sequence[FloatArray]) -> list[Part]:
        boxes = _boxes_of(cells)
        return [
            boxes.get(cell) or self._hull(f"cell{number}/{cell}", corners)
            for cell, corners in enumerate(cells)
        ]

    def _hull(self, name: str, corners: FloatArray) -> Part:
        element = self._spec.add_mesh(name=name, uservert=corners.ravel())
        element.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # not used
        return Part(Pose(), {"type": mujoco.mjtGeom.mjGEOM_MESH, "meshname": name})


def _boxes_of(cells: Sequence[FloatArray]) -> dict[int, Part]:
    """Return as boxes the cells with a rectangle as their front, and the same behind it, by their numbers."""
    numbers = [number for number, corners in enumerate(cells) if len(corners) == 8]
    if not numbers:
        return {}
    corners = np.stack([cells[number] for number in numbers])
    front, back = corners[:, :4], corners[:, 4:]
    edges = np.stack([front[:, 1] - front[:, 0], front[:, 3] - front[:, 0], front[:, 0] - back[:, 0]], axis=1)
    sizes = np.linalg.norm(edges, axis=2)
    axes = edges / sizes[:, :, None]
    straight = np.ptp(front - back, axis=1).max(axis=1) <= 1e-6
    closed = np.abs(front[:, 0] - front[:, 1] + front[:, 2] - front[:, 3]).max(axis=1) <= 1e-6
    square = np.abs(axes @ axes.swapaxes(1, 2) - np.eye(3)).max(axis=(1, 2)) <= 1e-4
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    orientation, found = np.empty(4), {}
    for each in np.flatnonzero(straight & closed & square).tolist():
        mujoco.mju_mat2Quat(orientation, axes[each].T.ravel())
        w, x, y, z = orientation.tolist()
        pose = Pose(tuple(corners[each].mean(axis=0).tolist()), (x, y, z, w))
        found[numbers[each]] = Part(pose, {"type": mujoco.mjtGeom.mjGEOM_BOX, "size": sizes[each] / 2})
    return found
