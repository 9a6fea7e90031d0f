"""The images on surfaces in the flat images of an engine's own renderer, from the core's."""

from __future__ import annotations

from nrp_core.world.render.cameras import Cameras, ImageArray
from nrp_core.world.render.optics import CameraPath
from nrp_core.world.render.raster import RasterCameras
from nrp_core.world.scene.model import Rgba


class ImagedCameras(Cameras):
    """An engine's own renderer, with images on surfaces.

    Args:
        own: the engine's renderer, which draws flat colours.
        images: draws the images, and is not closed: it holds nothing.
    """

    def __init__(self, own: Cameras, images: RasterCameras) -> None:
        self._own, self._images = own, images

    def image(self, path: CameraPath) -> ImageArray:
        image = self._own.image(path)
        self._images.lay_images(path, image)
        return image

    def set_color(self, visual: str, rgba: Rgba) -> None:
        self._own.set_color(visual, rgba)
        self._images.set_color(visual, rgba)

    def close(self) -> None:
        self._own.close()
