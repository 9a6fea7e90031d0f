"""Capabilities that robots, functions and events need and the chosen world lacks."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from nrp_core.checks.examined import ExaminedExperiment, checks_functions
from nrp_core.checks.subjects.time_conditions import topic_conditions
from nrp_core.dsl.parameters import SubscribedTopic
from nrp_core.findings import Code, Finding, Level
from nrp_core.findings.refusals import world_lacks
from nrp_core.scene.model import Scene
from nrp_core.world.sensors.contact import CONTACTS
from nrp_core.world.service import PREFIX

_SERVICES = {
    "set_model_state": "changes", "set_link_state": "changes", "set_model_configuration": "changes",
    "spawn_sdf_model": "changes", "spawn_urdf_model": "changes", "spawn_sdf_entity": "changes",
    "delete_model": "changes", "set_physics_properties": "changes",
    "apply_body_wrench": "joint_control", "apply_joint_effort": "joint_control",
}  # fmt: skip
"""The capability that each service needs."""


@checks_functions
def check_sensors(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report sensors that a function, an event or a criterion reads and the world does not simulate."""
    lacking = _lacking(examined, _senses)
    for function in examined.functions:
        for name, adapter in function.adapters.items():
            if isinstance(adapter, SubscribedTopic) and adapter.name in lacking:
                message = f"'{name}' gets no messages: {lacking[adapter.name]}"
                yield function.finding(Code.NRP216, message, parameter=name)
    for keys, condition in topic_conditions(examined.experiment):
        if condition.name in lacking:
            never = "never happens" if keys[0] == "events" else "is never met"
            message = f"'{keys[1]}' {never}: {lacking[condition.name]}"
            yield examined.warning(Code.NRP216, message, *keys, "name")


@checks_functions
def check_commands(examined: ExaminedExperiment) -> Iterator[Finding]:
    """Report joints, forces and changes that a function or an event commands and the world refuses."""
    lacking = _lacking(examined, _commands)
    for function in examined.functions:
        for topic, parameter in function.written:
            if topic in lacking:
                message = f"nothing reacts to messages on '{topic}': {lacking[topic]}"
                yield function.finding(Code.NRP216, message, Level.ERROR, parameter=parameter)
    for event, what in examined.experiment.events.items():
        for i, published in enumerate(what.publish):
            if published.topic in lacking:
                message = f"nothing reacts to '{published.topic}': {lacking[published.topic]}"
                place = examined.experiment.place("events", event, "publish", i, "topic")
                yield place.finding(Code.NRP216, message)


def _lacking(
    examined: ExaminedExperiment, needs: Callable[[Scene], Iterator[tuple[str, str]]]
) -> dict[str, str]:
    """Return the topics for which the world lacks capabilities, and these capabilities.

    The topics of a world with its own scene, such as a robot in ROS, are unknown.
    """
    if examined.world is None or examined.scene is None or examined.world.capabilities.own_scene:
        return {}
    has, backend = examined.world.capabilities, examined.experiment.world.backend
    return {
        topic: world_lacks(backend, need) for topic, need in needs(examined.scene) if not getattr(has, need)
    }


def _senses(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield the topic of each sensor, wheels included, with each capability that it needs."""
    for _, link in scene.links():
        for sensor in link.sensors:
            for need in sensor.needs:
                yield sensor.topic, need
    for model in scene.models:
        for topic in (model.joint_states_topic, *(drive.wheel_speeds_topic for drive in model.drives)):
            if topic is not None:
                yield topic, "dynamics"
    yield CONTACTS, "contacts"


def _commands(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield the topic of each command with the capability that it needs."""
    for model in scene.models:
        topics = [one.command_topic for one in model.trajectory_controllers]
        for controllers in (model.controllers, model.pair_controllers, model.group_controllers):
            topics += [one.topic for one in controllers]
        yield from ((topic, "joint_control") for topic in topics)
    for service, need in _SERVICES.items():
        yield f"{PREFIX}{service}", need
