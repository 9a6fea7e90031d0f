"""``rospy``: topics, services, time and logs of the run."""

from __future__ import annotations

import logging
from collections.abc import Callable
from functools import cache
from types import ModuleType
from typing import Any

from nrp_core.clock import NS_PER_S, from_seconds
from nrp_core.findings import Code
from nrp_legacy.shims.graph import Graph, absolute, log, shown
from nrp_legacy.shims.modules import OpenMessage, module, with_numbers
from nrp_legacy.shims.services import Service, ServiceException, Services
from nrp_legacy.shims.times import Duration, Time

_LEVELS = {"debug": logging.DEBUG, "info": logging.INFO, "warn": logging.WARNING, "err": logging.ERROR}


class ROSException(Exception):  # noqa: N818 - the name that users catch
    """The base of rospy's errors."""


class ROSInterruptException(ROSException):
    """The node is shut down."""


class Publisher:
    """Publishes on a topic."""

    def __init__(self, graph: Graph, name: str, data_class: Any, **_options: Any) -> None:
        self._graph, self.name = graph, absolute(name)
        self.type = graph.want(self.name, data_class)

    def publish(self, *values: Any, **fields: Any) -> None:
        """Publish a message, or one made of these fields."""
        is_message = len(values) == 1 and not fields and isinstance(values[0], self.type)
        message = values[0] if is_message else self.type(*values, **fields)
        if not shown(self.name, message, self._graph):
            self._graph.publish(self.name, self.type, with_numbers(message))

    def get_num_connections(self) -> int:
        """Return 1, because the world is subscribed."""
        return 1

    def unregister(self) -> None:
        """Do nothing, because an unused publisher costs nothing."""


class Subscriber:
    """Calls back for the messages of a topic."""

    def __init__(
        self,
        graph: Graph,
        name: str,
        data_class: Any,
        callback: Callable[..., Any] | None = None,
        callback_args: Any = None,
        **_options: Any,
    ) -> None:
        self._graph, self.name = graph, absolute(name)

        def called(message: Any) -> None:
            if callback is not None:
                callback(message) if callback_args is None else callback(message, callback_args)

        self._listener = graph.listen(self.name, data_class, called)

    def unregister(self) -> None:
        """Stop calling back."""
        self._graph.forget(self._listener)


class ServiceProxy:
    """Calls a service."""

    def __init__(self, services: Services, name: str, service_class: Any = None, **_options: Any) -> None:
        self._services, self.resolved_name, self._kind = services, absolute(name), service_class

    def __call__(self, *values: Any, **fields: Any) -> Any:
        return self._services.call(self.resolved_name, *values, kind=self._kind, **fields)

    call = __call__

    def close(self) -> None:
        """Do nothing."""


class TimerEvent:
    """The event of a timer: expected and actual times.

    Args:
        last, current: simulated times.
    """

    def __init__(self, last: Time | None, current: Time) -> None:
        self.last_expected = self.last_real = last
        self.current_expected = self.current_real = current
        self.last_duration = 0.0


class Timer:
    """Calls back in simulated time, between two steps.

    Args:
        period: between two calls.
        callback: called with a :class:`TimerEvent`.
        oneshot: whether it calls only once.
    """

    def __init__(
        self, graph: Graph, period: Any, callback: Callable[[Any], Any], oneshot: bool = False, **_more: Any
    ) -> None:
        self._period_ns, self._callback, self._once = from_seconds(float(period)), callback, oneshot
        self._graph, self._last_ns = graph, graph.now_ns
        self._last: Time | None = None
        graph.attend(self)

    def deliver(self, graph: Graph) -> None:
        """Call back for all periods since the last call."""
        self._last_ns = min(self._last_ns, graph.now_ns)  # the run may have been reset
        while self._last_ns + self._period_ns <= graph.now_ns:
            self._last_ns += self._period_ns
            event = TimerEvent(self._last, Time(0, self._last_ns))
            self._last = event.current_real
            try:
                self._callback(event)
            except Exception as error:  # noqa: BLE001 - a callback of a user may raise anything
                graph.warn(Code.NRP280, f"a callback of a timer raised {type(error).__name__}: {error}")
            if self._once:
                self.shutdown()
                return

    def shutdown(self) -> None:
        """Stop calling back."""
        self._graph.forget(self)

    def run(self) -> None:
        """Do nothing, because it runs already."""

    start = join = run


