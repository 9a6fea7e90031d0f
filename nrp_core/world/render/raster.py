"""The renderer that all engines share: it draws on the CPU and needs no graphics library.

The image depends only on the poses of the bodies and not on the engine.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray, IndexArray
from nrp_core._support.small_matrices import product
from nrp_core.scene.devices import ANY_CAMERA
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
from nrp_core.world.render.pixels import (
    NOTHING,
    NearnessArray,
    count_within,
    draw,
    paint,
    point_array,
    to_camera,
)
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
        self._seen: dict[tuple[int, ...], npt.NDArray[np.int32]] = {}

    def draw(
        self,
        points: FloatArray,
        eye: FloatArray,
        focal: float,
        near: float,
        far: float,
        nearness: NearnessArray,
        mask: int = ANY_CAMERA,
    ) -> npt.NDArray[np.int32]:
        """Return the number of the face at each pixel, -1 for none; valid until the next call.

        Args:
            points: the vertices in the world, shape ``(n, 3)``.
            eye: rotation and translation of the camera to the world, shape ``(3, 4)``.
            focal: focal length, in pixels.
            near: distance in front of which nothing is seen.
            far: distance beyond which nothing is seen.
            nearness: filled with the reciprocals of the depths; its shape is the image's.
            mask: of the camera.
        """
        mesh = self._mesh
        if nearness.shape not in self._seen:
            self._seen[nearness.shape] = np.empty(nearness.shape, np.int32)
        seen = self._seen[nearness.shape]
        shown = mesh.shown_to(mask)[mesh.surfaces]
        scene = (points, self._frames, mesh.faces, self._numbers, shown, _WORLD_POSES)
        draw(*scene, WORLD_FRAME, eye, focal, near, far, _work_points(mesh.vertices), nearness, seen)
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


def _work_points(vertices: FloatArray) -> FloatArray:
    """Return an array for the points of vertices, shared in the same way."""
    sizes: dict[int, FloatArray] = _kept.__dict__.setdefault("points", {})
    if (n := len(vertices)) not in sizes:
        sizes[n] = point_array(n)
    return sizes[n]


@dataclass(frozen=True, slots=True)
class RasterSight:
    """A :class:`~nrp_core.world.render.cameras.Sight` of this renderer.

    Args:
        mesh: the visuals.
        optics: the optics of the camera.
        eye: the frame that the camera moves with, and its pose there.
        frames: rotation and translation of each frame to the world, shape ``(f, 3, 4)``.
        palette: the colours of the visuals and last of the sky.
        shown: which visuals are visible.
    """

    mesh: SceneMesh
    optics: Optics
    eye: tuple[int, FloatArray]
    frames: FloatArray
    palette: npt.NDArray[np.uint8]
    shown: npt.NDArray[np.bool_]

    @property
    def size(self) -> tuple[int, int]:
        return self.optics.height, self.optics.width

    def image(self) -> ImageArray:
        image = np.empty((*self.size, 3), np.uint8)
        paint(self.surfaces(), self.palette, image)
        image.flags.writeable = False
        return image

    def surfaces(self) -> npt.NDArray[np.int32]:
        """Return the visual at each pixel and store the reciprocal depths; valid until the next call."""
        draw(*self._scene())
        return work_arrays(*self.size).seen

    def count(self, chosen: npt.NDArray[np.bool_]) -> tuple[int, int]:
        left, right = count_within(chosen, *self._scene())
        return int(left), int(right)

    def _scene(self) -> tuple[Any, ...]:
        mesh, optics, (frame, eye) = self.mesh, self.optics, self.eye
        surfaces = mesh.vertices, mesh.vertex_frames, mesh.faces, mesh.surfaces, self.shown, self.frames
        lens = optics.focal, optics.near, optics.far
        return (*surfaces, frame, eye, *lens, _work_points(mesh.vertices), *work_arrays(*self.size))


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
        self._bodies, self._numbers = bodies, frames_of(bodies)
        self._mesh = SceneMesh(bodies, self._numbers)
        self._optics = optics
        self._eyes = {path: self._eye(bodies[path[0]], path, self._numbers) for path in optics}
        self._observe(reader)

    def copy(self, reader: Callable[[Sequence[BodyPath]], ReadFrames]) -> RasterCameras:
        """Return the cameras of the same scene in another state, with its first colours."""
        other = copy(self)
        other.__dict__.pop("_view", None)
        other._mesh = self._mesh.copy()
        other._observe(reader)
        return other

    def _observe(self, reader: Callable[[Sequence[BodyPath]], ReadFrames]) -> None:
        self._frames = np.tile(np.eye(3, 4), (1 + len(self._numbers), 1, 1))  # the first one is the world
        self._read = reader(list(self._numbers))

    @cached_property
    def _view(self) -> FaceView:
        return FaceView(self._mesh)

    def look(self, path: CameraPath) -> RasterSight | None:
        return None if self._mesh.textures is not None else self._sight(path, self._frames.copy())

    def image(self, path: CameraPath) -> ImageArray:
        if self._mesh.textures is not None:
            return self._draw_flat(path)[0]
        return self._sight(path, self._frames).image()

    def _sight(self, path: CameraPath, frames: FloatArray) -> RasterSight:
        """Return what a camera sees at present.

        Args:
            path: the camera.
            frames: gets the poses.
        """
        self._read(frames[WORLD_FRAME + 1 :])
        mesh, optics = self._mesh, self._optics[path]
        shown = mesh.shown_to(optics.mask)
        return RasterSight(mesh, optics, self._eyes[path], frames, mesh.palette, shown)

    def _draw_flat(self, path: CameraPath) -> tuple[ImageArray, IndexArray, FloatArray, FloatArray]:
        """Return a flat image with images on its surfaces, and the visible triangles.

        Returns:
            The image; the face at each pixel; the vertices and the eye in the world.
        """
        seen, points, eye = self._see(path)
        image = np.empty((*seen.shape, 3), np.uint8)
        surfaces = np.append(self._mesh.surfaces, np.int32(NOTHING))[seen]
        paint(surfaces, self._mesh.palette, image)
        self._lay_images(path, image, seen, points, eye)
        return image, seen, points, eye

    def _see(self, path: CameraPath) -> tuple[IndexArray, FloatArray, FloatArray]:
        """Return the face at each pixel, and the vertices and the eye in the world."""
        self._read(self._frames[WORLD_FRAME + 1 :])
        mesh, optics = self._mesh, self._optics[path]
        points = np.empty_like(mesh.vertices)
        to_camera(mesh.vertices, mesh.vertex_frames, self._frames, WORLD_FRAME, _WORLD, points)
        eye = self._eye_in_world(path)
        lens = optics.focal, optics.near, optics.far
        seen = self._view.draw(points, eye, *lens, self._work_of(path).nearness, optics.mask)
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
        return segments_of(self._bodies)[self._draw(path)]

    def _draw(self, path: CameraPath) -> npt.NDArray[np.int32]:
        """Return the visual at each pixel and store the reciprocal depths; valid until the next call."""
        return self._sight(path, self._frames).surfaces()

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
