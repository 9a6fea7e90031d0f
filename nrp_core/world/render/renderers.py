"""The open renderers of a scene; those of the core are imported at their first use, which takes time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from nrp_core.scene.merged_bodies import Body
from nrp_core.scene.model import Light, Rgba
from nrp_core.scene.rigid import BodyPath, ReadFrames
from nrp_core.world.render.cameras import RASTER, REALISTIC, CameraPath, Cameras, Optics


class SceneRenderers:
    """All cameras of a scene, drawn by the preferred renderer, and by another one if that draws no depth.

    Args:
        open_renderer: opens a renderer by its name.
        preferred: the name of the preferred renderer; empty without cameras.

    Attributes:
        opened: the renderers that are open.
        colors: colours of visuals that differ from the scene's, by path.
        glows: glow settings of visuals that differ from the scene's, by path.
    """

    def __init__(self, open_renderer: Callable[[str], Cameras], preferred: str) -> None:
        self._open, self._preferred = open_renderer, preferred
        self._images: Cameras | None = None
        self._depths: Cameras | None = None
        self.opened: list[Cameras] = []
        self.colors: dict[str, Rgba] = {}
        self.glows: dict[str, bool] = {}

    @property
    def images(self) -> Cameras:
        """The cameras, drawn by the preferred renderer."""
        if self._images is None:
            self._images = self._open_painted(self._preferred)
        return self._images

    @property
    def depths(self) -> Cameras:
        """The renderer of depth and segments, the same for all: they do not depend on light or colour."""
        if self._depths is None:
            images = self.images
            self._depths = images if images.draws_depth else self._open_painted(RASTER)
        return self._depths

    def close(self) -> None:
        """Release the renderers; they open again when they are needed."""
        for cameras in self.opened:
            cameras.close()
        self.opened.clear()
        self._images = self._depths = None

    def _open_painted(self, renderer: str) -> Cameras:
        """Open a renderer and set the current colours."""
        cameras = self._open(renderer)
        for visual, rgba in self.colors.items():
            cameras.set_color(visual, rgba)
        for visual, glows in self.glows.items():
            cameras.set_glow(visual, glows)
        self.opened.append(cameras)
        return cameras


def open_shared(
    renderer: str,
    bodies: Mapping[str, Sequence[Body]],
    optics: Mapping[CameraPath, Optics],
    frames: Callable[[Sequence[BodyPath]], ReadFrames],
    lights: Sequence[Light],
) -> Cameras:
    """Open a renderer of the core.

    Args:
        renderer: ``raster`` or ``realistic``.
        bodies: the bodies of each model.
        optics: the cameras to draw.
        frames: returns a function that writes the poses of bodies.
        lights: the lights of the scene; ``raster`` draws without them.
    """
    if renderer == REALISTIC:
        from nrp_core.world.render.realistic import RealisticCameras

        return RealisticCameras(bodies, optics, frames, lights)
    from nrp_core.world.render.raster import RasterCameras

    return RasterCameras(bodies, optics, frames)
