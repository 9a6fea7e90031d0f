"""Images with light and shadows, drawn on the CPU and the same for every engine, like the flat ones.

Surfaces are matt (Lambert's law), or glossy by their finish
(:mod:`nrp_core.world.render.gloss`); their edges are sharp and their curves smooth. Shadows come from
shadow maps (Williams, Casting curved shadows on curved surfaces, SIGGRAPH 1978). Light is added to SDF's
default ambient light, which comes from all directions; metals reflect it and not other objects. Glowing
surfaces do not light others. Images on surfaces are their colours; maps of their finish are averaged.

Colours and images are linear: a byte is proportional to the light, without gamma. A surface in the light that
makes white surfaces white has the bytes of a flat image.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from nrp_core._support.arrays import FloatArray
from nrp_core.world.render.cameras import CameraPath, ImageArray, Optics
from nrp_core.world.render.gloss import Gloss
from nrp_core.world.render.raster import RasterCameras
from nrp_core.world.render.shading import Lamps, corner_normals, shade
from nrp_core.world.rigid import BodyPath, ReadFrames
from nrp_core.world.scene.merged_bodies import Body
from nrp_core.world.scene.model import Light

AMBIENT = 0.4
"""The ambient light of a scene in SDF (its specification, ``<scene><ambient>``)."""

_MARGIN_M = 0.1


class RealisticCameras(RasterCameras):
    """Draws any camera of a scene with its lights.

    Args:
        bodies: bodies of each model.
        optics: optics of each camera.
        reader: as of :class:`~nrp_core.world.render.raster.RasterCameras`.
        lights: lights of the scene.
    """

    def __init__(
        self,
        bodies: Mapping[str, Sequence[Body]],
        optics: Mapping[CameraPath, Optics],
        reader: Callable[[Sequence[BodyPath]], ReadFrames],
        lights: Sequence[Light],
    ) -> None:
        super().__init__(bodies, optics, reader)
        mesh = self._mesh
        self._lamps = Lamps(lights)
        self._frame_of_face = mesh.vertex_frames[mesh.faces[:, 0]]
        corners = np.argsort(mesh.faces, axis=None, kind="stable").astype(np.int32)
        starts = np.searchsorted(mesh.faces.ravel()[corners], np.arange(len(mesh.vertices) + 1))
        self._normals = corner_normals(mesh.vertices, mesh.faces, corners, starts.astype(np.int32))
        self._gloss = Gloss(mesh.finishes)
        self._framed = np.empty(0, bool)
        self._mapped: tuple[npt.NDArray[Any], ...] = ()

    def set_lights(self, lights: Sequence[Light]) -> None:
        self._lamps = Lamps(lights)
        self._mapped = ()

    def image(self, path: CameraPath) -> ImageArray:
        mesh, lamps, optics = self._mesh, self._lamps, self._optics[path]
        nearness = self._work_of(path).nearness
        image, seen, points, eye = self._draw_flat(path)
        self._map_shadows(points)
        colors = mesh.palette[:-1] / 255
        finishes = self._gloss.of(colors), self._gloss.tables
        looks = (self._frame_of_face, mesh.surfaces, colors, mesh.glowing, *finishes)
        shapes = (points, mesh.faces, self._normals, self._frames, *looks)
        light = (AMBIENT, lamps.rows, lamps.maps, lamps.eyes, lamps.focals)
        shade(seen, nearness, optics.focal, eye, *shapes, *light, image)
        return image

    def _map_shadows(self, points: FloatArray) -> None:
        """Draw the shadow maps, unless they are up to date, as for a second camera at the same time."""
        now = points, self._mesh.shown.copy()
        if self._mapped and all(map(np.array_equal, now, self._mapped)):
            return
        if not self._mapped or not np.array_equal(now[1], self._mapped[1]):
            self._framed = self._mesh.framed(points)
        self._mapped = now
        self._lamps.draw_shadows(*self._lit_sphere(points), lambda *view: self._view.draw(points, *view))

    def _lit_sphere(self, points: FloatArray) -> tuple[FloatArray, float]:
        """Return centre and radius of the region in which directional lights cast shadows."""
        if not len(points):
            return np.zeros(3), 1.0
        low, high = points[self._framed].min(axis=0), points[self._framed].max(axis=0)
        return (low + high) / 2, float(np.linalg.norm(high - low)) / 2 + _MARGIN_M
