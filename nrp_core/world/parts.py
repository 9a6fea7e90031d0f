"""The parts of a world: its own and those of the models in its scene, and commands that act late."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterator, Mapping, Sequence
from copy import deepcopy
from functools import cache
from typing import Any, NamedTuple

from nrp_core.clock import from_seconds
from nrp_core.errors import SceneError
from nrp_core.scene.merged_bodies import bodies_of, joint_inertias
from nrp_core.scene.model import Model
from nrp_core.world.controllers.joint import ControllerPart, GroupPart, OrientationPart, PairPart
from nrp_core.world.controllers.trajectory import TrajectoryPart
from nrp_core.world.drives.drive import Drive
from nrp_core.world.engine import Engine
from nrp_core.world.imperfection import imperfect
from nrp_core.world.model_states import ColorPart
from nrp_core.world.part import Part, PartProxy
from nrp_core.world.sensors.ground_truth import JointStatesPart
from nrp_core.world.sensors.sensor import Sensor
from nrp_core.world.switchboard import Switchboard


class _Pending(NamedTuple):
    due_ns: int
    topic: str
    message: Any


class DelayedPart(PartProxy):
    """A part that receives its commands late, at the first physics step after their delay.

    Args:
        inner: the part.
        delays: the delay of each delayed topic, s; messages on others arrive at once.
    """

    has_deadlines = True

    def __init__(self, inner: Part, delays: Mapping[str, float]) -> None:
        super().__init__(inner)
        self._delays_ns = {topic: from_seconds(delay) for topic, delay in delays.items()}
        self._pending: dict[str, deque[_Pending]] = {topic: deque() for topic in delays}

    @property
    def deadline_ns(self) -> int | None:  # type: ignore[override]
        waiting = [queue[0].due_ns for queue in self._pending.values() if queue]
        own_ns = self._inner_deadline_ns
        return min(waiting if own_ns is None else (*waiting, own_ns), default=None)

    @property
    def _inner_deadline_ns(self) -> int | None:
        return self.inner.deadline_ns if self.inner.has_deadlines else None

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        if topic not in self._delays_ns:
            self.inner.write(topic, message, now_ns)
            return
        due_ns = now_ns + self._delays_ns[topic]
        self._pending[topic].append(_Pending(due_ns, topic, deepcopy(message)))  # the sender may reuse it

    def at_deadline(self, now_ns: int) -> None:
        due = [
            queue.popleft()
            for queue in self._pending.values()
            for _ in range(sum(one.due_ns <= now_ns for one in queue))
        ]
        for one in sorted(due, key=lambda one: one.due_ns):
            self.inner.write(one.topic, one.message, now_ns)
        inner_ns = self._inner_deadline_ns
        if inner_ns is not None and inner_ns <= now_ns:
            self.inner.at_deadline(now_ns)

    def reset(self) -> None:
        for queue in self._pending.values():
            queue.clear()
        self.inner.reset()

    def save(self) -> object:
        return [one for queue in self._pending.values() for one in queue], self.inner.save()

    def restore(self, saved: Any) -> None:
        pending, inner = saved
        for queue in self._pending.values():
            queue.clear()
        for one in pending:
            self._pending[one.topic].append(one)
        self.inner.restore(inner)


def with_delays(part: Part, delays: Mapping[str, float]) -> Part:
    """Return a part with the delays of its topics, s, among those of a scene."""
    own = {topic.name: delays[topic.name] for topic in part.topics if topic.name in delays}
    return DelayedPart(part, own) if own else part


def parts_of(model: Model, engine: Engine) -> Iterator[Part]:
    """Return the parts that serve the topics of a model."""
    for link in model.links:
        for sensor in link.sensors:
            if not isinstance(sensor, Sensor):
                raise _type_error(f"sensor '{sensor.name}' of '{model.name}/{link.name}'", sensor, Sensor)
            yield sensor.part(model, link.name, engine)
        for visual in link.visuals:
            yield ColorPart(f"{model.name}/{link.name}/{visual.name}", visual.rgba, visual.glows, engine)
    for drive in (*model.drives, *engine.scene.drives):
        if not isinstance(drive, Drive):
            raise _type_error(f"drive '{drive.name}' of '{model.name}'", drive, Drive)
        yield drive.part(model, engine)
    yield from _controllers_of(model, engine)
    if model.joint_states_topic is not None:
        yield JointStatesPart(model, engine)


def _type_error(owner: str, data: object, base: type) -> SceneError:
    kind = type(data).__name__
    return SceneError(f"the {owner} is a {kind}, which is not a subclass of {base.__name__}")


def _controllers_of(model: Model, engine: Engine) -> Iterator[Part]:
    """Yield the parts of single joints before those of trajectories, so that integrals are updated first."""
    parts: dict[str, ControllerPart] = {}
    inertias = cache(lambda: joint_inertias(bodies_of(model)))
    of_balls = [each for each in model.controllers if model.joint(each.joint).kind == "ball"]
    yield from (OrientationPart(each, model.name, engine) for each in of_balls)
    names = [
        *(each.joint for each in model.controllers if each not in of_balls),
        *(name for each in model.leaders for name in each.joints),
    ]
    for joint in dict.fromkeys(names):
        controllers = [each for each in model.controllers if each.joint == joint]
        led = [each.of_joint(joint) for each in model.leaders if joint in each.joints]
        parts[joint] = ControllerPart(controllers, led, model, engine, inertias)
    yield from parts.values()
    for follower in model.trajectory_controllers:
        yield TrajectoryPart(follower, parts, model, engine)
    for pair in model.pair_controllers:
        yield PairPart(pair, parts, model, engine)
    for group in model.group_controllers:
        yield GroupPart(group, parts, model, engine)


class Parts:
    """The parts of a world.

    Args:
        engine: the engine that they read.
        board: the switchboard for their topics.

    Attributes:
        all: all parts, in the order in which they are reset and saved.
        timed: the parts with deadlines.
        pollers: the parts that receive messages from outside.
    """

    def __init__(self, engine: Engine, board: Switchboard) -> None:
        self._engine, self._board = engine, board
        self._own: list[Part] = []
        self._of_models: dict[str, list[Part]] = {}
        self._reported: frozenset[str] | None = None
        self.all: list[Part] = []
        self.timed: list[Part] = []
        self.pollers: list[Part] = []

    def of(self, model: str) -> Sequence[Part]:
        """Return the parts of a model."""
        return self._of_models[model]

    def open(self, own: Sequence[Part]) -> None:
        """Connect the parts of the world itself, and those of the first scene."""
        self._own = self._connect(own, None)
        self.update()

    def update(self, changed: Collection[str] = ()) -> None:
        """Connect the parts of the current models and disconnect all others.

        Args:
            changed: names of models that get new parts.
        """
        models = {model.name: model for model in self._engine.scene.models}
        for name in [name for name in self._of_models if name not in models or name in changed]:
            for part in self._of_models.pop(name):
                self._board.disconnect(part)
        for name, model in models.items():
            if name not in self._of_models:
                self._of_models[name] = self._connect(list(parts_of(model, self._engine)), model)
        self.all = [*self._own, *(part for name in models for part in self._of_models[name])]
        self.timed = [part for part in self.all if part.has_deadlines]
        self.pollers = [part for part in self.all if type(part).poll is not Part.poll]
        self._reported = None

    def _connect(self, usual: Sequence[Part], model: Model | None) -> list[Part]:
        delays = dict(self._engine.scene.command_delays)
        usual = [imperfect(part, self._engine) for part in usual]
        parts = [with_delays(part, delays) for part in self._engine.parts(usual, model)]
        for part in parts:
            self._board.connect(part, () if model is None else parts)
        return parts

    def begin(self) -> None:
        """Initialise the engine before the first step."""
        for part in self.all:
            part.begin()

    def report_subscriptions(self, subscribed: frozenset[str]) -> None:
        """Report the subscribed topics to the parts if they have changed."""
        if subscribed is not self._reported:
            self._reported = subscribed
            for part in self.pollers:
                part.on_subscriptions_changed(subscribed)

    def deliver(self) -> None:
        """Deliver the messages from outside."""
        for part in self.pollers:
            for topic, stamped in part.poll():
                self._board.push(topic, stamped)

    def reset(self) -> None:
        """Reset to the state at time 0; called after the engine's reset."""
        for part in self.all:
            part.reset()

    def save(self) -> list[object]:
        """Return the state that changes during a run."""
        return [part.save() for part in self.all]

    def restore(self, saved: Sequence[object]) -> None:
        """Restore a state from :meth:`save`; called after the engine was restored."""
        for part, state in zip(self.all, saved, strict=True):
            part.restore(state)
