"""The state of a run for the shims: its time, its topics and its log.

Before the run begins, topics are only noted: :meth:`Graph.wanted` returns them. ``hbp_nrp_excontrol.logs``
are texts for the user, which state machines can wait for.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from difflib import get_close_matches
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

from nrp_core.cle.loop import ClosedLoop
from nrp_core.clock import seconds
from nrp_core.dsl import message_type
from nrp_core.experiment import Run
from nrp_core.findings import Code, Finding, Findings, Level
from nrp_core.messages.std_msgs import String
from nrp_core.world import Direction, Subscription, Vector, World
from nrp_core.world.topics import check_message
from nrp_legacy.documents import ROBOT
from nrp_legacy.shims.modules import OpenMessage, as_in_ros1, module
from nrp_legacy.shims.steps import Task

log = logging.getLogger("nrp_legacy")
"""What experiments log."""


def absolute(name: str) -> str:
    """Return the absolute name of a topic or service."""
    return name if name.startswith("/") else f"/{name}"


class Listener:
    """A callback for the messages of a topic.

    Args:
        topic: its absolute name.
        kind: its type.
        callback: called with each message.
    """

    def __init__(self, topic: str, kind: type, callback: Callable[[Any], Any]) -> None:
        self.topic, self.kind, self.callback = topic, kind, callback
        self._subscription: Subscription | None = None

    def deliver(self, graph: Graph) -> None:
        """Call back with each message that came; exceptions of the callback are logged, as in ROS."""
        if self._subscription is None:
            self._subscription = graph.awaited(self.topic, self.kind)
        for stamped in self._subscription.take():
            graph.subscribed[self.topic] = True
            try:
                self.callback(as_in_ros1(stamped.message))
            except Exception as error:  # noqa: BLE001 - a callback of a user may raise anything
                graph.warn(Code.NRP280, f"a callback of {self.topic} raised {type(error).__name__}: {error}")

    def renew(self) -> None:
        """Subscribe again at the next call."""
        self._subscription = None

    def end(self, graph: Graph) -> None:
        """End the subscription."""
        if self._subscription is not None:
            graph.world.unsubscribe(self._subscription)


class Attendant(Protocol):
    """An object that is called before the functions of each step."""

    def deliver(self, graph: Graph) -> None:
        """Called before the functions of each step."""


class Graph:
    """The topics and the time of one run, for all shims of an experiment."""

    def __init__(self) -> None:
        self._run: Run | None = None
        self._listeners: list[Attendant] = []
        self.wanted: dict[str, type] = {}
        self.subscribed: dict[str, bool] = {}
        """Whether a message came on each topic that code listens to, unless a sensor has it."""
        self.scales: dict[str, Vector] = {}
        """Factors by which states have scale_model models."""
        self.parameters: dict[str, Any] = {}
        """The values of the parameter server."""
        self.on_end: list[Callable[[], None]] = []
        """Called when code of the experiment ends the run."""

    def __deepcopy__(self, memo: object) -> Graph:
        """Return the graph itself, so that copies of service proxies belong to the run."""
        return self

    # -- before and during the run

    def begin(self, run: Run) -> None:
        """Connect to a run."""
        self._run = run
        run.loop.hooks.before_functions.append(self._deliver)
        run.loop.hooks.after_reset.append(lambda _loop: self.scales.clear())
        run.reporters.append(self._silent)

    def end(self) -> None:
        """End the run after its current step."""
        assert self._run is not None
        message = f"a state machine has ended the simulation at {self.now_s:g} s"
        self.warn(Code.NRP248, message)
        self._run.loop.stop()
        for end in self.on_end:
            end()

    @property
    def has_begun(self) -> bool:
        """Whether there is a run."""
        return self._run is not None

    @property
    def folders(self) -> tuple[Path, ...]:
        """The folders of the experiment and its models."""
        return () if self._run is None else self._run.experiment.models

    @property
    def world(self) -> World:
        """The world of the run."""
        assert self._run is not None
        return self._run.world

    @property
    def robot(self) -> str | None:
        """The robot of code that names none: ``robot``, else the first; None without robots."""
        robots = () if self._run is None else self._run.experiment.world.robots
        return ROBOT if ROBOT in robots else next(iter(robots), None)

    @property
    def now_ns(self) -> int:
        """Simulated time, ns; 0 before the run."""
        return 0 if self._run is None else self._run.loop.now_ns

    @property
    def now_s(self) -> float:
        """Simulated time, s."""
        return seconds(self.now_ns)

    @property
    def can_wait(self) -> bool:
        """Whether the code that is running can wait for simulated time; transfer functions cannot."""
        return Task.here() is not None

    def wait_until(self, t_ns: int) -> None:
        """Wait for a simulated time, one step at least; code that cannot wait continues at once."""
        task = Task.here()
        if task is not None:
            task.wait_until(t_ns)

    def glance(self) -> int:
        """Return the simulated time, ns, to code that may be waiting for it by looking at the clock."""
        task = Task.here()
        if task is not None:
            task.glance()
        return self.now_ns

    def warn(self, code: Code, message: str, *, subject: str | None = None) -> None:
        """Report something once, with the result of the run."""
        reported = Findings() if self._run is None else self._run.world.warnings
        if reported.add(code, message, subject=subject):
            log.warning(message)

    def _deliver(self, loop: ClosedLoop) -> None:
        for listener in list(self._listeners):
            listener.deliver(self)

    # -- topics

    @property
    def topics(self) -> list[str]:
        """The names of all topics."""
        return [] if self._run is None else list(self.world.topics)

    def want(self, topic: str, kind: Any) -> type:
        """Request a topic; return its type."""
        self.wanted[topic] = known = message_type(kind)
        return known

    def declare(self, topic: str, kind: type) -> None:
        """Add a topic that the world does not have."""
        if topic not in self.world.topics:
            self.world.declare(topic, kind)

    def listen(self, topic: str, kind: Any, callback: Callable[[Any], Any]) -> Listener:
        """Add a callback for a topic, called before the functions of a step with its messages."""
        listener = Listener(topic, self.want(topic, kind), callback)
        self._listeners.append(listener)
        return listener

    def awaited(self, topic: str, kind: type) -> Subscription:
        """Subscribe to a topic; messages of another type than the expected one are reported."""
        self.declare(topic, kind)
        subscription = self.world.subscribe(topic, depth=None)
        expected, actual = (getattr(one, "__msgtype__", "") for one in (kind, subscription.topic.type))
        if expected and actual and expected != actual:
            message = f"'{topic}' carries {actual}, and the code of the experiment expects {expected}"
            self.warn(Code.NRP240, message, subject=topic)
        if subscription.topic.rate_hz is None:
            self.subscribed.setdefault(topic, False)
        return subscription

    def _silent(self) -> Iterator[Finding]:
        """Yield the topics that code listens to and that nothing has published on."""
        for topic, is_subscribed in self.subscribed.items():
            if not is_subscribed:
                known = [
                    name for name, info in self.world.topics.items() if info.direction is not Direction.IN
                ]
                known.remove(topic)
                hint = next((f"; did you mean '{one}'?" for one in get_close_matches(topic, known, n=1)), "")
                message = f"no message came on '{topic}', to which the code of the experiment listens{hint}"
                yield Finding(Code.NRP212, message, Level.WARNING, subject=topic)

    def attend(self, attendant: Attendant) -> None:
        """Add an object to be called before the functions of each step."""
        self._listeners.append(attendant)

    def renew(self) -> None:
        """Have listeners subscribe again, in another run."""
        for listener in self._listeners:
            if isinstance(listener, Listener):
                listener.renew()

    def forget(self, listener: Attendant) -> None:
        """Remove a callback, and end its subscription."""
        if listener in self._listeners:
            self._listeners.remove(listener)
            if isinstance(listener, Listener):
                listener.end(self)

    def publish(self, topic: str, kind: type, message: Any) -> None:
        """Publish a message; before the run it has no effect.

        Raises:
            TopicError: it does not fit the topic.
        """
        if self._run is None:
            return
        self.declare(topic, kind)
        info = self.world.topics[topic]
        if info.response is not None and not isinstance(message, info.type):
            self.world.call(topic, message)  # Gazebo has a topic beside a service, such as set_model_state
            return
        publication = self.world.advertise(topic)
        check_message(publication.topic, message)
        publication.publish(message)

    def latest(self, topic: str) -> Any:
        """Return the last message on a topic, None before the first."""
        if self._run is None or topic not in self.world.topics:
            return None
        subscription = self.world.subscribe(topic)
        stamped = subscription.latest
        self.world.unsubscribe(subscription)
        return None if stamped is None else as_in_ros1(stamped.message)


LOGS = "/ros_cle_simulation/logs"
"""The topic of the texts, which is there if somebody listens."""


class ClientLoggerMessage(OpenMessage):
    """A text for the user, as ``message``."""


def shown(topic: str, message: Any, graph: Graph) -> bool:
    """Show a message of the topic of texts to the user; return whether it has no other listener."""
    if topic != LOGS:
        return False
    log.info("%s", getattr(message, "data", getattr(message, "message", message)))
    if not graph.has_begun:
        return True
    graph.declare(LOGS, type(message))
    return LOGS not in graph.world.subscribed


class ClientLogger:
    """Shows texts to the user.

    Args:
        graph: the graph of the run.
    """

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def info(self, *words: object) -> None:
        """Show a text."""
        text = " ".join(map(str, words))
        log.info("%s", text)
        if LOGS in self._graph.topics:  # some files take its messages for strings
            takes_strings = self._graph.world.topics[LOGS].type is String
            message = String(text) if takes_strings else ClientLoggerMessage(message=text)
            self._graph.publish(LOGS, type(message), message)

    advertise = info

    def clear_advertisements(self) -> None:
        """Do nothing, because shown texts stay."""


def log_modules(logger: ClientLogger) -> dict[str, ModuleType]:
    """Return the module with a logger, by its name."""
    return {"hbp_nrp_excontrol.logs": module("logs", clientLogger=logger)}
