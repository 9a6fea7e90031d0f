"""The visuals of a scene as one set of triangles that move with numbered frames."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.cameras import SKY, bytes_of, drawn, flat
from nrp_core.world.render.textures import Textures
from nrp_core.world.rigid import BodyPath as BodyPath
from nrp_core.world.rigid import Pose, matrix_of
from nrp_core.world.scene.merged_bodies import WORLD_FRAME, Body, place_in_frame
from nrp_core.world.scene.meshes.triangles import Coordinates
from nrp_core.world.scene.model import Rgba, Visual
from nrp_core.world.scene.tessellation import mapped_shape, triangles_of

_Shape: TypeAlias = tuple[FloatArray, npt.NDArray[np.int32], Coordinates | None]
"""Vertices, faces, and the places of their corners in an image, None for a shape without any."""

MAX_EXTENT_M = 60.0
"""A larger visual (m) is scenery, which need not fit into an image or a light's beam."""


class SceneMesh:
    """Vertices, triangles and colours of all visuals.

    Attributes:
        vertices: vertices in their frames, shape ``(n, 3)``.
        vertex_frames: the frame of each vertex, shape ``(n,)``.
        faces: indices of vertices, shape ``(m, 3)``.
        surfaces: the number of the visual of each face, shape ``(m,)``.
        shown: which visuals are visible.
        glowing: which visuals have their colour in any light.
        finishes: the finish of each visual, None for a matt one.
        palette: the colours of the visuals, and at index -1 of the sky; shape ``(visuals + 1, 3)``.
        textures: the images on visuals, None if no visual has one.
    """

    def __init__(self, bodies: Mapping[str, Sequence[Body]], frames: Mapping[BodyPath, int]) -> None:
        placed = list(_placed_visuals(bodies, frames))
        meshes = [_in_frame(visual, pose) for _, visual, pose, _ in placed]
        counts = [len(vertices) for vertices, *_ in meshes]
        starts = np.cumsum([0, *counts])
        self._numbers = {path: number for number, (path, *_) in enumerate(placed)}
        self.vertices = np.concatenate([np.empty((0, 3)), *(vertices for vertices, *_ in meshes)])
        self.vertex_frames = np.repeat(np.array([frame for *_, frame in placed], np.int32), counts)
        faces = [faces + start for (_, faces, _), start in zip(meshes, starts, strict=False)]
        self.faces = np.concatenate([np.empty((0, 3)), *faces]).astype(np.int32)
        self.surfaces = np.repeat(np.arange(len(placed), dtype=np.int32), [len(each) for each in faces])
        self.shown = np.ones(len(placed), bool)
        self.glowing = np.array([visual.glows for _, visual, *_ in placed], bool)
        self.finishes = [visual.finish for _, visual, *_ in placed]
        self.palette = np.array([bytes_of(SKY)] * (len(placed) + 1), np.uint8)
        self.textures = self._textures([visual for _, visual, *_ in placed], meshes)
        self._own = [visual.rgba for _, visual, *_ in placed]
        self._imaged = self.textures.shown.copy() if self.textures else np.zeros(len(placed), bool)
        for path, visual, *_ in placed:
            self.set_color(path, visual.rgba)

    def _textures(self, visuals: Sequence[Visual], meshes: Sequence[_Shape]) -> Textures | None:
        images = [
            visual.texture if places is not None else None
            for visual, (*_, places) in zip(visuals, meshes, strict=True)
        ]
        if not any(images):
            return None
        places = [
            np.zeros((len(faces), 3, 2), np.float32) if known is None else known for _, faces, known in meshes
        ]
        return Textures(images, np.concatenate(places), self.surfaces, self.vertices[self.faces])

    def in_world(self, frames: FloatArray) -> FloatArray:
        """Return all vertices in the world, shape ``(n, 3)``.

        Args:
            frames: rotation and translation to the world of each frame, shape ``(m, 3, 4)``.
        """
        held = frames[self.vertex_frames]
        placed: FloatArray = np.einsum("nij,nj->ni", held[:, :, :3], self.vertices) + held[:, :, 3]
        return placed

    def framed(self, points: FloatArray) -> npt.NDArray[np.bool_]:
        """Return which vertices, given in the world, are not those of scenery; all if there are no others."""
        framed = np.zeros(len(points), bool)
        for surface in np.unique(self.surfaces):
            mine = np.unique(self.faces[self.surfaces == surface])
            framed[mine] = self.shown[surface] and np.ptp(points[mine], axis=0).max() < MAX_EXTENT_M
        return framed if framed.any() else ~framed

    def set_color(self, visual: str, rgba: Rgba) -> None:
        """Set the colour of a visual, named by its path; it shows its image in its own colour only."""
        number, color = self._numbers[visual], flat(rgba)
        self.palette[number] = bytes_of(color)
        self.shown[number] = color[3] > 0
        if self.textures is not None:
            self.textures.shown[number] = self._imaged[number] and rgba == self._own[number]

    def set_glow(self, visual: str, glows: bool) -> None:
        """Set whether a visual has its colour in any light."""
        self.glowing[self._numbers[visual]] = glows


def frames_of(bodies: Mapping[str, Sequence[Body]]) -> dict[BodyPath, int]:
    """Number the frames of bodies that move and carry a visual or a camera, from 1; 0 is the world's."""
    paths = [
        (model, index)
        for model, parts in bodies.items()
        for index, body in enumerate(parts)
        if not body.fixed and any(link.visuals or link.sensors for link in body.links)
    ]
    return {path: number for number, path in enumerate(paths, start=WORLD_FRAME + 1)}


def _placed_visuals(
    bodies: Mapping[str, Sequence[Body]], frames: Mapping[BodyPath, int]
) -> Iterable[tuple[str, Visual, Pose, int]]:
    """Return each visual with its path, its pose in a frame, and that frame."""
    for model, parts in bodies.items():
        for index, body in enumerate(parts):
            for link in body.links:
                place = place_in_frame(body) @ link.pose
                frame = frames.get((model, index), WORLD_FRAME)
                for visual in link.visuals:
                    yield f"{model}/{link.name}/{visual.name}", visual, place @ visual.pose, frame


def _in_frame(visual: Visual, pose: Pose) -> _Shape:
    geometry, place = drawn(visual.geometry, pose)
    shape = mapped_shape(geometry) if visual.texture else None
    vertices, faces, places = shape or (*triangles_of(geometry), None)
    matrix = matrix_of(place)
    return vertices @ matrix[:, :3].T + matrix[:, 3], faces, places
