"""The cameras of a scene, drawn by Gazebo's own renderer; images arrive in shared memory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import atan, tan

import numpy as np

from nrp_core.world import Capsule, Light, Model, Pose, Rgba, Visual
from nrp_core.world.render.cameras import CameraPath, Cameras, ImageArray, Optics, camera_pose, looking
from nrp_world_gazebo.build import Built
from nrp_world_gazebo.elements import link_name
from nrp_world_gazebo.lights import direction_of, range_of
from nrp_world_gazebo.wire import named, operation


def bytes_of(optics: Optics) -> int:
    """Return the size of an image."""
    return 3 * optics.width * optics.height


class GazeboCameras(Cameras):
    """Gazebo's renderer.

    Args:
        built: the scene.
        models: the same as data.
        optics: of each camera, as Gazebo was started with.
    """

    def __init__(self, built: Built, models: Sequence[Model], optics: Mapping[CameraPath, Optics]) -> None:
        self._gazebo, self._optics = built.gazebo, optics
        self._numbers = {path: number for number, path in enumerate(optics)}
        sizes = [bytes_of(each) for each in optics.values()]
        self._offsets = np.cumsum([0, *sizes]).tolist()
        self._looks = {path: (visual.rgba, visual.glows) for path, visual in _visuals(models)}
        self._names = dict(_names(built, models))
        for path, offset in zip(optics, self._offsets, strict=False):
            self._gazebo.do(self._camera(built, path, offset))

    def image(self, path: CameraPath) -> ImageArray:
        number, optics = self._numbers[path], self._optics[path]
        self._gazebo.ask(operation("i", number))
        start = self._offsets[number]
        drawn = np.frombuffer(self._gazebo.images, np.uint8, bytes_of(optics), start)
        return drawn.reshape(optics.height, optics.width, 3).copy()

    def set_color(self, visual: str, rgba: Rgba) -> None:
        self._paint(visual, rgba, self._looks[visual][1])

    def set_glow(self, visual: str, glows: bool) -> None:
        self._paint(visual, self._looks[visual][0], glows)

    def set_lights(self, lights: Sequence[Light]) -> None:
        for light in lights:
            red, green, blue, _ = light.diffuse
            _, *factors = light.attenuation
            row = (red, green, blue, *light.pose.position, *direction_of(light), range_of(light), *factors)
            self._gazebo.do(named("l", light.name, row))
        self._gazebo.refresh()

    def _paint(self, visual: str, rgba: Rgba, glows: bool) -> None:
        self._looks[visual] = rgba, glows
        for name in self._names[visual]:
            self._gazebo.do(named("k", name, (*rgba, float(glows))))

    def _camera(self, built: Built, path: CameraPath, offset: int) -> bytes:
        """Return the operation that adds a camera, which looks along x in Gazebo."""
        bodies, optics = built.bodies[path[0]], self._optics[path]
        index, eye = camera_pose([body for body, _ in bodies], path)
        place = bodies[index][1]
        pose = place.held @ eye @ looking(Pose()).inverse()
        across = 2 * atan(tan(optics.vertical_fov / 2) * optics.width / optics.height)
        row = (*pose.position, *pose.orientation, across, optics.near, optics.far)
        return operation("C", place.link, optics.width, optics.height, offset, values=row)


def _visuals(models: Sequence[Model]) -> Iterator[tuple[str, Visual]]:
    for model in models:
        for link in model.links:
            for visual in link.visuals:
                yield f"{model.name}/{link.name}/{visual.name}", visual


def _names(built: Built, models: Sequence[Model]) -> Iterator[tuple[str, list[str]]]:
    """Yield each visual with the names of its parts in Gazebo."""
    for model in models:
        for body, _ in built.bodies[model.name]:
            for link in body.links:
                for visual in link.visuals:
                    path = f"{model.name}/{link.name}/{visual.name}"
                    if model.name in built.own:
                        yield path, [f"{model.name}::{link.name}::{visual.name}"]
                        continue
                    there = f"{model.name}::{link_name(body)}::{link.name}/{visual.name}"
                    ends = ["/end0", "/end1"] if isinstance(visual.geometry, Capsule) else []
                    yield path, [there, *(there + end for end in ends)]
