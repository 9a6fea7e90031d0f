"""Sensors that the chosen world cannot simulate."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.analysis.registry import checks_experiment
from nrp_core.analysis.study import Study
from nrp_core.dsl.topics import SubscribedTopic
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.scene.model import Scene
from nrp_core.world.scene.sensing import Camera, ContactSensor, ForceTorque, GroundTruth, Imu, Laser

_NEEDS = {
    Camera: "renderers",
    Laser: "links",
    Imu: "links",
    GroundTruth: "links",
    ContactSensor: "contacts",
    ForceTorque: "joint_wrenches",
}
"""The capability of a world that a sensor rests on."""


@checks_experiment(Code.NRP216)
def the_world_has_the_sensors(study: Study) -> Iterator[Finding]:
    """Look for sensors that a function reads and the world backend does not simulate."""
    if study.world is None or study.scene is None:
        return
    needs = dict(_needs(study.scene))
    backend = study.experiment.world.backend
    for examined in study.examined:
        for name, adapter in examined.adapters.items():
            need = needs.get(adapter.name) if isinstance(adapter, SubscribedTopic) else None
            if need is not None and not getattr(study.world.capabilities, need):
                message = f"nothing comes for '{name}': the world backend '{backend}' has no {need}"
                node = examined.declared.nodes.get(name)
                yield examined.declared.finding(Code.NRP216, node, message, Level.WARNING)


def _needs(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield the topic of each sensor, wheels included, with the capability that it rests on."""
    for _, link in scene.links():
        for sensor in link.sensors:
            if type(sensor) in _NEEDS:
                yield sensor.topic, _NEEDS[type(sensor)]
    for model in scene.models:
        for topic in (model.joint_states_topic, *(drive.wheel_speeds_topic for drive in model.drives)):
            if topic is not None:
                yield topic, "dynamics"
