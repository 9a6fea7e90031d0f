"""An engine for dry runs: sensors with the sizes and names of the scene, and arbitrary values in range."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, Final

import numpy as np

from nrp_core._support.arrays import FloatArray
from nrp_core.dsl.testing import MockEngine, MockPart
from nrp_core.scene.model import Joint, Model, Rgba, Scene
from nrp_core.scene.posture import start_positions
from nrp_core.scene.rigid import JointStates, ModelMotion, Wrench
from nrp_core.world.part import Part, PartProxy
from nrp_core.world.raycast.beams import Beams
from nrp_core.world.render.cameras import (
    CameraPath,
    Cameras,
    DepthArray,
    ImageArray,
    Optics,
    SegmentArray,
)
from nrp_core.world.sensors.engine_sensor import EngineSensor
from nrp_core.world.topics import TopicInfo

_SLIGHT: Final = 0.01
"""Positions and velocities differ by this from 0, at which no formula would be tried out, rad or m."""
_ACTUATOR: Final = (0.1, 0.01, 1.0, 0.5)
"""Length, velocity, tension and activation of each muscle and actuator, SI."""
_FARTHEST_M: Final = 10.0


class DryEngine(MockEngine):
    """An engine whose models do not move, but whose sensors measure something.

    Args:
        scene: the models.
        step_ns: its physics step.
        topics: the topics of the world itself, of which only the types and the names of elements are known.
        image_scale: factor of the width and height of images.

    Attributes:
        unknown: the topics whose messages are empty, because the scene does not define their content.
    """

    renderers = ("dry",)

    def __init__(
        self, scene: Scene, *, step_ns: int, topics: Sequence[TopicInfo] = (), image_scale: float = 1.0
    ) -> None:
        super().__init__(scene, step_ns=step_ns, topics=topics)
        self.image_scale = image_scale
        self.unknown: set[str] = set()
        self._random = np.random.default_rng(0)

    def parts(self, usual: Sequence[Part], model: Model | None) -> Sequence[Part]:
        return [_DryPart(part, self.unknown) for part in super().parts(usual, model)]

    def _do_model_motion(self, model: str) -> ModelMotion:
        slight = (_SLIGHT, _SLIGHT, _SLIGHT)
        return ModelMotion(self.scene.model(model).pose, slight, slight)

    def _do_link_motion(self, model: str, link: str) -> ModelMotion:
        return self._do_model_motion(model).at(self.scene.model(model).link(link).pose)

    def _do_joint_states(self, model: str) -> JointStates:
        one = self.scene.model(model)
        start = dict(start_positions(one))
        positions = [
            _position(joint, start.get(joint.name, 0.0)) for joint in one.joints for _ in joint.coordinates
        ]
        names = tuple(name for joint in one.joints for name in joint.coordinates)
        return JointStates(names, np.array(positions), *np.full((2, len(names)), _SLIGHT))

    def _do_actuator_states(self, model: str, actuators: Sequence[str]) -> FloatArray:
        return np.tile(np.array(_ACTUATOR)[:, None], len(actuators))

    def _do_sensor_values(self, model: str, sensor: str) -> FloatArray:
        links = self.scene.model(model).links
        own = [one for link in links for one in link.sensors if isinstance(one, EngineSensor)]
        kinds = ((one.form, kind) for one in own for kind, name in one.sources if name == sensor)
        form, kind = next(kinds, ("number", ""))
        if kind.endswith("quat"):
            return np.array([1.0, 0.0, 0.0, 0.0])
        return np.full(1 if form in ("number", "range") else 3, _SLIGHT)

    def _do_joint_wrench(self, model: str, joint: str) -> Wrench:
        return Wrench((_SLIGHT, _SLIGHT, _SLIGHT), (_SLIGHT, _SLIGHT, _SLIGHT))

    def _do_scan(self, model: str, link: str, beams: Beams) -> FloatArray:
        low, high = beams.reach
        return self._random.uniform(low, min(high, low + _FARTHEST_M), beams.samples * beams.layers)

    def _do_open_cameras(self, renderer: str) -> Cameras:
        return _DryCameras(self._optics)


class _DryCameras(Cameras):
    """Draws arbitrary pixels, distances and labels."""

    draws_depth = True

    def __init__(self, optics: Mapping[CameraPath, Optics]) -> None:
        self._optics, self._random = optics, np.random.default_rng(1)

    def _size(self, path: CameraPath) -> tuple[int, int]:
        return self._optics[path].height, self._optics[path].width

    def image(self, path: CameraPath) -> ImageArray:
        return self._random.integers(0, 256, (*self._size(path), 3), np.uint8)

    def depth(self, path: CameraPath) -> DepthArray:
        near, far = self._optics[path].near, self._optics[path].far
        return self._random.uniform(near, min(far, near + _FARTHEST_M), self._size(path)).astype(np.float32)

    def segments(self, path: CameraPath) -> SegmentArray:
        return self._random.integers(0, 2, (*self._size(path), 2), np.int32)

    def set_color(self, visual: str, rgba: Rgba) -> None: ...

    def close(self) -> None: ...


class _DryPart(PartProxy):
    """A part that measures at once and does nothing.

    Args:
        inner: the part.
        unknown: receives the topics that cannot be measured, whose messages are empty.
    """

    has_deadlines = False
    deadline_ns = None

    def __init__(self, inner: Part, unknown: set[str]) -> None:
        super().__init__(inner)
        self.topics = tuple(replace(topic, delay=0.0, drop_out=0.0) for topic in inner.topics)
        self._kinds = {topic.name: topic for topic in inner.topics}
        self._unknown = unknown

    def read(self, topic: str, now_ns: int) -> Any:
        if not isinstance(self.unwrapped, MockPart):
            with suppress(Exception):  # a sensor of a third party may need its own engine
                return super().read(topic, now_ns)
        message, elements = self._kinds[topic].type(), self._kinds[topic].elements
        if elements and hasattr(message, "data"):
            message.data = [_SLIGHT] * len(elements)
        else:
            self._unknown.add(topic)
        return message

    def write(self, topic: str, message: Any, now_ns: int) -> None: ...

    def prepare_sample(self, topic: str, now_ns: int) -> None:
        with suppress(Exception):
            super().prepare_sample(topic, now_ns)

    def begin(self) -> None: ...


def _position(joint: Joint, start: float) -> float:
    """Return a position of a joint within its limits, rad or m."""
    return min(max(start + _SLIGHT, joint.lower), joint.upper)
