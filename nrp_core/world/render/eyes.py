"""The cameras of a scene, opened when they are first looked through, in the colours of now."""

from __future__ import annotations

from collections.abc import Callable

from nrp_core.world.render.cameras import RASTER, Cameras
from nrp_core.world.scene.model import Rgba


class Eyes:
    """All cameras of a scene, by the preferred renderer and, where that draws no depth, by another one.

    Args:
        open_renderer: opens a renderer by its name.
        preferred: the name of the preferred renderer; empty where there are no cameras.

    Attributes:
        opened: the renderers that are open.
        colors: of visuals, by their paths, where they differ from the scene's.
        glows: likewise.
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
            self._images = self._painted(self._preferred)
        return self._images

    @property
    def depths(self) -> Cameras:
        """What draws depth: the same for every renderer, for it does not depend on light or colour."""
        if self._depths is None:
            images = self.images
            self._depths = images if images.draws_depth else self._painted(RASTER)
        return self._depths

    def close(self) -> None:
        """Release the renderers; they open again when they are needed."""
        for cameras in self.opened:
            cameras.close()
        self.opened.clear()
        self._images = self._depths = None

    def _painted(self, renderer: str) -> Cameras:
        """Open a renderer and give it the colours of now."""
        cameras = self._open(renderer)
        for visual, rgba in self.colors.items():
            cameras.set_color(visual, rgba)
        for visual, glows in self.glows.items():
            cameras.set_glow(visual, glows)
        self.opened.append(cameras)
        return cameras
