"""Topics that several parts of a scene share: ROS allows it, a world allows one part per topic.

Two robots of one model would have one camera topic. The first robot keeps the name. For further robots the
robot's name comes before it; commands go to all of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import fields, replace
from typing import Any, TypeVar

from nrp_core.findings import Code, Findings
from nrp_core.world.scene.devices import JointController, PairController
from nrp_core.world.scene.model import Model, Scene
from nrp_core.world.topics import Stamped
from nrp_core.world.world import World

Part = TypeVar("Part")


class SharedTopics:
    """The topics of one scene, as its models come.

    Attributes:
        names: the topics that several parts would publish.
    """

    def __init__(self) -> None:
        self.names: list[str] = []
        self._taken: set[str] = set()
        self._further: dict[str, list[str]] = {}

    def in_room(self, room: Scene) -> Scene:
        """Return a room in which each topic belongs to one part."""
        models = tuple(map(self.in_model, room.models))
        findings = (warning for model in models for warning in model.warnings)
        return replace(room, models=models, warnings=tuple(dict.fromkeys((*room.warnings, *findings))))

    def in_model(self, model: Model) -> Model:
        """Return a model without topics of earlier models; renamed ones are reported."""
        findings = Findings()
        links = tuple(
            replace(link, sensors=tuple(self._alone(model, link.sensors, findings))) for link in model.links
        )
        drives = tuple(self._alone(model, model.drives, findings))
        controllers = tuple(self._alone(model, _each_once(model.controllers), findings))
        followers = tuple(self._alone(model, model.trajectory_controllers, findings))
        pairs = tuple(self._alone(model, model.pair_controllers, findings))
        states = model.joint_states_topic
        if states is not None:
            states = self._own(model, states, findings)
        warnings = (*model.warnings, *findings)
        return replace(
            model, links=links, drives=drives, controllers=controllers, trajectory_controllers=followers,
            pair_controllers=pairs, joint_states_topic=states, warnings=warnings,
        )  # fmt: skip

    def _alone(self, model: Model, parts: Iterable[Part], findings: Findings) -> Iterator[Part]:
        for part in parts:
            names = [field.name for field in fields(part) if field.name.endswith("topic")]  # type: ignore[arg-type]
            topics = {name: getattr(part, name) for name in names if getattr(part, name) is not None}
            changes = {}
            for name, topic in topics.items():
                is_command = name == "command_topic" or isinstance(part, JointController | PairController)
                own = self._own(model, topic, Findings() if is_command else findings)
                if own != topic:
                    changes[name] = own
                    if is_command:
                        self._further.setdefault(topic, []).append(own)
            yield replace(part, **changes) if changes else part  # type: ignore[type-var]

    def _own(self, model: Model, topic: str, findings: Findings) -> str:
        """Return a topic, under another name if it is taken."""
        own, number = topic, 1
        while own in self._taken:
            own = f"/{model.name}{topic}" + (f"_{number}" if number > 1 else "")
            number += 1
        self._taken.add(own)
        if own != topic:
            self.names.append(topic)
            message = f"'{topic}' is already in use: '{model.name}' publishes on '{own}'"
            findings.add(Code.NRP266, message, subject=topic)
        return own

    def hand_on(self, world: World) -> None:
        """Forward commands to all parts with the topic."""
        publications = {
            topic: [world.advertise(one) for one in ones] for topic, ones in self._further.items()
        }

        def pass_on(topic: str, stamped: Stamped) -> None:
            for publication in publications.get(topic, ()):
                publication.publish(stamped.message)

        if publications:
            world.add_observer(pass_on)


def _each_once(controllers: Iterable[JointController]) -> list[JointController]:
    """Return controllers without those that command the same joint by the same topic again."""
    found: dict[Any, JointController] = {}
    for one in controllers:
        found.setdefault((one.joint, one.kind, one.topic), one)
    return list(found.values())
