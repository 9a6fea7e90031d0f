"""``smach_ros`` and ``hbp_nrp_excontrol.nrp_states``: states that wait for times, messages and neurons."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import partial
from types import ModuleType
from typing import Any

from nrp_core.clock import from_seconds
from nrp_core.findings import Code
from nrp_core.messages.cle_ros_msgs import SpikeEvent, SpikeRate
from nrp_core.messages.gazebo_msgs import LinkStates, ModelStates
from nrp_core.world.model_states import LINK_STATES, MODEL_STATES
from nrp_legacy.shims.actions import SimpleActionState
from nrp_legacy.shims.graph import LOGS, ClientLogger, ClientLoggerMessage, Graph, absolute, log
from nrp_legacy.shims.model_states import model_states
from nrp_legacy.shims.modules import bound, module
from nrp_legacy.shims.service_states import (
    SERVED,
    LightServiceState,
    ServiceState,
    SetMaterialColorServiceState,
)
from nrp_legacy.shims.services import Services
from nrp_legacy.shims.smach import State
from nrp_legacy.shims.steps import Task
from nrp_legacy.shims.times import Time

MONITORED = ("valid", "invalid", "preempted")


class PollingState(State):
    """A state that checks once a step whether it may continue.

    Args:
        is_over: called with the user data.
        graph: the graph of the run.
    """

    def __init__(self, graph: Graph, is_over: Callable[[Any], bool]) -> None:
        super().__init__(MONITORED)
        self._graph, self._is_over = graph, is_over

    def execute(self, userdata: Any) -> str:
        self._entered()
        while not self._is_over(userdata):
            if self.preempt_requested():
                return "preempted"
            task = Task.here()
            if task is None:
                return "valid"
            task.wait_until(0)
        return "invalid"

    def _entered(self) -> None:
        """Begin to wait."""


class MonitorState(PollingState):
    """Waits while a condition holds for the messages of a topic.

    Args:
        topic: the topic.
        msg_type: its type.
        cond_cb: called with the user data and a message; True: keep waiting.
        max_checks: number of messages after which it stops waiting; the outcome is then ``valid``.
    """

    def __init__(
        self,
        graph: Graph,
        topic: str,
        msg_type: Any,
        cond_cb: Callable[..., bool],
        max_checks: int = -1,
        **_keys: Any,
    ) -> None:
        super().__init__(graph, lambda _userdata: False)
        self._topic, self._type, self._condition, self._checks = (
            absolute(topic),
            msg_type,
            cond_cb,
            max_checks,
        )
        graph.want(self._topic, msg_type)

    def execute(self, userdata: Any) -> str:
        came: list[Any] = []
        listener = self._graph.listen(self._topic, self._type, came.append)
        self._left = self._checks
        self._is_over = lambda data: self._met(came, data)
        try:
            outcome = super().execute(userdata)
        finally:
            self._graph.forget(listener)
        return "valid" if outcome == "invalid" and self._left == 0 else outcome

    def _met(self, came: list[Any], userdata: Any) -> bool:
        messages, came[:] = list(came), []
        for message in messages:
            if not self._condition(userdata, message):
                return True
            self._left -= 1
            if self._left == 0:
                return True
        return False


_RATES = {
    "MonitorSpikeRateState": "population_rate",
    "MonitorLeakyIntegratorAlphaState": "leaky_integrator_alpha",
    "MonitorLeakyIntegratorExpState": "leaky_integrator_exp",
}
"""The states for values, and the kinds of monitors that they listen to."""


class ActivityMonitorState(MonitorState):
    """Waits while a condition holds for the messages of one monitor.

    Args:
        topic: the topic of its kind.
        shown: the type of its messages.
        value: the field that the condition gets.
        monitor_name: the name of the monitor, that of its function.
        callback: called with the user data, the time in s, and the value; True: keep waiting.
    """

    def __init__(
        self,
        graph: Graph,
        topic: str,
        shown: type,
        value: str,
        monitor_name: str,
        callback: Callable[[Any, float, Any], bool],
        *_keys: Any,
        **_more: Any,
    ) -> None:
        def holds(userdata: Any, message: Any) -> bool:
            if message.monitor_name != monitor_name:
                return True
            return callback(userdata, message.simulation_time, getattr(message, value))

        super().__init__(graph, topic, shown, holds)


def activity_states(graph: Graph) -> dict[str, type]:
    """Return the states by their names."""
    made = partial(bound, ActivityMonitorState, graph)
    rates = {name: made(f"/monitor/{kind}", SpikeRate, "rate") for name, kind in _RATES.items()}
    return {**rates, "MonitorSpikeRecorderState": made("/monitor/spike_recorder", SpikeEvent, "spikes")}


class ModelMonitorState(PollingState):
    """Waits while a condition holds for the pose, or velocity, of a model, or of a link ``model::link``.

    A name and a callback may follow in either order, as over the years; without a name it is the robot.

    Args:
        graph: the graph of the run.
        given: the callback, and the name of the model or link; they may be named.
        part: ``pose`` or ``twist``.
    """

    def __init__(self, graph: Graph, *given: Any, part: str = "pose", **named: Any) -> None:
        super().__init__(graph, self._no_longer)
        arguments = [*given, *named.values()]
        names = [one for one in arguments if isinstance(one, str)]
        callbacks = [one for one in arguments if callable(one)]
        if len(callbacks) != 1 or len(names) > 1:
            raise TypeError(f"a monitor of a {part} takes a callback and at most one name, not {arguments}")
        self._name, self._callback, self._part = next(iter(names), None), callbacks[0], part
        is_link = self._name is not None and "::" in self._name
        self._topic = LINK_STATES if is_link else MODEL_STATES
        graph.want(self._topic, LinkStates if is_link else ModelStates)

    def _no_longer(self, userdata: Any) -> bool:
        states = self._graph.latest(self._topic)
        name = self._graph.robot if self._name is None else self._name
        if states is None:
            return False
        if name not in states.name:
            self._graph.warn(
                Code.NRP212, f"a state waits for '{name}', which is not in the world", subject=name
            )
            return False
        return not self._callback(userdata, getattr(states, self._part)[states.name.index(name)])


class TwistMonitorState(ModelMonitorState):
    """Waits while a condition holds for the velocity of a model."""

    def __init__(self, *values: Any, **more: Any) -> None:
        super().__init__(*values, **more, part="twist")


class Tick(Time):
    """A message of the clock, which is compared like its time: machines were written for both."""

    @property
    def clock(self) -> Time:
        """The time."""
        return Time(0, self.ns)


class ClockMonitorState(PollingState):
    """Waits while a condition holds for the simulated time."""

    def __init__(self, graph: Graph, callback: Callable[..., bool], *_keys: Any, **_more: Any) -> None:
        takes_data = len(inspect.signature(callback).parameters) > 1

        def no_longer(userdata: Any) -> bool:
            now = Tick(0, graph.now_ns)
            return not (callback(userdata, now) if takes_data else callback(now))

        super().__init__(graph, no_longer)


class WaitToClockState(PollingState):
    """Waits for a time of the simulation, s."""

    def __init__(self, graph: Graph, time: float, *_keys: Any, **_more: Any) -> None:
        self.end_ns = from_seconds(float(time))
        super().__init__(graph, lambda _userdata: graph.now_ns >= self.end_ns)


class ClockDelayState(PollingState):
    """Waits for some seconds of simulated time; over the years they had two names."""

    def __init__(
        self,
        graph: Graph,
        waitfor: float | None = None,
        *_keys: Any,
        waittime: float | None = None,
        **_more: Any,
    ) -> None:
        delay_s = waittime if waitfor is None else waitfor
        if delay_s is None:
            raise TypeError("ClockDelayState needs the seconds that it waits, waitfor or waittime")
        super().__init__(graph, lambda _userdata: graph.now_ns >= self._end_ns)
        self.delay_ns = from_seconds(float(delay_s))
        self._end_ns = 0

    def _entered(self) -> None:
        self._end_ns = self._graph.now_ns + self.delay_ns


class ClientLogState(State):
    """Shows a text to the user."""

    def __init__(self, graph: Graph, text: str, *_keys: Any, **_more: Any) -> None:
        super().__init__(SERVED)
        self._logger, self._text = ClientLogger(graph), text

    def execute(self, userdata: Any) -> str:
        self._logger.info(self._text)
        return "succeeded"


class WarningState(ClientLogState):
    """Warns the user by a text."""

    def execute(self, userdata: Any) -> str:
        log.warning("%s", self._text)
        return super().execute(userdata)


class StopSimulation(State):
    """Ends the run."""

    def __init__(self, graph: Graph, *_values: Any, **_more: Any) -> None:
        super().__init__(SERVED)
        self._graph = graph

    def execute(self, userdata: Any) -> str:
        self._graph.end()
        return "succeeded"


class WaitForClientLogState(MonitorState):
    """Waits while a condition holds for the texts that are shown to the user."""

    def __init__(self, graph: Graph, cond_cb: Callable[[Any, Any], bool], *_keys: Any, **_more: Any) -> None:
        super().__init__(graph, LOGS, ClientLoggerMessage, cond_cb)


class IntrospectionServer:
    """A viewer of machines without effect."""

    def __init__(self, *_values: Any, **_more: Any) -> None:
        """Do nothing."""

    def start(self) -> None:
        """Do nothing."""

    def stop(self) -> None:
        """Do nothing."""


def smach_ros_module(graph: Graph, services: Services) -> ModuleType:
    """Return ``smach_ros`` for one experiment."""
    return module(
        "smach_ros",
        MonitorState=bound(MonitorState, graph),
        ServiceState=bound(ServiceState, graph, services),
        IntrospectionServer=IntrospectionServer,
        SimpleActionState=bound(SimpleActionState, graph),
        set_preempt_handler=lambda _container: None,
    )


def nrp_states_module(graph: Graph, services: Services) -> ModuleType:
    """Return ``hbp_nrp_excontrol.nrp_states`` for one experiment."""
    return module(
        "nrp_states",
        WaitToClockState=bound(WaitToClockState, graph),
        ClockDelayState=bound(ClockDelayState, graph),
        ClockMonitorState=bound(ClockMonitorState, graph),
        RobotPoseMonitorState=bound(ModelMonitorState, graph),
        LinkPoseMonitorState=bound(ModelMonitorState, graph),
        RobotTwistMonitorState=bound(TwistMonitorState, graph),
        SetMaterialColorServiceState=bound(SetMaterialColorServiceState, graph, services),
        LightServiceState=bound(LightServiceState, graph, services),
        ClientLogState=bound(ClientLogState, graph),
        WarningState=bound(WarningState, graph),
        StopSimulation=bound(StopSimulation, graph),
        WaitForClientLogState=bound(WaitForClientLogState, graph),
        **activity_states(graph),
        **model_states(graph, services),
    )
