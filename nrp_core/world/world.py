"""The world side of an experiment: topics, parts and services around an engine."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core.clock import milliseconds
from nrp_core.errors import TimestepError
from nrp_core.findings import Findings
from nrp_core.simulation import Simulation, guarded
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.engine import Engine
from nrp_core.world.live import LiveScene, Watcher
from nrp_core.world.model_states import StatesPart
from nrp_core.world.part import Part
from nrp_core.world.rigid import JointStates, ModelMotion, Vector
from nrp_core.world.scene.model import Light, Model, Rgba, Scene
from nrp_core.world.sensors.contact import ContactsPart
from nrp_core.world.services.part import Services
from nrp_core.world.switchboard import Switchboard
from nrp_core.world.topics import Publication, Stamped, Subscription, TopicInfo, check_message


class World(Simulation):
    """A scene in an engine, at a time; the class is the same for every backend, which implements an engine.

    In a step data flows one way: the engine steps, the parts sample it, their messages go to subscribers.

    Args:
        engine: the engine with its first scene.

    Attributes:
        engine: the engine. Reading it changes nothing; changes go through the world.
        live: the operations that change the scene, for services.
    """

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        identity = f"{engine.identity},scene {engine.scene.digest}"
        super().__init__(seed=engine.seed, identity=identity, name=type(engine).__name__)
        self._board = Switchboard(engine.step_ns, self)
        self.live = LiveScene(engine, self._board)
        self._services = Services(self.live)
        states = [StatesPart(engine)] if engine.capabilities.poses else []
        contacts = [ContactsPart(engine)] if engine.capabilities.contacts else []
        self.live.parts.open([*states, *contacts, self._services, self.live.forces])

    # -- the current scene and engine

    @property
    def scene(self) -> Scene:
        """The current scene; models may have been added, deleted or moved since the opening."""
        return self.engine.scene

    @property
    def capabilities(self) -> WorldCapabilities:
        """The capabilities of the backend."""
        return self.engine.capabilities

    @property
    def warnings(self) -> Findings:
        """Warnings for the user."""
        return self.engine.warnings

    @property
    def paused(self) -> bool:
        """While this is true, time passes but nothing moves."""
        return self.live.paused

    @paused.setter
    def paused(self, paused: bool) -> None:
        self.live.paused = paused

    def model_motion(self, model: str) -> ModelMotion:
        """Return pose and velocity of a model's frame."""
        try:
            return self.engine.model_motion(model)
        except (KeyError, TypeError):
            self.scene.model(model)  # names one that exists, if there is no such model
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
    def unheard(self) -> frozenset[str]:
        """The declared topics on which messages were published, but never while there was a subscriber."""
        return self._board.unheard

    @checks_arguments()
    def add_alias(self, alias: str, topic: str) -> None:
        """Add an alias of a topic; see :meth:`.Switchboard.add_alias`."""
        self._board.add_alias(alias, topic)

    @checks_arguments()
    def declare(self, name: str, type_: type) -> None:
        """Add a topic of the user; see :meth:`.Switchboard.declare`."""
        self._board.declare(name, type_)

    @checks_arguments()
    def subscribe(self, topic: str, *, depth: int = 1) -> Subscription:
        """Subscribe to a topic; see :meth:`.Switchboard.subscribe`."""
        return self._board.subscribe(topic, depth=depth)

    def unsubscribe(self, subscription: Subscription) -> None:
        """End a subscription; a topic without subscribers costs nothing."""
        self._board.unsubscribe(subscription)

    def advertise(self, topic: str) -> Publication:
        """Return the right to publish on a topic; see :meth:`.Switchboard.advertise`."""
        return self._board.advertise(topic)

    @checks_arguments()
    def add_observer(self, observer: Callable[[str, Stamped], None]) -> None:
        """Call an observer with every published message and its topic (never an alias)."""
        self._board.observers.append(observer)

    def remove_observer(self, observer: Callable[[str, Stamped], None]) -> None:
        """Remove an observer."""
        self._board.observers.remove(observer)

    # -- changes from Python, which a recording repeats; see LiveScene

    def add_watcher(self, watcher: Watcher) -> None:
        """Call a watcher with every change; for nested changes only with the outermost one."""
        self.live.watchers.append(watcher)

    def remove_watcher(self, watcher: Watcher) -> None:
        """Remove a watcher."""
        self.live.watchers.remove(watcher)

    def call(self, service: str, /, *values: Any, **fields: Any) -> Any:
        """Call a service, such as ``/gazebo/set_model_state``, and return its answer.

        Args:
            service: its name.
            values: the fields of its request in their order, or the request itself.
            fields: the fields by name.

        Raises:
            TopicError: there is no such service, or the request does not fit.
        """
        self.require_ready()
        topic = self._board.info(service)
        request = self._services.request(topic.name, values, fields)
        check_message(topic, request)
        with self.live.changing("call", (service, *values), fields), guarded(self, f"answer {topic.name}"):
            answer = self._services.answer(topic.name, request)
        self._board.show(topic.name, request)
        return answer

    @checks_arguments()
    def spawn(self, model: Model) -> None:
        """Add a model; see :meth:`.LiveScene.spawn`."""
        self.live.spawn(model)

    @checks_arguments()
    def delete(self, model: str) -> None:
        """Remove a model; see :meth:`.LiveScene.delete`."""
        self.live.delete(model)

    @checks_arguments()
    def place(self, model: str, motion: ModelMotion) -> None:
        """Set pose and velocity of a model; see :meth:`.LiveScene.place`."""
        self.live.place(model, motion)

    @checks_arguments()
    def set_joints(self, model: str, positions: Mapping[str, float]) -> None:
        """Set positions (rad, m) of joints of a model, at rest; see :meth:`.LiveScene.set_joints`."""
        self.live.set_joints(model, positions)

    @checks_arguments()
    def set_material(self, visual: str, rgba: Rgba, glows: bool | None = None) -> None:
        """Set the colour of a visual; see :meth:`.LiveScene.set_material`."""
        self.live.set_material(visual, rgba, glows)

    @checks_arguments()
    def set_lights(self, lights: Iterable[Light]) -> None:
        """Set the lights; see :meth:`.LiveScene.set_lights`."""
        self.live.set_lights(lights)

    @checks_arguments()
    def set_gravity(self, gravity: Vector) -> None:
        """Set gravity, m/s^2; see :meth:`.LiveScene.set_gravity`."""
        self.live.set_gravity(gravity)

    @checks_arguments()
    def return_home(self, models: Iterable[str] | None = None) -> None:
        """Put models and their joints to their initial poses; see :meth:`.LiveScene.return_home`."""
        self.live.return_home(models)

    @checks_arguments()
    def repaint(self, models: Iterable[str]) -> None:
        """Give models the colours with which they were opened."""
        self.live.repaint(models)

    # -- the order of an advance

    def _advance(self, t_ns: int) -> None:
        engine, board, live = self.engine, self._board, self.live
        step_ns = engine.capabilities.step_ns
        if t_ns % step_ns:
            raise TimestepError(
                f"{milliseconds(t_ns):g} ms is not a multiple of the world's step, "
                f"{milliseconds(step_ns):g} ms"
            )
        if not board.started:
            board.started = True
            live.parts.begin()
            board.sample()
        while board.at_ns < t_ns:
            timed = () if live.paused else live.parts.timed
            stop_ns = _next_stop(board, timed, t_ns, step_ns)
            if live.parts.carriers:
                live.parts.attend(board.subscribed)
            engine.advance((stop_ns - board.at_ns) // step_ns, paused=live.paused)
            board.at_ns = stop_ns
            if live.parts.carriers:
                live.parts.deliver()
            for part in timed:
                deadline_ns = part.deadline_ns
                if deadline_ns is not None and deadline_ns <= stop_ns:
                    part.at_deadline(stop_ns)
            board.sample()
        engine.check_finite(t_ns)

    # -- reset and snapshots

    def _reset(self) -> None:
        self.live.paused = False
        self.engine.now_ns = 0
        self._board.restart()
        self.live.reset(self._seed)

    def _reset_state(self) -> None:
        self.live.start_over()

    def _save(self) -> object:
        return self._seed, self._board.save(), self.live.save()

    def _load(self, saved: Any) -> None:
        self._seed, board, live = saved
        self._board.restore_time(board)
        self.engine.seed, self.engine.now_ns = self._seed, self._board.at_ns
        self.live.restore(live)
        self._board.restore_messages(board)

    def _do_close(self) -> None:
        self.engine.close()


def _next_stop(board: Switchboard, timed: Sequence[Part], t_ns: int, step_ns: int) -> int:
    """Return the time of the next sample, deadline of a part or the end, on the grid of steps, ns."""
    due_ns = board.next_due()
    stop_ns = t_ns if due_ns is None else min(t_ns, due_ns)
    for part in timed:
        deadline_ns = part.deadline_ns
        if deadline_ns is not None and deadline_ns < stop_ns:
            on_grid_ns = -(-deadline_ns // step_ns) * step_ns
            stop_ns = min(stop_ns, max(on_grid_ns, board.at_ns + step_ns))
    return stop_ns
