"""The renderers of the core, imported when one is opened: their compiled code takes time to load."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from nrp_core.world.render.cameras import REALISTIC, Cameras
from nrp_core.world.render.optics import CameraPath, Optics
from nrp_core.world.rigid.motion import BodyPath, ReadFrames
from nrp_core.world.scene.merged_bodies import Body
from nrp_core.world.scene.model import Light


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
    from nrp_core.world.render.raster import RasterCameras
    from nrp_core.world.render.realistic import RealisticCameras

    if renderer == REALISTIC:
        return RealisticCameras(bodies, optics, frames, lights)
    return RasterCameras(bodies, optics, frames)


def with_images(
    own: Cameras,
    bodies: Mapping[str, Sequence[Body]],
    optics: Mapping[CameraPath, Optics],
    frames: Callable[[Sequence[BodyPath]], ReadFrames],
) -> Cameras:
    """Return an engine's own flat renderer, in which images on surfaces are drawn by the core."""
    links = (link for parts in bodies.values() for body in parts for link in body.links)
    if not any(visual.texture for link in links for visual in link.visuals):
        return own
    from nrp_core.world.render.imaged import ImagedCameras
    from nrp_core.world.render.raster import RasterCameras

    return ImagedCameras(own, RasterCameras(bodies, optics, frames))
