"""The renderer that all engines share: it draws on the CPU and needs no graphics library.

The image depends only on the poses of the bodies and not on the engine.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IndexArray
from nrp_core._support.small_matrices import product
from nrp_core.scene.merged_bodies import WORLD_FRAME, Body, place_in_frame
from nrp_core.scene.model import Rgba
from nrp_core.scene.rigid import BodyPath, ReadFrames, matrix_of
from nrp_core.world.render.cameras import (
    CameraPath,
    Cameras,
    DepthArray,
    ImageArray,
    Optics,
    SegmentArray,
    camera_pose,
    segments_of,
)
from nrp_core.world.render.pixels import NOTHING, NearnessArray, draw, paint, point_array, to_camera
from nrp_core.world.render.scene_mesh import SceneMesh, frames_of

_WORLD_POSES = np.eye(3, 4)[np.newaxis]


class FaceView:
    """Draws the triangles of a mesh, each as a separate surface.

    Args:
        mesh: the visuals.
    """

    def __init__(self, mesh: SceneMesh) -> None:
        self._mesh = mesh
        self._numbers = np.arange(len(mesh.faces), dtype=np.int32)
        self._frames = np.full(len(mesh.vertices), WORLD_FRAME, np.int32)
        self._points = point_array(len(mesh.vertices))
        self._seen: dict[tuple[int, ...], npt.NDArray[np.int32]] = {}

    def draw(
        self,
        points: FloatArray,
        eye: FloatArray,
        focal: float,
        near: float,
        far: float,
        nearness: NearnessArray,
    ) -> npt.NDArray[np.int32]:
        """Return the number of the face at each pixel, -1 for none; valid until the next call.

        Args:
            points: the vertices in the world, shape ``(n, 3)``.
            eye: rotation and translation of the camera to the world, shape ``(3, 4)``.
            focal: focal length, in pixels.
            near: distance in front of which nothing is seen.
            far: distance beyond which nothing is seen.
            nearness: filled with the reciprocals of the depths; its shape is the image's.
        """
        mesh = self._mesh
        if nearness.shape not in self._seen:
            self._seen[nearness.shape] = np.empty(nearness.shape, np.int32)
        seen = self._seen[nearness.shape]
        scene = (points, self._frames, mesh.faces, self._numbers, mesh.shown[mesh.surfaces], _WORLD_POSES)
        draw(*scene, WORLD_FRAME, eye, focal, near, far, self._points, nearness, seen)
        return seen


_WORLD = np.eye(3, 4)


class WorkArrays(NamedTuple):
    """What a renderer fills for each image, of the image's shape.

    Args:
        nearness: reciprocals of the depths.
        seen: the number of the visual.
    """

    nearness: NearnessArray
    seen: npt.NDArray[np.int32]


_kept = threading.local()


def work_arrays(height: int, width: int) -> WorkArrays:
    """Return arrays for images of a size; all renderers on a thread share them, until the next image."""
    sizes: dict[tuple[int, int], WorkArrays] = _kept.__dict__.setdefault("sizes", {})
    if (size := (height, width)) not in sizes:
        sizes[size] = WorkArrays(np.empty(size, np.float32), np.empty(size, np.int32))
    return sizes[size]


class RasterCameras(Cameras):
    """Draws any camera of a scene.

    Args:
        bodies: bodies of each model.
        optics: optics of each camera.
        reader: called once with the paths of the moving bodies in images; returns a function that writes
            their poses.
    """

    draws_depth = True

    def __init__(
        self,
        bodies: Mapping[str, Sequence[Body]],
        optics: Mapping[CameraPath, Optics],
        reader: Callable[[Sequence[BodyPath]], ReadFrames],
    ) -> None:
        numbers = frames_of(bodies)
        self._frames = np.tile(np.eye(3, 4), (1 + len(numbers), 1, 1))  # the first one is the world
        self._read = reader(list(numbers))
        self._mesh = SceneMesh(bodies, numbers)
        self._points = point_array(len(self._mesh.vertices))
        self._segments = segments_of(bodies)
        self._view, self._surfaces_of = (
            FaceView(self._mesh),
            np.append(self._mesh.surfaces, np.int32(NOTHING)),
        )
        self._optics = optics
        self._eyes = {path: self._eye(bodies[path[0]], path, numbers) for path in optics}

    def image(self, path: CameraPath) -> ImageArray:
        if self._mesh.textures is not None:
            return self._draw_flat(path)[0]
        surfaces = self._draw(path)
        image = np.empty((*surfaces.shape, 3), np.uint8)
        paint(surfaces, self._mesh.palette, image)
        return image

    def _draw_flat(self, path: CameraPath) -> tuple[ImageArray, IndexArray, FloatArray, FloatArray]:
        """Return a flat image with images on its surfaces, and the visible triangles.

        Returns:
            The image; the face at each pixel; the vertices and the eye in the world.
        """
        seen, points, eye = self._see(path)
        image = np.empty((*seen.shape, 3), np.uint8)
        paint(self._surfaces_of[seen], self._mesh.palette, image)
        self._lay_images(path, image, seen, points, eye)
        return image, seen, points, eye

    def _see(self, path: CameraPath) -> tuple[IndexArray, FloatArray, FloatArray]:
        """Return the face at each pixel, and the vertices and the eye in the world."""
        self._read(self._frames[WORLD_FRAME + 1 :])
        mesh, optics = self._mesh, self._optics[path]
        points = np.empty_like(mesh.vertices)
        to_camera(mesh.vertices, mesh.vertex_frames, self._frames, WORLD_FRAME, _WORLD, points)
        eye = self._eye_in_world(path)
        seen = self._view.draw(
            points, eye, optics.focal, optics.near, optics.far, self._work_of(path).nearness
        )
        return seen, points, eye

    def _lay_images(
        self, path: CameraPath, image: ImageArray, seen: IndexArray, points: FloatArray, eye: FloatArray
    ) -> None:
        mesh, focal = self._mesh, self._optics[path].focal
        if mesh.textures is not None:
            mesh.textures.lay(seen, self._work_of(path).nearness, focal, eye, points, mesh.faces, image)

    def _work_of(self, path: CameraPath) -> WorkArrays:
        optics = self._optics[path]
        return work_arrays(optics.height, optics.width)

    def _eye_in_world(self, path: CameraPath) -> FloatArray:
        frame, eye = self._eyes[path]
        turn, place = self._frames[frame, :, :3], self._frames[frame, :, 3]
        return np.column_stack([product(turn, eye[:, :3]), product(turn, eye[:, 3]) + place])

    def depth(self, path: CameraPath) -> DepthArray:
        surfaces = self._draw(path)
        return np.where(surfaces == NOTHING, np.inf, 1.0 / self._work_of(path).nearness).astype(np.float32)

    def segments(self, path: CameraPath) -> SegmentArray:
        return self._segments[self._draw(path)]

    def _draw(self, path: CameraPath) -> npt.NDArray[np.int32]:
        """Return the visual at each pixel and store the reciprocal depths; valid until the next call."""
        self._read(self._frames[WORLD_FRAME + 1 :])
        optics, (frame, eye), mesh = self._optics[path], self._eyes[path], self._mesh
        nearness, surfaces = self._work_of(path)
        scene = (mesh.vertices, mesh.vertex_frames, mesh.faces, mesh.surfaces, mesh.shown, self._frames)
        lens = (optics.focal, optics.near, optics.far)
        draw(*scene, frame, eye, *lens, self._points, nearness, surfaces)
        return surfaces

    def set_color(self, visual: str, rgba: Rgba) -> None:
        self._mesh.set_color(visual, rgba)

    def set_glow(self, visual: str, glows: bool) -> None:
        self._mesh.set_glow(visual, glows)

    @staticmethod
    def _eye(
        bodies: Sequence[Body], path: CameraPath, numbers: Mapping[BodyPath, int]
    ) -> tuple[int, FloatArray]:
        """Return the frame that a camera moves with and its pose there."""
        index, pose = camera_pose(bodies, path)
        frame = numbers.get((path[0], index), WORLD_FRAME)
        return frame, matrix_of(place_in_frame(bodies[index]) @ pose)
