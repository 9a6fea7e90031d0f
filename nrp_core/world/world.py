"""The world side of an experiment: topics, parts and services around an engine."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core._support.overview import Overview, Row, counted
from nrp_core.clock import milliseconds, seconds
from nrp_core.errors import TimestepError
from nrp_core.scene.model import Scene
from nrp_core.scene.rigid import JointStates, ModelMotion
from nrp_core.simulation import guarded
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.engine import Engine
from nrp_core.world.live import LiveScene
from nrp_core.world.model_states import StatesPart
from nrp_core.world.part import Part
from nrp_core.world.physics_observer import PhysicsObserver
from nrp_core.world.sensors.contact import ContactsPart
from nrp_core.world.services.part import Services
from nrp_core.world.topics import Publication, Stamped, Subscription, TopicInfo, check_message


class World(Overview, LiveScene):
    """A scene in an engine, at a time; the class is the same for every backend, which implements an engine.

    In a step data flows one way: the engine steps, the parts sample it, their messages go to subscribers.
    The operations that change the scene are those of :class:`LiveScene`.

    Args:
        engine: the engine with its first scene.
        nominal: the scene with what is drawn for each seed, if that is not the engine's.
    """

    def __init__(self, engine: Engine, nominal: Scene | None = None) -> None:
        super().__init__(engine, nominal)
        self._services = Services(self)
        self._physics_observers: list[PhysicsObserver] = []
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
    def capabilities(self) -> WorldCapabilities:
        """The capabilities of the backend."""
        return self.engine.capabilities

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

    @checks_arguments()
    def add_observer(self, observer: Callable[[str, Stamped], None]) -> None:
        """Call an observer with every published message and its topic (never an alias)."""
        self._board.observers.append(observer)

    def remove_observer(self, observer: Callable[[str, Stamped], None]) -> None:
        """Remove an observer."""
        self._board.observers.remove(observer)

    def add_physics_observer(self, observer: PhysicsObserver) -> None:
        """Let an observer look at the bodies at physics steps, at the times that it asks for."""
        self._physics_observers.append(observer)

    def remove_physics_observer(self, observer: PhysicsObserver) -> None:
        """Remove an observer of physics steps."""
        self._physics_observers.remove(observer)

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
        with self.changing("call", (service, *values), fields), guarded(self, f"answer {topic.name}"):
            answer = self._services.answer(topic.name, request)
        self._board.show(topic.name, request)
        return answer

    # -- the order of an advance

    def _advance(self, t_ns: int) -> None:
        engine, board, parts = self.engine, self._board, self.parts
        step_ns = engine.capabilities.step_ns
        if t_ns % step_ns:
            raise TimestepError(
                f"{milliseconds(t_ns):g} ms is not a multiple of the world's step, "
                f"{milliseconds(step_ns):g} ms"
            )
        board.drop_old()
        if not board.started:
            board.started = True
            parts.begin()
            board.sample()
        while engine.now_ns < t_ns:
            timed = () if self.paused else parts.timed
            stop_ns = self._next_stop(timed, t_ns)
            if parts.pollers:
                parts.report_subscriptions(board.subscribed)
            engine.advance((stop_ns - engine.now_ns) // step_ns, paused=self.paused)
            if parts.pollers:
                parts.deliver()
            for part in timed:
                deadline_ns = part.deadline_ns
                if deadline_ns is not None and deadline_ns <= stop_ns:
                    part.at_deadline(stop_ns)
            board.sample()
            for observer in self._physics_observers:
                if observer.deadline_ns is not None and observer.deadline_ns <= stop_ns:
                    observer.observe(stop_ns)
        engine.check_finite(t_ns)

    def _next_stop(self, timed: Sequence[Part], t_ns: int) -> int:
        """Return the time of the next sample, deadline, look of an observer or the end, on the grid, ns."""
        due_ns, step_ns = self._board.next_due(), self.engine.capabilities.step_ns
        stop_ns = t_ns if due_ns is None else min(t_ns, due_ns)
        others: Sequence[Part | PhysicsObserver] = (*timed, *self._physics_observers)
        for one in others:
            deadline_ns = one.deadline_ns
            if deadline_ns is not None and deadline_ns < stop_ns:
                on_grid_ns = -(-deadline_ns // step_ns) * step_ns
                stop_ns = min(stop_ns, max(on_grid_ns, self.engine.now_ns + step_ns))
        return stop_ns

    def _do_close(self) -> None:
        self.engine.close()
