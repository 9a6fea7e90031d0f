"""Capabilities that robots, functions and events need and the chosen world lacks."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from nrp_core.checks.static_experiment import StaticExperiment, checks_experiment
from nrp_core.checks.subjects.time_conditions import topic_conditions
from nrp_core.dsl.parameters import SubscribedTopic
from nrp_core.findings import Code, Finding
from nrp_core.findings.refusals import world_lacks
from nrp_core.scene.model import Scene
from nrp_core.world.capabilities import needs_of
from nrp_core.world.sensors.contact import CONTACTS
from nrp_core.world.service import PREFIX

_SERVICES = {
    "set_model_state": "changes", "set_link_state": "changes", "set_model_configuration": "changes",
    "spawn_sdf_model": "changes", "spawn_urdf_model": "changes", "spawn_sdf_entity": "changes",
    "delete_model": "changes", "set_physics_properties": "changes",
    "apply_body_wrench": "joint_control", "apply_joint_effort": "joint_control",
}  # fmt: skip
"""The capability that each service needs."""


@checks_experiment
def check_sensors(static: StaticExperiment) -> Iterator[Finding]:
    """Look for sensors that a function, an event or a criterion reads and the world does not simulate."""
    lacking = _lacking(static, _senses)
    for examined in static.functions:
        for name, adapter in examined.adapters.items():
            if isinstance(adapter, SubscribedTopic) and adapter.name in lacking:
                message = f"'{name}' gets no messages: {lacking[adapter.name]}"
                node = examined.declared.nodes.get(name)
                yield examined.warning(Code.NRP216, node, message)
    for keys, condition in topic_conditions(static.experiment):
        if condition.name in lacking:
            never = "never happens" if keys[0] == "events" else "is never met"
            message = f"'{keys[1]}' {never}: {lacking[condition.name]}"
            yield static.warning(Code.NRP216, message, *keys, "name")


@checks_experiment
def check_distances(static: StaticExperiment) -> Iterator[Finding]:
    """Look for events and criteria about distances in a world that does not report where models are."""
    if static.world is None or static.world.capabilities.poses:
        return
    experiment = static.experiment
    near = [name for name, event in experiment.events.items() if event.when and event.when.near]
    criteria = [name for name, asked in experiment.criteria.items() if asked.topic_stays is None]
    events = (("events", name, "when", "near") for name in near)
    for keys in (*events, *(("criteria", name) for name in criteria)):
        message = f"'{keys[1]}' needs a distance: {world_lacks(experiment.world.backend, 'poses')}"
        yield experiment.place(*keys).finding(Code.NRP216, message)


@checks_experiment
def check_commands(static: StaticExperiment) -> Iterator[Finding]:
    """Look for joints, forces and changes that a function or an event commands and the world refuses."""
    lacking = _lacking(static, _commands)
    for examined in static.functions:
        declared, returned = examined.declared, examined.returns_to
        topics = {"": returned.name} if returned is not None else {}
        topics |= {name: one.writes.name for name, one in examined.function.mappings.items() if one.writes}
        for name, topic in topics.items():
            if topic in lacking:
                message = f"nothing reacts to messages on '{topic}': {lacking[topic]}"
                yield declared.finding(Code.NRP216, declared.nodes.get(name), message)
    for event, what in static.experiment.events.items():
        for i, published in enumerate(what.publish):
            if published.topic in lacking:
                message = f"nothing reacts to '{published.topic}': {lacking[published.topic]}"
                place = static.experiment.place("events", event, "publish", i, "topic")
                yield place.finding(Code.NRP216, message)


@checks_experiment
def check_dynamics(static: StaticExperiment) -> Iterator[Finding]:
    """Look for models that need forces to move or hold, in a world without dynamics."""
    if static.world is None:
        return
    has, backend = static.world.capabilities, static.experiment.world.backend
    for model in static.models:
        held = [one.joint for one in model.controllers if one.initial is not None]
        lacking = [
            (j.name, need) for j in model.joints for need in needs_of(model, j) if not getattr(has, need)
        ]
        message = ""
        if not (has.dynamics or model.static or model.drives):
            message = f"'{model.name}' could not move: {world_lacks(backend, 'dynamics')}"
        elif held and not has.joint_control:
            message = f"'{model.name}' holds {held[0]}: {world_lacks(backend, 'joint_control')}"
        elif lacking and has.dynamics and not model.static:
            joint, need = lacking[0]
            message = f"'{model.name}/{joint}' could not move: {world_lacks(backend, need)}"
        if message:
            yield static.experiment.place(*static.keys_of(model.name)).finding(Code.NRP216, message)


def _lacking(static: StaticExperiment, needs: Callable[[Scene], Iterator[tuple[str, str]]]) -> dict[str, str]:
    """Return the topics for which the world lacks capabilities, with these capabilities."""
    if static.world is None or static.scene is None:
        return {}
    has, backend = static.world.capabilities, static.experiment.world.backend
    return {
        topic: world_lacks(backend, need) for topic, need in needs(static.scene) if not getattr(has, need)
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
