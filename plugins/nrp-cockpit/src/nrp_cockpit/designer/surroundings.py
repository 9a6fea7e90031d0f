"""The topics of the robot and the populations of the brain, to which a model is connected."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from nrp_bibi.model.functions import Bibi

from nrp_core.experiment import Run
from nrp_core.messages.base import type_name
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.world.topics import Direction, TopicInfo


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic of the experiment.

    Args:
        name: the name.
        type: the message type in the form of models, ``geometry_msgs.msg.Twist``.
        is_sent: whether the world publishes it.
        is_heard: whether the world subscribes to it.
        rate_hz: messages per second; None: it has a current value instead.
        is_near: whether it is shown even if unused: topics of robots, and topics with an alias.
    """

    name: str
    type: str
    is_sent: bool = True
    is_heard: bool = False
    rate_hz: float | None = None
    is_near: bool = True


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The topics and populations of an experiment.

    Args:
        topics: by name.
        populations: the number of cells of each, by name; named groups first.
        others: the models of the other files of the experiment, by the names of the files.
    """

    topics: Mapping[str, Topic] = field(default_factory=dict)
    populations: Mapping[str, int] = field(default_factory=dict)
    others: Mapping[str, Bibi] = field(default_factory=dict)


def surroundings_of(run: Run) -> Surroundings:
    """Return the surroundings of transfer functions in a run."""
    network = run.brain.network
    cells = {name: len(ids) for name, ids in network.views.items()}
    others = {name: population.size for name, population in network.populations.items() if name not in cells}
    whole = {name: size for name, size in cells.items() if name in network.populations}
    named = {name: size for name, size in cells.items() if name not in whole}
    return Surroundings({topic.name: topic for topic in _topics(run)}, {**named, **whole, **others})


def _topics(run: Run) -> Iterator[Topic]:
    robots = tuple(f"/{name}/" for name in run.experiment.world.robots)
    for info in run.world.topics.values():
        if info.response is None:
            near = info.name in run.experiment.aliases or (
                info.name.startswith(robots) and info.type is not ColorRGBA
            )
            yield _topic(info, is_near=near)


def _topic(info: TopicInfo, *, is_near: bool) -> Topic:
    return Topic(
        info.name,
        type_name(info.type).replace("/", "."),
        is_sent=bool(info.direction & Direction.OUT),
        is_heard=bool(info.direction & Direction.IN),
        rate_hz=info.rate_hz,
        is_near=is_near,
    )
