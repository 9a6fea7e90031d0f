"""The world side of an experiment: a scene in an engine, with topics, parts and services."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import update_wrapper
from math import isfinite
from operator import attrgetter
from typing import Any, Concatenate, Literal, ParamSpec, TypeAlias, TypeVar

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core._support.overview import Overview, Row, counted
from nrp_core.clock import NS_PER_S, milliseconds, seconds
from nrp_core.errors import SceneError, TimestepError, did_you_mean
from nrp_core.findings import Findings
from nrp_core.findings.refusals import SCENE_CHANGES
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.registry import Registry
from nrp_core.scene.model import Light, Model, Rgba, Scene
from nrp_core.scene.posture import start_positions, with_followers
from nrp_core.scene.randomization import Draw
from nrp_core.scene.rigid import JointStates, ModelMotion, Vector
from nrp_core.simulation import Simulation, guarded
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.domain_randomization import draw_scene
from nrp_core.world.engine import Engine
from nrp_core.world.forces import ForcesPart
from nrp_core.world.model_states import ColorPart, StatesPart
from nrp_core.world.part import Part
from nrp_core.world.parts import Parts, parts_of
from nrp_core.world.physics_observer import PhysicsObserver
from nrp_core.world.sensors.contact import ContactsPart
from nrp_core.world.service import Service, Services
from nrp_core.world.switchboard import NumbersPublication, Switchboard
from nrp_core.world.topics import Publication, Stamped, Subscription, TopicInfo, check_message

P = ParamSpec("P")
R = TypeVar("R")

Watcher = Callable[[str, Sequence[object], Mapping[str, object]], None]
"""Called with the name of a change and its arguments, once it has been made."""


def change(method: Callable[Concatenate[World, P], R]) -> Callable[Concatenate[World, P], R]:
    """Mark a method: each call is reported to the watchers of its world."""

    def watched(self: World, /, *arguments: P.args, **named: P.kwargs) -> R:
        with self.changing(method.__name__, arguments, named):
            return method(self, *arguments, **named)

    update_wrapper(watched, method)
    return watched


class World(Overview, Simulation):
    """A scene in an engine, at a time; the class is the same for every backend, which implements an engine.

    In a step data flows one way: the engine steps, the parts sample it, their messages go to subscribers.

    Args:
        engine: the engine with its first scene.
        nominal: the scene with its ranges for each seed, if it differs from the engine's.

    Attributes:
        engine: the engine that simulates it. Reading it changes nothing.
        nominal: the scene before anything was drawn.
        parts: the parts with its topics.
        forces: the forces that users apply to bodies and joints.
        paused: while this is true, time passes but nothing moves.
        watchers: called with every change; for nested changes only with the outermost one.
        hold_messages, release_messages: see :meth:`.Switchboard.hold`.
    """

    def __init__(self, engine: Engine, nominal: Scene | None = None) -> None:
        self._physics_observers: list[PhysicsObserver] = []
        self.engine, self.nominal = engine, nominal or engine.scene
        Simulation.__init__(self, seed=engine.seed, identity=engine.identity, name=engine.title)
        self.watchers: list[Watcher] = []
        self._changing = False
        self.paused = False
        self.forces = ForcesPart(engine)
        self._board = Switchboard(engine, self)
        self.hold_messages, self.release_messages = self._board.hold, self._board.release
        self.parts = Parts(engine, self._board)
        self._opened = engine.scene
        self._services = Services(engine, {name: given(self) for name, given in SERVICES.load_all().items()})
        states = [StatesPart(engine)] if engine.capabilities.poses else []
        contacts = [ContactsPart(engine)] if engine.capabilities.contacts else []
        self.parts.open([*states, *contacts, self._services, self.forces])

    def _overview(self) -> tuple[str, Iterable[Row]]:
        models = counted(len(self.scene.models), "model")
        line = f"of {models} in {type(self.engine).__name__}, at {seconds(self.now_ns):g} s"
        rows = ((name, topic.type.__name__, topic.what) for name, topic in self.topics.items())
        return line, [("topic", "type", "what"), *rows]

    # -- the current state

    @property
    def identity(self) -> str:
        """The engine with its version and options, and the scene; snapshots of another are refused."""
        return f"{super().identity},scene {self.nominal.digest}"

    @property
    def scene(self) -> Scene:
        """The current scene; models may have been added, deleted or moved since the opening."""
        return self.engine.scene

    @property
    def randomized(self) -> tuple[Draw, ...]:
        """The values that were drawn for the seed in force."""
        return draw_scene(self.nominal, self._seed)[1]

    def _set_now_ns(self, now_ns: int) -> None:
        self.engine.now_ns = now_ns

    # read a dozen times in a step of the loop, so without a call of a Python function
    now_ns: int = property(attrgetter("engine.now_ns"), _set_now_ns)  # type: ignore[assignment]
    """The time reached, ns; during an advance, that of the present samples."""

    @property
    def warnings(self) -> Findings:
        """Warnings for the user."""
        return self.engine.warnings

    @property
    def capabilities(self) -> WorldCapabilities:
        """The capabilities of the backend."""
        return self.engine.capabilities

    def model_motion(self, model: str) -> ModelMotion:
        """Return pose and velocity of a model's frame."""
        try:
            return self.engine.model_motion(model)
        except (KeyError, TypeError):
            self.scene.model(model)  # names an existing one, if the model does not exist
            raise

    def link_motion(self, model: str, link: str) -> ModelMotion:
        """Return pose and velocity of a link."""
        return self.engine.link_motion(model, link)

    def joint_states(self, model: str) -> JointStates:
        """Return the state of the movable joints of a model."""
        try:
            return self.engine.joint_states(model)
        except (KeyError, TypeError):
            self.scene.model(model)
            raise

    # -- topics; see Switchboard

    @property
    def topics(self) -> Mapping[str, TopicInfo]:
        """Every topic by its name, aliases included."""
        return self._board.topics

    @property
    def subscribed(self) -> frozenset[str]:
        """The subscribed topics, never aliases; the same object until it changes."""
        return self._board.subscribed

    @property
    def without_subscriber(self) -> frozenset[str]:
        """The declared topics on which messages were published, but never while there was a subscriber."""
        return self._board.without_subscriber

    @checks_arguments()
    def add_alias(self, alias: str, topic: str) -> None:
        """Add an alias of a topic; see :meth:`.Switchboard.add_alias`."""
        self._board.add_alias(alias, topic)

    @checks_arguments()
    def declare(self, name: str, type_: type) -> None:
        """Add a topic of the user; see :meth:`.Switchboard.declare`."""
        self._board.declare(name, type_)

    def set_unit(self, name: str, unit: str) -> None:
        """Set the unit of a declared topic; see :meth:`.Switchboard.set_unit`."""
        self._board.set_unit(name, unit)

    @checks_arguments()
    def subscribe(self, topic: str, *, depth: int | None = 1) -> Subscription:
        """Subscribe to a topic; see :meth:`.Switchboard.subscribe`."""
        return self._board.subscribe(topic, depth=depth)

    def unsubscribe(self, subscription: Subscription) -> None:
        """End a subscription; a topic without subscribers costs nothing."""
        self._board.unsubscribe(subscription)

    def advertise(self, topic: str) -> Publication:
        """Return the right to publish on a topic; see :meth:`.Switchboard.advertise`."""
        return self._board.advertise(topic)

    def rejection(self, topic: str) -> str | None:
        """Return why the last request on the topic of a service was rejected; None if it was accepted."""
        return self._services.rejected.get(topic)

    def advertise_together(self, topics: Sequence[str]) -> NumbersPublication:
        """Return the right to publish on several topics at once; see :meth:`advertise`."""
        return NumbersPublication([self.advertise(topic) for topic in topics], self._board)

    @checks_arguments()
    def add_observer(self, observer: Callable[[str, Stamped], None]) -> None:
        """Call an observer with every published message and its topic (never an alias)."""
        self._board.observers.append(observer)

    def remove_observer(self, observer: Callable[[str, Stamped], None]) -> None:
        """Remove an observer."""
        self._board.observers.remove(observer)

    def add_physics_observer(self, observer: PhysicsObserver) -> None:
        """Call an observer at physics steps, at the times that it requests, if the engine can stop there."""
        if self.engine.stops_between_steps:
            self._physics_observers.append(observer)

    def remove_physics_observer(self, observer: PhysicsObserver) -> None:
        """Remove an observer of physics steps."""
        if observer in self._physics_observers:
            self._physics_observers.remove(observer)

    def call(self, service: str, /, *values: Any, **fields: Any) -> Any:
        """Call a service, such as ``/gazebo/set_model_state``, and return its answer.

        Args:
            service: its name.
            values: the fields of its request in their order, or the request itself.
            fields: the fields by name.

        Raises:
            TopicError: the service does not exist, or the request does not fit.
        """
        self.require_ready()
        topic = self._board.info(service)
        request = self._services.request(topic.name, values, fields)
        check_message(topic, request)
        with self.changing("call", (service, *values), fields), guarded(self, f"answer {topic.name}"):
            answer = self._services.answer(topic.name, request)
        self._board.show(topic.name, request)
        return answer

    # -- changes

    @contextmanager
    def changing(self, name: str, arguments: Sequence[object], named: Mapping[str, object]) -> Iterator[None]:
        """Report the changes in a block as one change of that name."""
        if self._changing or not self.watchers:
            yield
            return
        self._changing = True
        try:
            yield
        finally:
            self._changing = False
        for watcher in self.watchers:
            watcher(name, arguments, named)

    @checks_arguments()
    @change
    def spawn(self, model: Model) -> None:
        """Add a model and its topics.

        Raises:
            SceneError: another model has that name, or the model is inconsistent.
            CapabilityError: the engine does not support it.
        """
        if not all(map(isfinite, (*model.pose.position, *model.pose.orientation))):
            raise SceneError(f"the pose of '{model.name}' must be finite, not {model.pose}")
        scene = self.scene.with_model(model)
        for part in parts_of(model, self.engine):
            for topic in part.topics:
                self._board.require_free(topic.name)
        self.change_to(scene)
        for part in self.parts.of(model.name) if self._board.started else ():
            part.begin()

    @checks_arguments()
    @change
    def delete(self, model: str) -> None:
        """Remove a model; subscribers of its topics receive no further messages.

        Raises:
            SceneError: the model does not exist.
            CapabilityError: the engine does not support it.
        """
        gone = self.scene.model(model)
        self.forces.forget(gone.name)
        self.change_to(self.scene.without(gone.name))

    @checks_arguments()
    @change
    def place(self, model: str, motion: ModelMotion) -> None:
        """Set pose and velocity of a model; one that does not float is fixed there without velocity.

        Raises:
            SceneError: the model does not exist, or a number is not finite.
            CapabilityError: the engine does not support it.
        """
        numbers = (*motion.pose.position, *motion.pose.orientation, *motion.linear, *motion.angular)
        if not all(map(isfinite, numbers)):
            raise SceneError(f"the pose and velocity of '{model}' must be finite, not {motion}")
        if self.engine.floats(model):
            self.engine.place(model, motion)
            self._report_move(model)
        elif self.scene.model(model).pose != motion.pose:
            self.change_to(self.scene.with_pose(model, motion.pose))

    @checks_arguments()
    @change
    def set_joints(self, model: str, positions: Mapping[str, float]) -> None:
        """Set positions (rad, m) of joints of a model and of those that follow them, at rest.

        Raises:
            SceneError: the joints do not exist, or a position is not finite.
            CapabilityError: the engine does not support it.
        """
        known = [name for joint in self.scene.model(model).joints for name in joint.coordinates]
        for name, position in positions.items():
            if name not in known:
                raise SceneError(f"'{model}' has no joint '{name}' that moves{did_you_mean(name, known)}")
            if not isfinite(position):
                raise SceneError(f"the joint '{name}' of '{model}' cannot be set to {position}")
        self.engine.set_joints(model, with_followers(self.scene.model(model), positions))
        self._report_move(model)

    # -- colours, lights and gravity

    @checks_arguments()
    @change
    def set_material(self, visual: str, rgba: Rgba, glows: bool | None = None) -> None:
        """Set the colour of a visual, and whether it glows.

        Args:
            visual: its path, ``model/link/visual``.
            rgba: the colour, 0..1.
            glows: whether it has its colour in any light; None: as before.
        """
        topic = f"/{visual}/color"
        self._board.advertise(topic).publish(ColorRGBA(*rgba))
        part = self._board.part(topic)
        if glows is not None and part is not None and isinstance(part.unwrapped, ColorPart):
            part.unwrapped.set_glow(glows)

    @checks_arguments()
    @change
    def set_lights(self, lights: Iterable[Light]) -> None:
        """Set the lights of the scene; realistic images show them, flat ones do not."""
        self.engine.set_lights(tuple(lights))

    @checks_arguments()
    @change
    def set_gravity(self, gravity: Vector) -> None:
        """Set gravity, m/s^2.

        Raises:
            SceneError: it is not finite.
            CapabilityError: the engine does not support it.
        """
        if not all(map(isfinite, gravity)):
            raise SceneError(f"gravity must be three finite numbers, not {gravity}")
        if gravity != self.scene.gravity:
            self.change_to(replace(self.scene, gravity=gravity))

    # -- the order of an advance

    def _advance(self, t_ns: int) -> None:
        engine = self.engine
        self.begin_advance(t_ns)
        while engine.now_ns < t_ns:
            stop_ns = self.next_stop(t_ns)
            engine.advance((stop_ns - engine.now_ns) // engine.capabilities.step_ns, paused=self.paused)
            engine.check_state(stop_ns)
            self.end_advance()

    def begin_advance(self, t_ns: int) -> None:
        """Prepare an advance to a time; the first one takes the first samples.

        Raises:
            TimestepError: the time is not a multiple of the physics step.
        """
        engine, board = self.engine, self._board
        step_ns = engine.capabilities.step_ns
        if t_ns % step_ns:
            raise TimestepError(
                f"{milliseconds(t_ns):g} ms is not a multiple of the world's step, "
                f"{milliseconds(step_ns):g} ms"
            )
        if engine.now_ns // NS_PER_S != t_ns // NS_PER_S:  # not in each step: it takes time
            board.drop_old()
        if not board.started:
            board.started = True
            self.parts.begin()
            board.sample()

    def end_advance(self) -> None:
        """Let parts, sensors and observers act at the time that the engine has reached."""
        parts, stop_ns = self.parts, self.engine.now_ns
        if parts.pollers:
            parts.deliver()
        if parts.timed and not self.paused:
            for part in parts.timed:
                deadline_ns = part.deadline_ns
                if deadline_ns is not None and deadline_ns <= stop_ns:
                    part.at_deadline(stop_ns)
        self._board.sample()
        for observer in self._physics_observers:
            if observer.deadline_ns is not None and observer.deadline_ns <= stop_ns:
                observer.observe(stop_ns)

    def next_stop(self, t_ns: int) -> int:
        """Return the time of the next sample, deadline, observer call or the end, on the grid, ns."""
        parts = self.parts
        if parts.pollers:
            parts.report_subscriptions(self._board.subscribed)
        due_ns, step_ns = self._board.next_due(), self.engine.capabilities.step_ns
        stop_ns = t_ns if due_ns is None else min(t_ns, due_ns)
        timed = () if self.paused else parts.timed
        others: Sequence[Part | PhysicsObserver] = (*timed, *self._physics_observers)
        for one in others:
            deadline_ns = one.deadline_ns
            if deadline_ns is not None and deadline_ns < stop_ns:
                on_grid_ns = -(-deadline_ns // step_ns) * step_ns
                stop_ns = min(stop_ns, max(on_grid_ns, self.engine.now_ns + step_ns))
        return stop_ns

    def _do_close(self) -> None:
        self.engine.close()

    # -- reset and snapshots

    @checks_arguments()
    def reset(
        self,
        what: Literal["all", "state", "poses", "colors"] = "all",
        models: Iterable[str] | None = None,
        *,
        seed: int | None = None,
    ) -> None:
        """Return to the state right after opening; see :mod:`nrp_core.simulation`.

        Args:
            what: ``all``; ``state``, while time goes on; or ``poses`` or ``colors`` of models; time and
                commands go on.
            models: the names of the models whose poses or colours are reset; by default all.
            seed: a new seed for ``all`` and ``state``; by default the one in force is used again.

        Raises:
            LifecycleError: the world is closed; or it failed, and ``what`` is not ``all``.
            SceneError: the model does not exist.
            CapabilityError: the engine cannot do that while time continues.
        """
        if what == "all":
            super().reset(seed=seed)
            return
        names = None if models is None else [self.scene.model(name).name for name in models]
        named = {} if seed is None else {"seed": seed}
        with self.changing("reset", (what,) if names is None else (what, names), named):
            if what == "state":
                super().reset(what, seed=seed)
                return
            self.require_ready()
            chosen = [model for model in self.scene.models if names is None or model.name in names]
            for model in chosen:
                (self._reset_pose if what == "poses" else self._reset_colors)(model)

    def _reset_pose(self, model: Model) -> None:
        """Put a model and its joints to their initial poses, at rest."""
        opened = {each.name: each.pose for each in self._opened.models}
        pose = opened.get(model.name, model.pose)
        if not model.static:
            self.place(model.name, ModelMotion(pose))
            if self.engine.capabilities.dynamics:  # else joints stay where they are
                names = self.engine.joint_states(model.name).names
                positions = dict.fromkeys(names, 0.0) | dict(start_positions(model))
                self.engine.set_joints(model.name, positions)
        elif model.pose != pose:
            self.place(model.name, ModelMotion(pose))

    def _reset_colors(self, model: Model) -> None:
        """Give a model the colours with which it was opened."""
        for part in self.parts.of(model.name):
            if isinstance(part.unwrapped, ColorPart):
                part.reset()

    def _reset(self) -> None:
        self.paused = False
        self._board.reset()
        self._reset_scene()

    def _reset_state(self) -> None:
        if not self.engine.capabilities.changes:
            raise self.engine.lacks("cannot be reset while time passes")
        self._reset_scene()
        if self._board.started:
            self.parts.begin()

    def _reset_scene(self) -> None:
        changed = self._draw()
        if self.scene is not self._opened:
            self._load_scene(self._opened, changed)
            self._opened = self.scene
        self.engine.reset(self._seed)
        self.parts.reset()

    def _save(self) -> object:
        changed = None if self.scene is self._opened else self.scene
        state = changed, self.paused, self.parts.save(), self.engine.save()
        return self._seed, self._board.save(), state

    def _load(self, saved: Any) -> None:
        self._seed, board, (changed, self.paused, parts, state) = saved
        self.engine.seed = self._seed
        drawn = self._draw()
        scene = self._opened if changed is None else changed
        if scene != self.scene:
            self._load_scene(scene, drawn)
        self.engine.restore(state)
        self.parts.restore(parts)
        self._board.restore(board)

    def change_to(self, scene: Scene) -> None:
        """Load another scene, keeping the states of the models that are in both.

        Raises:
            CapabilityError: the engine does not support it.
        """
        engine = self.engine
        if not engine.capabilities.changes:
            raise engine.lacks(SCENE_CHANGES)
        stay = {model.name for model in scene.models}
        moving = [m.name for m in self.scene.models if not m.static and m.name in stay]
        configurations = {name: engine.configuration(name) for name in moving}
        commands = [(part, part.save()) for part in self.parts.all]
        self._load_scene(scene)
        for name, configuration in configurations.items():
            engine.configure(name, configuration)
        for part, saved in commands:
            if part in self.parts.all:
                part.restore(saved)

    def _draw(self) -> set[str]:
        """Draw the scene to return to for the seed in force; return the names of the models that change."""
        if not self.nominal.randomize:
            return set()
        before = {model.name: model for model in self._opened.models}
        drawn, _ = draw_scene(self.nominal, self._seed)
        if drawn != self._opened:
            self._opened = drawn
        return {model.name for model in drawn.models if model != before[model.name]}

    def _load_scene(self, scene: Scene, changed: Collection[str] = ()) -> None:
        """Load a scene; models whose properties have changed get new parts."""
        self.engine.load(scene)
        self.parts.update(changed)

    def _report_move(self, model: str) -> None:
        for part in self.parts.of(model):
            part.on_model_moved()


Provider: TypeAlias = Callable[[World], Iterable[Service]]

SERVICES: Registry[Provider] = Registry("nrp_core.services", "provider of services")
"""Functions that return the services of a world, by any name."""
