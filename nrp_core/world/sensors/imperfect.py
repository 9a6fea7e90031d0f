"""Sensors with additional imperfections: noise, delays, losses."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from nrp_core.errors import TopicError, did_you_mean
from nrp_core.world.scene.model import Model, Scene
from nrp_core.world.scene.sensing import MountedSensor, Noise


def with_imperfection(
    scene: Scene,
    topic: str,
    *,
    noise: Noise | None = None,
    delay: float | None = None,
    drop_out: float | None = None,
) -> Scene:
    """Return a scene with changed properties of the sensor on a topic; None keeps the value of the file.

    Args:
        scene: the scene.
        topic: its absolute topic.
        noise: noise on every number of the sensor.
        delay: delay of messages, s.
        drop_out: share of lost messages.

    Raises:
        TopicError: no sensor publishes on that topic.
    """
    given: dict[str, Any] = {"noise": noise, "delay": delay, "drop_out": drop_out}
    changes = {name: value for name, value in given.items() if value is not None}
    served = [each for _, link in scene.links() for sensor in link.sensors for each in sensor.topics]
    if topic not in served:
        raise TopicError(f"no sensor publishes '{topic}'{did_you_mean(topic, served)}")

    def changed(model: Model) -> Model:
        if all(topic not in sensor.topics for link in model.links for sensor in link.sensors):
            return model
        links = []
        for link in model.links:
            sensors = [_with(each, changes) if topic in each.topics else each for each in link.sensors]
            links.append(replace(link, sensors=tuple(sensors)))
        return replace(model, links=tuple(links))

    return replace(scene, models=tuple(map(changed, scene.models)))


def _with(sensor: MountedSensor, changes: dict[str, Any]) -> MountedSensor:
    """Return a sensor with other properties; noise on every number replaces that of some of them."""
    own: dict[str, Any] = dict.fromkeys(sensor.noises) if "noise" in changes else {}
    return replace(sensor, **changes, **own)
