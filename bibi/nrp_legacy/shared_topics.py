"""Topics that several parts of a scene share: ROS allows it, a world allows one part per topic.

Two robots of one model would have one camera topic. The first robot keeps the name. For further robots the
robot's name comes before it; commands go to all of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import fields, replace
from typing import Any, TypeVar

from nrp_core.world.scene.acting import JointController
from nrp_core.world.scene.model import Model, Scene
from nrp_core.world.topics import Stamped
from nrp_core.world.world import World

Part = TypeVar("Part")


class SharedTopics:
    """The topics of one scene, as its models come.

    Attributes:
        names: the topics that several parts would serve.
    """

    def __init__(self) -> None:
        self.names: list[str] = []
        self._taken: set[str] = set()
        self._further: dict[str, list[str]] = {}

    def in_room(self, room: Scene) -> Scene:
        """Return a room in which each topic has one server."""
        models = tuple(map(self.in_model, room.models))
        told = (text for model in models for text in model.warnings)
        return replace(room, models=models, warnings=tuple(dict.fromkeys((*room.warnings, *told))))

    def in_model(self, model: Model) -> Model:
        """Return a model whose parts serve no topic that is served already; it tells what is renamed."""
        told: list[str] = []
        links = tuple(
            replace(link, sensors=tuple(self._alone(model, link.sensors, told))) for link in model.links
        )
        drives = tuple(self._alone(model, model.drives, told))
        controllers = tuple(self._alone(model, _each_once(model.controllers), told))
        followers = tuple(self._alone(model, model.trajectory_controllers, told))
        states = model.joint_states_topic
        if states is not None:
            states = self._own(model, states, told)
        warnings = (*model.warnings, *dict.fromkeys(told))
        return replace(
            model, links=links, drives=drives, controllers=controllers, trajectory_controllers=followers,
            joint_states_topic=states, warnings=warnings,
        )  # fmt: skip

    def _alone(self, model: Model, parts: Iterable[Part], told: list[str]) -> Iterator[Part]:
        for part in parts:
            names = [field.name for field in fields(part) if field.name.endswith("topic")]  # type: ignore[arg-type]
            topics = {name: getattr(part, name) for name in names if getattr(part, name) is not None}
            changes = {}
            for name, topic in topics.items():
                is_command = name == "command_topic" or isinstance(part, JointController)
                own = self._own(model, topic, [] if is_command else told)
                if own != topic:
                    changes[name] = own
                    if is_command:
                        self._further.setdefault(topic, []).append(own)
            yield replace(part, **changes) if changes else part  # type: ignore[type-var]

    def _own(self, model: Model, topic: str, told: list[str]) -> str:
        """Return a topic, under another name if it is taken."""
        own, number = topic, 1
        while own in self._taken:
            own = f"/{model.name}{topic}" + (f"_{number}" if number > 1 else "")
            number += 1
        self._taken.add(own)
        if own != topic:
            self.names.append(topic)
            told.append(f"'{topic}' is already in use: '{model.name}' publishes on '{own}'")
        return own

    def hand_on(self, world: World) -> None:
        """Let commands reach all parts that they are meant for."""
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
