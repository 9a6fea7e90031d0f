"""A recorded scene as triangles that move with recorded frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.recording.layout import WORLD_FRAME
from nrp_core.recording.reading.shapes import Shape, ShapeKind
from nrp_core.world.render.scene_mesh import SceneMesh, frames_of
from nrp_core.world.rigid import Pose, matrix_of
from nrp_core.world.scene.merged_bodies import bodies_of
from nrp_core.world.scene.meshes.stl import write_coordinates
from nrp_core.world.scene.model import (
    Box,
    Cylinder,
    Geometry,
    Inertial,
    Link,
    Mesh,
    Model,
    Sphere,
    Texture,
    Visual,
)


class Stage:
    """The triangles of shapes, by the frames that they move with.

    Args:
        shapes: the shapes of the scene.
        kept: keeps the folder of the meshes, which are read when they are first drawn.

    Attributes:
        mesh: the triangles.
    """

    def __init__(self, shapes: Sequence[Shape], kept: ExitStack) -> None:
        folder = Path(kept.enter_context(TemporaryDirectory()))
        names = dict.fromkeys(shape.frame for shape in shapes)
        models = [_model(name, [shape for shape in shapes if shape.frame == name], folder) for name in names]
        bodies = {model.name: bodies_of(model) for model in models}
        numbers = frames_of(bodies)
        self.mesh = SceneMesh(bodies, numbers)
        self._numbers = {name: number for (name, _), number in numbers.items()}
        self._frames = np.tile(np.eye(3, 4), (1 + len(numbers), 1, 1))

    def vertices(self, poses: Mapping[str, Pose]) -> FloatArray:
        """Return all vertices in the world, shape ``(n, 3)``; frames without a new pose keep theirs."""
        for name, number in self._numbers.items():
            if name in poses:
                self._frames[number] = matrix_of(poses[name])
        return self.mesh.in_world(self._frames)


def _model(frame: str, shapes: Sequence[Shape], folder: Path) -> Model:
    visuals = tuple(
        Visual(f"{number}", _geometry(shape, folder), shape.pose, shape.rgba, texture=_texture(shape, folder))
        for number, shape in enumerate(shapes)
        if shape.kind is not ShapeKind.MESH or shape.mesh is not None
    )
    link = Link("shapes", visuals=visuals, inertial=Inertial(1.0))
    return Model(frame, (link,), static=frame == WORLD_FRAME)


def _geometry(shape: Shape, folder: Path) -> Geometry:
    x, y, z = shape.size
    match shape.kind:
        case ShapeKind.BOX:
            return Box((x, y, z))
        case ShapeKind.ELLIPSOID:
            return Sphere(x / 2)
        case ShapeKind.CYLINDER:
            return Cylinder(x / 2, z)
        case ShapeKind.MESH:
            assert shape.mesh is not None
            places = shape.image.coordinates if shape.image else None
            data = shape.mesh.tobytes()
            path = folder / f"{abs(hash((data, places if places is None else places.tobytes())))}.stl"
            if not path.exists():
                path.write_bytes(data)
                if places is not None:
                    write_coordinates(path, places)
            return Mesh(path, shape.size)


def _texture(shape: Shape, folder: Path) -> Texture | None:
    if shape.image is None:
        return None
    path = folder / f"{abs(hash(shape.image.data))}.image"
    path.write_bytes(shape.image.data)
    return Texture(path, shape.image.tint)
