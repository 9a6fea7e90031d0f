"""The world side: what a physics engine must offer to take part in the loop.

A minimal backend steps its engine, tells where models are, takes a body velocity, renders a camera and
changes a colour. Topics, messages, rates, time-outs and odometry are supplied here, once for
all backends, by the parts in :mod:`nrp_core.world.parts`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite
from types import MappingProxyType
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict

from nrp_core.clock import SampleSchedule, milliseconds
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
        self._rated: dict[str, tuple[SampleSchedule, list[Subscription]]] = {}
        self._bus: dict[str, list[Subscription]] = {}
        self._all_parts = parts_of(scene, self)
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
        """Serve a topic under one more name."""
        if alias in self._topics:
            raise TopicError(f"the alias '{alias}' is the name of a topic already")
        self._aliases[alias] = self._info(topic).name

    def declare(self, name: str, type_: type) -> None:
        """Add a topic of the user's own, which only carries what is published on it."""
        if name in self._topics or name in self._aliases:
            raise TopicError(f"there is a topic '{name}' already")
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
            step_ns = self.capabilities.step_ns
            schedule = SampleSchedule.of(info.rate_hz, step_ns)
            self._rated.setdefault(info.name, (schedule, []))[1].append(subscription)
        return subscription

    @final
    def unsubscribe(self, subscription: Subscription) -> None:
        """End a subscription; a topic that nobody reads costs nothing."""
        name = subscription.topic.name
        if name in self._rated:
            self._rated[name][1].remove(subscription)
            if not self._rated[name][1]:
                del self._rated[name]
        elif name in self._bus:
            self._bus[name].remove(subscription)

    @final
    def advertise(self, topic: str) -> Publication:
        """Return the right to publish on a topic.

        Raises:
            TopicError: there is no such topic, or it takes no messages.
        """
        info = self._require(topic, Direction.IN)
        return Publication(replace(info, name=topic), partial(self._deliver, info.name))

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
            for subscription in self._bus[name]:
                subscription.push(Stamped(self._now_ns, message))
        else:
            with self._guarded(f"take a message on {name}"):
                self._parts[name].write(name, message, self._now_ns)

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
            for part in self._all_parts:
                deadline_ns = part.deadline_ns
                if deadline_ns is not None and deadline_ns <= stop_ns:
                    part.at_deadline(stop_ns)
            self._sample()
        self._check_finite(t_ns)

    def _next_stop(self, t_ns: int) -> int:
        step_ns = self.capabilities.step_ns
        stop_ns = t_ns
        for schedule, _ in self._rated.values():
            stop_ns = min(stop_ns, schedule.next_after(self._at_ns))
        for part in self._all_parts:
            if part.deadline_ns is not None:
                on_grid_ns = -(-part.deadline_ns // step_ns) * step_ns
                stop_ns = min(stop_ns, max(on_grid_ns, self._at_ns + step_ns))
        return stop_ns

    def _sample(self) -> None:
        """Take every sample that is due now and somebody listens to."""
        at_ns = self._at_ns
        for name, (schedule, subscriptions) in self._rated.items():
            if at_ns == 0 or schedule.next_after(at_ns - 1) == at_ns:
                stamped = Stamped(at_ns, self._parts[name].read(name, at_ns))
                for subscription in subscriptions:
                    subscription.push(stamped)

    def _check_finite(self, t_ns: int) -> None:
        for model in self.scene.models:
            if not model.static and not all(map(isfinite, self.model_motion(model.name).pose.position)):
                raise DivergedError(f"model '{model.name}' is nowhere: its position is not finite", t_ns=t_ns)

    def _reset(self) -> None:
        self._at_ns = 0
        self._started = False
        for _, subscriptions in self._rated.values():
            for subscription in subscriptions:
                subscription.clear()
        for listeners in self._bus.values():
            for subscription in listeners:
                subscription.clear()
        self._do_reset(self._seed)
        for part in self._all_parts:
            part.reset()

    def _save(self) -> object:
        self._require_snapshot()
        samples = {name: [s.kept() for s in subs] for name, (_, subs) in self._rated.items()}
        parts = [part.save() for part in self._all_parts]
        return self._seed, self._at_ns, self._started, samples, parts, self._do_save()

    def _load(self, saved: Any) -> None:
        self._require_snapshot()
        self._seed, self._at_ns, self._started, samples, parts, state = saved
        self._do_restore(state)
        for part, state_of in zip(self._all_parts, parts, strict=True):
            part.restore(state_of)
        for name, (_, subscriptions) in self._rated.items():
            for subscription, kept in zip(subscriptions, samples.get(name, ()), strict=False):
                subscription.clear()
                for stamped in kept:
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

    @abstractmethod
    def open(self, scene: Scene, *, seed: int, options: WorldOptions) -> World:
        """Load a scene into the engine, at time 0."""
