"""Sensors made worse than their files have them: noise, delays, losses."""

from __future__ import annotations

from dataclasses import fields, replace

from nrp_core.errors import SceneError, did_you_mean
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
    """Return a scene whose sensor on a topic is as told; what is None stays as its file has it.

    Args:
        scene: the scene.
        topic: absolute.
        noise: on every number of the sensor.
        delay: s.
        drop_out: share of the messages that get lost.

    Raises:
        SceneError: no sensor serves that topic.
    """
    given = {"noise": noise, "delay": delay, "drop_out": drop_out}
    changes = {name: value for name, value in given.items() if value is not None}
    served = [each for _, link in scene.links() for sensor in link.sensors for each in _topics(sensor)]
    if topic not in served:
        raise SceneError(f"no sensor publishes '{topic}'{did_you_mean(topic, served)}")

    def changed(model: Model) -> Model:
        if all(topic not in _topics(sensor) for link in model.links for sensor in link.sensors):
            return model
        links = []
        for link in model.links:
            sensors = [replace(each, **changes) if topic in _topics(each) else each for each in link.sensors]  # type: ignore[arg-type]
            links.append(replace(link, sensors=tuple(sensors)))
        return replace(model, links=tuple(links))

    return replace(scene, models=tuple(map(changed, scene.models)))


def _topics(sensor: MountedSensor) -> list[str]:
    """Return the topics that a sensor serves: what it measures may be told in several forms."""
    topics = (getattr(sensor, field.name) for field in fields(sensor) if field.name.endswith("topic"))
    return [topic for topic in topics if topic is not None]
