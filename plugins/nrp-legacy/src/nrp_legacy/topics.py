"""Topics of a scene as on the platform, where parts share them and functions use both directions.

Two robots of one model would have one camera topic. The first robot keeps the name. For further robots the
robot's name comes before it; commands go to all of them. Functions read commands to a robot, and publish on
topics that the robot publishes. Topics also have the names of other versions of the platform, and command
joints without a known plugin.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, Literal, TypeVar

from nrp_core.dsl import Topic, TransferFunction, message_type
from nrp_core.findings import Code, Finding, Findings
from nrp_core.messages.base import type_name
from nrp_core.world import (
    Direction,
    JointController,
    Model,
    PairController,
    Scene,
    Stamped,
    TrajectoryController,
    World,
)
from nrp_legacy.shims.modules import OpenMessage

Kind = Literal["position", "velocity", "effort"]

_PLACE = r"%[sd]|\{\w*\}|[\"']\s*\+[^\"'\n]*\+\s*[\"']"
"""Where code puts a name, or a part of one, in."""
_JOINT = rf"(?P<joint>(?:[\w-]|{_PLACE})+?)"
"""The name of a joint."""
_LEAD = rf"(?P<lead>(?:(?:[\w-]|{_PLACE})+/)*)"
"""What comes before it: the name of the robot, perhaps, which code may put in."""
_TOPIC = re.compile(rf"""["']/?{_LEAD}{_JOINT}(?P<end>/(?:cmd_)?(?:pos|vel|effort|torque))/?["']""")
_CONTROLLER = re.compile(
    rf"""["']/?{_LEAD}{_JOINT}"""
    r"""(?P<end>(?:_(?:position|velocity|effort|pos|vel))?_(?:controller|cntr)/command)["']"""
)
_TRAJECTORY = re.compile(r"""["']/?(?P<topic>[\w/-]+)["']\s*,\s*(?:\w+\s*=\s*)?(?:\w+\.)*JointTrajectory\b""")
"""A topic with its type, as publishers are made."""
_KINDS: dict[str, Kind] = {"vel": "velocity", "eff": "effort", "tor": "effort"}


def with_commanded_joints(model: Model, sources: Iterable[str], others: Collection[str] = ()) -> Model:
    """Return a robot with a controller for each of its joints that some code commands by its name.

    Topics of trajectories command all of its joints.

    Args:
        model: the robot.
        sources: the code of the transfer functions and state machines.
        others: the names of other robots; topics that begin with one are not for this robot.
    """
    free = {joint.name for joint in model.joints if joint.takes_commands}
    driven = {(controller.joint, controller.kind) for controller in model.controllers}
    served = {controller.topic for controller in model.controllers}
    sources = list(sources)
    followers = (*model.trajectory_controllers, *_followers(model, sources, sorted(free), others))
    served |= {follower.command_topic for follower in followers}
    added = [
        JointController(joint, kind, topic, gains=None)
        for topic, joint, kind in dict.fromkeys(_commands(model.name, sources, sorted(free)))
        if (joint, kind) not in driven and topic not in served and topic.split("/")[1] not in others
    ]
    controllers = (*model.controllers, *added)
    warnings = tuple(
        warning for warning in model.warnings if not ((controllers or followers) and _is_served(warning))
    )
    return replace(model, controllers=controllers, trajectory_controllers=followers, warnings=warnings)


def _is_served(warning: Finding) -> bool:
    """Return whether a warning is about the plugin that these controllers replace."""
    return warning.code is Code.NRP260 and warning.subject == "gazebo_ros_control"


def _followers(
    model: Model, sources: Iterable[str], joints: Collection[str], others: Collection[str]
) -> Iterator[TrajectoryController]:
    """Yield a controller for each topic of trajectories in some code that the file does not have."""
    taken = {follower.command_topic for follower in model.trajectory_controllers}
    found = dict.fromkeys(each["topic"] for source in sources for each in _TRAJECTORY.finditer(source))
    for topic in found if joints else ():
        if f"/{topic}" not in taken and topic.split("/")[0] not in others:
            yield TrajectoryController(topic, f"/{topic}", tuple(joints))


def _commands(model: str, sources: Iterable[str], joints: Collection[str]) -> Iterator[tuple[str, str, Kind]]:
    """Yield the topics in some code, with the joints that they name; all joints if the name is computed.

    A computed name before it is taken for the robot's.
    Joints that trajectories move get their own topics, so that they hold their positions.
    """
    for source in sources:
        if "JointTrajectory" in source:
            for joint in joints:
                if re.search(rf"""["'](?:[\w-]+::)*{re.escape(joint)}["']""", source):
                    yield f"/{model}/{joint}/cmd_pos", joint, "position"
        for found in (*_TOPIC.finditer(source), *_CONTROLLER.finditer(source)):
            named = re.compile(re.sub(_PLACE, r"[\\w-]+", found["joint"]))
            lead = re.sub(_PLACE, model, found["lead"])
            for joint in filter(named.fullmatch, joints):
                yield f"/{lead}{joint}{found['end']}", joint, _kind(found["end"])


def _kind(end: str) -> Kind:
    return next((kind for part, kind in _KINDS.items() if part in end), "position")


HEARD, UNHEARD, MISTYPED = "/heard", "/unheard", "/mistyped"
"""Prefixes of topics to a robot, of topics without a receiver, and of topics with another type."""


def plain_name(topic: Topic) -> str:
    """Return the name of a topic in the user's code, redirected or not."""
    lead = next((lead for lead in (HEARD, UNHEARD, MISTYPED) if topic.name.startswith(f"{lead}/")), "")
    return topic.name.removeprefix(lead)


def redirect_topics(functions: Sequence[TransferFunction], world: World, aliases: Mapping[str, str]) -> None:
    """Redirect reading and publishing against the direction of a topic.

    Args:
        functions: the transfer functions, not bound.
        world: the world.
        aliases: the topics by their further names.
    """
    redirect = _Redirection(world, aliases)
    for function in functions:
        if function.topic is not None:
            function.topic = redirect.published(function.topic)
        for mapping in function.mappings.values():
            if mapping.writes is not None:
                mapping.writes = redirect.published(mapping.writes)
            if mapping.reads is not None:
                mapping.reads = redirect.read(mapping.reads)


class _Redirection:
    def __init__(self, world: World, aliases: Mapping[str, str]) -> None:
        self._world, self._aliases = world, aliases

    def published(self, topic: Topic) -> Topic:
        """Return a topic for messages to a topic that only the robot publishes."""
        sent = "messages of the other type reach nothing"
        mistyped = self._mistyped(topic, sent)
        if mistyped is not None:
            self._world.subscribe(mistyped.name)  # the finding says what happens to them
            return mistyped
        return self._beside(topic, UNHEARD, Direction.IN)[0]

    def read(self, topic: Topic) -> Topic:
        """Return a topic that repeats the messages to a topic that only the robot reads."""
        topic = self._known(topic)
        mistyped = self._mistyped(topic, "a subscriber with the other type gets no messages")
        if mistyped is not None:
            return mistyped
        beside, is_new = self._beside(topic, HEARD, Direction.OUT)
        if is_new:
            self._repeat(beside.name.removeprefix(HEARD), beside.name)
        return beside

    def _known(self, topic: Topic) -> Topic:
        """Return a topic with the type in the world, if the user's type is unknown but has the same name."""
        info, kind = self._world.topics.get(plain_name(topic)), topic.topic_type
        is_open = isinstance(kind, type) and issubclass(kind, OpenMessage)
        same = info is not None and is_open and kind.__name__ == info.type.__name__
        return replace(topic, topic_type=info.type) if info is not None and same else topic

    def _mistyped(self, topic: Topic, effect: str) -> Topic | None:
        """Return a silent topic for one with other messages, as such connections fail in ROS."""
        name, kind = plain_name(topic), topic.topic_type
        info = self._world.topics.get(name)
        if info is None or kind is None or type_name(kind) == type_name(info.type):
            return None
        beside = replace(topic, name=f"{MISTYPED}{name}")
        if beside.name not in self._world.topics:
            self._world.declare(beside.name, message_type(kind))
            carried = f"'{name}' carries {type_name(info.type)}, not {type_name(message_type(kind))}"
            self._world.warnings.add(Code.NRP282, f"{carried}: {effect}", subject=name)
        return beside

    def _beside(self, topic: Topic, lead: str, wanted: Direction) -> tuple[Topic, bool]:
        name = plain_name(topic)
        info = self._world.topics.get(name)
        if info is None or info.direction & wanted:
            return topic, False
        beside = replace(topic, name=f"{lead}{name}")
        is_new = beside.name not in self._world.topics
        if is_new:
            self._world.declare(beside.name, info.type)
        return beside, is_new

    def _repeat(self, name: str, beside: str) -> None:
        served, repeated = self._aliases.get(name, name), self._world.advertise(beside)

        def repeat(topic: str, stamped: Stamped) -> None:
            if topic == served:
                repeated.publish(stamped.message)

        self._world.add_observer(repeat)


_JOINTS = "/joints"
"""The end of the name of the iCub's topic for joint states."""


def find_alias(name: str, kind: Any, world: World) -> str | None:
    """Return the one topic that exists under another prefix than this name, if there is one.

    Args:
        name: the name in a transfer function.
        kind: the message type in the transfer function, None for any.
        world: the world, before further topics are declared.
    """
    if name in world.topics:
        return None
    served = [
        topic.name
        for topic in world.topics.values()
        if _differ_by_prefix(name, topic.name) and (kind is None or type_name(kind) == type_name(topic.type))
    ]
    if not served and name.endswith(_JOINTS):
        return find_alias(name.removesuffix(_JOINTS) + "/joint_states", kind, world) or _states(name, world)
    return served[0] if len(served) == 1 else None


def _states(name: str, world: World) -> str | None:
    states = name.removesuffix(_JOINTS) + "/joint_states"
    return states if states in world.topics else None


def _differ_by_prefix(name: str, served: str) -> bool:
    """Whether two names agree once the first part of one of them, or of both, is omitted."""
    name_rest, served_rest = _without_prefix(name), _without_prefix(served)
    if not served_rest:
        return False
    return served_rest in (name, name_rest) or bool(name_rest and name_rest == served)


def _without_prefix(name: str) -> str:
    """Return a name without its first part, empty where nothing is left."""
    rest = name.removeprefix("/").partition("/")[2]
    return f"/{rest}" if rest else ""


Part = TypeVar("Part")


class SharedTopics:
    """The topics of one scene, added with its models.

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
            topics = {name: getattr(part, name) for name in names if getattr(part, name)}
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