def rospy_module(graph: Graph, services: Services) -> ModuleType:
    """Return the module for one experiment."""

    class NowTime(Time):
        @classmethod
        def now(cls) -> Time:
            return cls(0, graph.glance())

    NowTime.__name__ = "Time"
    logs = {f"log{name}": _logs(level) for name, level in _LEVELS.items()}
    throttled = {f"{name}_throttle": _after_period(write) for name, write in logs.items()}
    once = {f"{name}_once": cache(lambda text, write=write: write(text)) for name, write in logs.items()}
    times = {"Time": NowTime, "Duration": Duration, "get_rostime": NowTime.now}
    return module(
        "rospy",
        Timer=lambda *a, **k: Timer(graph, *a, **k),
        rostime=module("rospy.rostime", **times),
        names=module("rospy.names", get_name=lambda: "/experiment"),
        myargv=lambda argv=(): list(argv),
        AnyMsg=OpenMessage,
        Publisher=lambda *a, **k: Publisher(graph, *a, **k),
        Subscriber=lambda *a, **k: Subscriber(graph, *a, **k),
        Service=lambda *a, **k: Service(services, *a, **k),
        ServiceProxy=lambda *a, **k: ServiceProxy(services, *a, **k),
        ServiceException=ServiceException,
        ROSException=ROSException,
        ROSInterruptException=ROSInterruptException,
        **times,
        Rate=lambda hz: _Rate(graph, hz),
        get_time=lambda: graph.glance() / NS_PER_S,
        sleep=lambda duration: sleep(graph, duration),
        is_shutdown=lambda: graph.glance() < 0,
        init_node=_nothing, spin=_nothing, on_shutdown=_nothing, signal_shutdown=_nothing,
        wait_for_service=_nothing,
        wait_for_message=lambda topic, kind, timeout=None: _wait_for_message(graph, topic, kind, timeout),
        **_parameters(graph),
        get_name=lambda: "/experiment", get_namespace=lambda: "/", get_caller_id=lambda: "/experiment",
        get_published_topics=lambda *_values: [[name, ""] for name in graph.topics],
        logerror=logs["logerr"], logwarning=logs["logwarn"], logfatal=logs["logerr"],
        **logs, **throttled, **once,
    )  # fmt: skip


def sleep(graph: Graph, duration: Any) -> None:
    """Wait in simulated time; a transfer function cannot wait and continues at once."""
    graph.wait_until(graph.now_ns + from_seconds(float(duration)))


class _Rate:
    def __init__(self, graph: Graph, hz: float) -> None:
        self._graph, self._period_s = graph, 1.0 / float(hz)

    def sleep(self) -> None:
        sleep(self._graph, self._period_s)


def _wait_for_message(graph: Graph, topic: str, kind: Any, timeout: float | None) -> Any:
    """Return the next message on a topic; code that cannot wait gets the last one.

    Raises:
        ROSException: none came in time.
    """
    name = absolute(topic)
    came: list[Any] = []
    if not graph.can_wait:
        latest = graph.latest(name)
        if latest is None:
            raise ROSException(f"no message on {name} yet; a transfer function cannot wait for one")
        return latest
    end_ns = None if timeout is None else graph.now_ns + from_seconds(float(timeout))
    listener = graph.listen(name, kind, came.append)
    try:
        while not came:
            if end_ns is not None and graph.now_ns >= end_ns:
                raise ROSException(f"no message on {name} within {timeout} s")
            graph.wait_until(0)
    finally:
        graph.forget(listener)
    return came[0]


def _logs(level: int) -> Callable[..., None]:
    def write(message: object, *values: object, **_options: object) -> None:
        log.log(level, str(message), *values)

    return write


def _after_period(write: Callable[..., None]) -> Callable[..., None]:
    """Return a log function that ignores its period."""
    return lambda _period, message, *values, **options: write(message, *values, **options)


def _parameters(graph: Graph) -> dict[str, Callable[..., Any]]:
    """Return the functions of a parameter server for one experiment."""
    return {
        "get_param": lambda name, default=None: graph.parameters.get(name, default),
        "set_param": lambda name, value: graph.parameters.__setitem__(name, value),
        "has_param": lambda name: name in graph.parameters,
        "delete_param": lambda name: graph.parameters.pop(name, None),
    }


def _nothing(*_values: Any, **_fields: Any) -> None:
    """Do nothing, because it is not needed here."""
