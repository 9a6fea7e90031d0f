"""The world side: what a physics engine must offer to take part in the loop.

A minimal backend steps its engine, tells where models are, takes a body velocity, renders a camera and
changes a colour. Topics, messages, rates, time-outs and odometry are supplied here, once for
all backends, by the parts in :mod:`nrp_core.world.parts`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite
from types import MappingProxyType
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict

from nrp_core.clock import SampleSchedule, milliseconds
from nrp_core.diagnosis import Diagnosis
from nrp_core.errors import CapabilityError, DivergedError, TimestepError, TopicError, did_you_mean
from nrp_core.simulation import INTERFACE_VERSION, Determinism, Simulation
from nrp_core.world.messages.base import type_name
from nrp_core.world.parts.base import BodyVelocity, Engine, JointStates, ModelMotion, Part
from nrp_core.world.parts.build import parts_of
from nrp_core.world.scene.model import Rgba, Scene
from nrp_core.world.topics import Direction, Publication, Stamped, Subscription, TopicInfo

ImageArray = npt.NDArray[np.uint8]


class WorldOptions(BaseModel):
    """Base of a backend's options, as an experiment file gives them; unknown names are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


@dataclass(frozen=True, slots=True)
class WorldCapabilities:
    """What a world backend has, asked as questions.

    Args:
        step_ns: what is its physics step?
        determinism: how far do two runs agree?
        renderers: which camera renderers are there, the preferred one first? None: no cameras.
        snapshot: can its state be saved and restored?
        releases_gil: can it step while Python code runs in another thread?
    """

    step_ns: int
    determinism: Determinism = Determinism.MACHINE
    renderers: tuple[str, ...] = ()
    snapshot: bool = False
    releases_gil: bool = False


@dataclass(slots=True)
class _Sampling:
    """A topic with a rate that somebody listens to, and when its next sample is due."""

    schedule: SampleSchedule
    subscriptions: list[Subscription]
    due_ns: int = 0


class World(Simulation, Engine):
    """A scene in a physics engine, at a time.

    Args:
        scene: what is simulated.
        seed: the experiment's seed for the world.
        capabilities: what the backend has.
        identity: text that names backend and options.
    """

    def __init__(self, scene: Scene, *, seed: int, capabilities: WorldCapabilities, identity: str) -> None:
        super().__init__(seed=seed, identity=f"{identity}:{scene.digest}")
        self.scene = scene
        self.capabilities = capabilities
        self.warnings: list[str] = list(scene.warnings)
        self._at_ns = 0
        self._started = False
        self._parts: dict[str, Part] = {}
        self._topics: dict[str, TopicInfo] = {}
        self._aliases: dict[str, str] = {}
        self._rated: dict[str, _Sampling] = {}
        self._bus: dict[str, list[Subscription]] = {}
        self._subscriptions: list[Subscription] = []
        self._observers: list[Callable[[str, Stamped], None]] = []
        self._movable = [model.name for model in scene.models if not model.static]
        self._all_parts = parts_of(scene, self)
        self._timed_parts = [
            part for part in self._all_parts if type(part).at_deadline is not Part.at_deadline
        ]
        for part in self._all_parts:
            for topic in part.topics:
                self._serve(topic, part)

    # -- topics

    @property
    def topics(self) -> Mapping[str, TopicInfo]:
        """Every topic by its name, aliases included."""
        aliases = {alias: replace(self._topics[name], name=alias) for alias, name in self._aliases.items()}
        return MappingProxyType({**self._topics, **aliases})

    def add_alias(self, alias: str, topic: str) -> None:
        """Serve a topic under one more name.

        Raises:
            TopicError: the name is taken, or there is no such topic.
        """
        self._require_free(alias)
        self._aliases[alias] = self._info(topic).name

    def declare(self, name: str, type_: type) -> None:
        """Add a topic of the user's own, which only carries what is published on it.

        Raises:
            TopicError: the name is taken.
        """
        self._require_free(name)
        self._topics[name] = TopicInfo(name, type_, Direction.BOTH, what="declared by the experiment")
        self._bus[name] = []

    @final
    def subscribe(self, topic: str, *, depth: int = 1) -> Subscription:
        """Listen to a topic from now on.

        Args:
            topic: its name or an alias.
            depth: how many messages the subscription keeps.

        Raises:
            TopicError: there is no such topic, or it only takes messages.
        """
        info = self._require(topic, Direction.OUT)
        if info.name in self._bus:
            subscription = Subscription(info, depth)
            self._bus[info.name].append(subscription)
        elif info.rate_hz is None:
            subscription = Subscription(info, depth, partial(self._read_now, info.name))
        else:
            subscription = Subscription(info, depth)
            if info.name not in self._rated:
                schedule = SampleSchedule.of(info.rate_hz, self.capabilities.step_ns)
                self._rated[info.name] = _Sampling(schedule, [])
                self._plan_samples()
            self._rated[info.name].subscriptions.append(subscription)
        self._subscriptions.append(subscription)
        return subscription

    @final
    def unsubscribe(self, subscription: Subscription) -> None:
        """End a subscription; a topic that nobody reads costs nothing."""
        if subscription not in self._subscriptions:
            return
        name = subscription.topic.name
        self._subscriptions.remove(subscription)
        if name in self._rated:
            self._rated[name].subscriptions.remove(subscription)
            if not self._rated[name].subscriptions:
                del self._rated[name]
        elif name in self._bus:
            self._bus[name].remove(subscription)

    @property
    def subscribed(self) -> frozenset[str]:
        """The topics that somebody listens to, never by an alias."""
        return frozenset(subscription.topic.name for subscription in self._subscriptions)

    @final
    def advertise(self, topic: str) -> Publication:
        """Return the right to publish on a topic.

        Raises:
            TopicError: there is no such topic, or it takes no messages.
        """
        info = self._require(topic, Direction.IN)
        return Publication(replace(info, name=topic), partial(self._deliver, info.name))

    @final
    def add_observer(self, observer: Callable[[str, Stamped], None]) -> None:
        """Show an observer every message that anybody publishes, with its topic (never an alias)."""
        self._observers.append(observer)

    @final
    def remove_observer(self, observer: Callable[[str, Stamped], None]) -> None:
        """Show an observer nothing more."""
        self._observers.remove(observer)

    def _require_free(self, name: str) -> None:
        if not name.startswith("/"):
            raise TopicError(f"the names of topics are absolute: '/{name}', not '{name}'")
        if name in self._topics or name in self._aliases:
            raise TopicError(f"there is a topic '{name}' already")

    def _info(self, topic: str) -> TopicInfo:
        name = self._aliases.get(topic, topic)
        if name not in self._topics:
            raise TopicError(f"no topic '{topic}'{did_you_mean(topic, self.topics)}")
        return self._topics[name]

    def _require(self, topic: str, direction: Direction) -> TopicInfo:
        self._require_open()
        info = self._info(topic)
        if not info.direction & direction:
            verb = "takes" if direction is Direction.OUT else "gives"
            raise TopicError(f"the topic '{topic}' ({type_name(info.type)}) only {verb} messages")
        return info

    def _serve(self, topic: TopicInfo, part: Part) -> None:
        if topic.name in self._topics:
            raise TopicError(f"two parts of the scene serve the topic '{topic.name}'")
        self._topics[topic.name] = topic
        self._parts[topic.name] = part

    def _deliver(self, name: str, message: Any) -> None:
        self._require_ready()
        if name in self._bus:
            sent = Stamped(self._now_ns, deepcopy(message))  # the sender may go on using its message
            for subscription in self._bus[name]:
                subscription.push(sent)
        else:
            with self._guarded(f"take a message on {name}"):
                self._parts[name].write(name, message, self._now_ns)
        for observer in self._observers:
            observer(name, Stamped(self._now_ns, message))

    def _read_now(self, name: str) -> Stamped:
        self._require_open()
        return Stamped(self._now_ns, self._parts[name].read(name, self._now_ns))

    # -- the sequence of one advance, the same for every backend

    def _advance(self, t_ns: int) -> None:
        step_ns = self.capabilities.step_ns
        if t_ns % step_ns:
            raise TimestepError(
                f"{milliseconds(t_ns):g} ms is no multiple of the world's step, {milliseconds(step_ns):g} ms"
            )
        if not self._started:
            self._started = True
            self._sample()
        while self._at_ns < t_ns:
            stop_ns = self._next_stop(t_ns)
            self._do_advance((stop_ns - self._at_ns) // step_ns)
            self._at_ns = stop_ns
            for part in self._timed_parts:
                deadline_ns = part.deadline_ns
                if deadline_ns is not None and deadline_ns <= stop_ns:
                    part.at_deadline(stop_ns)
            self._sample()
        self._check_finite(t_ns)

    def _next_stop(self, t_ns: int) -> int:
        step_ns = self.capabilities.step_ns
        stop_ns = t_ns
        for sampling in self._rated.values():
            stop_ns = min(stop_ns, sampling.due_ns)
        for part in self._timed_parts:
            if part.deadline_ns is not None:
                on_grid_ns = -(-part.deadline_ns // step_ns) * step_ns
                stop_ns = min(stop_ns, max(on_grid_ns, self._at_ns + step_ns))
        return stop_ns

    def _sample(self) -> None:
        """Take every sample that is due now and somebody listens to."""
        at_ns = self._at_ns
        for name, sampling in self._rated.items():
            if sampling.due_ns == at_ns:
                stamped = Stamped(at_ns, self._parts[name].read(name, at_ns))
                for subscription in sampling.subscriptions:
                    subscription.push(stamped)
                sampling.due_ns = sampling.schedule.next_after(at_ns)

    def _plan_samples(self) -> None:
        """Find when each sample is due next, from the time alone."""
        for sampling in self._rated.values():
            sampling.due_ns = sampling.schedule.next_after(self._at_ns) if self._started else 0

    def _check_finite(self, t_ns: int) -> None:
        for model in self._movable:
            if not all(map(isfinite, self.model_motion(model).pose.position)):
                raise DivergedError(f"model '{model}' is nowhere: its position is not finite", t_ns=t_ns)

    def _reset(self) -> None:
        self._at_ns = 0
        self._started = False
        self._plan_samples()
        for subscription in self._subscriptions:
            subscription.clear()
        self._do_reset(self._seed)
        for part in self._all_parts:
            part.reset()

    def _save(self) -> object:
        self._require_snapshot()
        kept = [(subscription.topic.name, subscription.kept()) for subscription in self._subscriptions]
        parts = [part.save() for part in self._all_parts]
        return self._seed, self._at_ns, self._started, kept, parts, self._do_save()

    def _load(self, saved: Any) -> None:
        self._require_snapshot()
        self._seed, self._at_ns, self._started, kept, parts, state = saved
        self._plan_samples()
        self._do_restore(state)
        for part, state_of in zip(self._all_parts, parts, strict=True):
            part.restore(state_of)
        self._refill(kept)

    def _refill(self, kept: list[tuple[str, list[Stamped]]]) -> None:
        """Give subscriptions back what they held; the n-th one of a topic gets what the n-th one held."""
        saved: dict[str, list[list[Stamped]]] = {}
        for name, messages in kept:
            saved.setdefault(name, []).append(messages)
        for subscription in self._subscriptions:
            subscription.clear()
            queue = saved.get(subscription.topic.name)
            for stamped in queue.pop(0) if queue else ():
                subscription.push(stamped)

    def _require_snapshot(self) -> None:
        if not self.capabilities.snapshot:
            raise CapabilityError(f"{type(self).__name__} cannot save and restore its state")

    # -- what the parts ask of the engine, in terms of what a backend writes

    @final
    def model_motion(self, model: str) -> ModelMotion:
        return self._do_model_motion(model)

    @final
    def joint_states(self, model: str) -> JointStates:
        return self._do_joint_states(model)

    @final
    def render(self, model: str, link: str, camera: str) -> ImageArray:
        picture = self._do_render(model, link, camera)
        picture.flags.writeable = False
        return picture

    @final
    def set_color(self, visual: str, rgba: Rgba) -> None:
        self._do_set_color(visual, rgba)

    @final
    def set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        self._do_set_drive(model, drive, velocity)

    # -- for backends: the fewest operations that cannot be derived

    @abstractmethod
    def _do_advance(self, steps: int) -> None:
        """Take ``steps`` physics steps."""

    @abstractmethod
    def _do_reset(self, seed: int) -> None:
        """Return to the state right after opening; bit for bit where determinism is declared."""

    @abstractmethod
    def _do_model_motion(self, model: str) -> ModelMotion:
        """Return where a model's frame is and how it moves, in the frame of the world."""

    @abstractmethod
    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        """Let a drive aim at a velocity of the body from now on."""

    @abstractmethod
    def _do_set_color(self, visual: str, rgba: Rgba) -> None:
        """Colour a visual, named by its path ``model/link/visual``, from the next picture on."""

    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        """Return what a camera sees now, shape ``(height, width, 3)``, RGB, a fresh array."""
        raise CapabilityError(f"{type(self).__name__} has no cameras")

    def _do_joint_states(self, model: str) -> JointStates:
        """Return the state of the movable joints of a model, in the order of its file."""
        raise CapabilityError(f"{type(self).__name__} does not show joints")

    def _do_save(self) -> object:
        """Return the complete state as something that pickles."""
        raise NotImplementedError

    def _do_restore(self, saved: object) -> None:
        """Return to what :meth:`_do_save` gave."""
        raise NotImplementedError


class WorldBackend(ABC):
    """The entry point of a physics engine; importing and constructing it is cheap.

    Attributes:
        interface_version: the version of the interfaces it was written for.
        options: the model of its options.
    """

    interface_version: ClassVar[int] = INTERFACE_VERSION
    options: ClassVar[type[WorldOptions]] = WorldOptions

    @abstractmethod
    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        """Return what the backend has under these options; does not load the engine."""

    def diagnose(self) -> list[Diagnosis]:
        """Look at this machine for what the backend needs; may load the engine."""
        return []

    @abstractmethod
    def open(self, scene: Scene, *, seed: int, options: WorldOptions) -> World:
        """Load a scene into the engine, at time 0."""
