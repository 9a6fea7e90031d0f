"""``smach_ros`` and ``hbp_nrp_excontrol.nrp_states``: states that wait for the world and change it."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from types import ModuleType
from typing import Any

from nrp_core.clock import NS_PER_S
from nrp_core.findings import Code
from nrp_core.world.messages.gazebo_msgs import LinkStates, ModelStates
from nrp_core.world.model_states import LINK_STATES, MODEL_STATES
from nrp_legacy.shims.actions import SimpleActionState
from nrp_legacy.shims.graph import Graph, absolute
from nrp_legacy.shims.logs import LOGS, ClientLogger, ClientLoggerMessage
from nrp_legacy.shims.model_states import model_states
from nrp_legacy.shims.modules import bound, module
from nrp_legacy.shims.services import ServiceException, Services
from nrp_legacy.shims.smach import State
from nrp_legacy.shims.steps import Task
from nrp_legacy.shims.times import Time

MONITORED = ("valid", "invalid", "preempted")
SERVED = ("succeeded", "aborted", "preempted")


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

    @property
    def is_limited(self) -> bool:
        """Whether it stops waiting after a number of messages."""
        return self._checks > 0

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
                Code.NRP268, f"a state waits for '{name}', which is not in the world", subject=name
            )
            return False
        return not self._callback(userdata, getattr(states, self._part)[states.name.index(name)])


class TwistMonitorState(ModelMonitorState):
    """Waits while a condition holds for the velocity of a model."""

    def __init__(self, *values: Any, **more: Any) -> None:
        super().__init__(*values, **more, part="twist")


class ClockMonitorState(PollingState):
    """Waits while a condition holds for the simulated time."""

    def __init__(self, graph: Graph, callback: Callable[..., bool], *_keys: Any, **_more: Any) -> None:
        takes_data = len(inspect.signature(callback).parameters) > 1

        def no_longer(userdata: Any) -> bool:
            now = Time(0, graph.now_ns)
            return not (callback(userdata, now) if takes_data else callback(now))

        super().__init__(graph, no_longer)


class WaitToClockState(PollingState):
    """Waits for a time of the simulation, s."""

    def __init__(self, graph: Graph, time: float, *_keys: Any, **_more: Any) -> None:
        self.end_ns = round(float(time) * NS_PER_S)
        super().__init__(graph, lambda _userdata: graph.now_ns >= self.end_ns)


class ClockDelayState(PollingState):
    """Waits for some seconds of simulated time."""

    def __init__(self, graph: Graph, waitfor: float, *_keys: Any, **_more: Any) -> None:
        super().__init__(graph, lambda _userdata: graph.now_ns >= self._end_ns)
        self.delay_ns = round(float(waitfor) * NS_PER_S)
        self._end_ns = 0

    def _entered(self) -> None:
        self._end_ns = self._graph.now_ns + self.delay_ns


class ServiceState(State):
    """Calls a service once.

    Args:
        service_name: the service.
        service_spec: its type.
        request: the request; or ``request_cb`` makes it from the user data and an empty request.
        response_cb: called with the user data and the answer; it may return an outcome.
        request_key, response_key: the keys of the request and the answer in the user data.
    """

    def __init__(
        self,
        graph: Graph,
        services: Services,
        service_name: str,
        service_spec: Any = None,
        request: Any = None,
        request_cb: Callable[..., Any] | None = None,
        response_cb: Callable[..., Any] | None = None,
        request_key: str | None = None,
        response_key: str | None = None,
        **_keys: Any,
    ) -> None:
        super().__init__(SERVED)
        self._keys = request_key, response_key
        self._graph, self._services = graph, services
        self._name, self._kind = absolute(service_name), service_spec
        self._request, self._request_cb, self._response_cb = request, request_cb, response_cb

    def execute(self, userdata: Any) -> str:
        request_key, response_key = self._keys
        asked = self._request if request_key is None else userdata[request_key]
        if self._request_cb is not None:
            asked = self._request_cb(userdata, asked)
        try:
            answer = self._services.call(self._name, *([] if asked is None else [asked]), kind=self._kind)
        except ServiceException as error:
            self._graph.warn(Code.NRP280, str(error))
            return "aborted"
        if response_key is not None:
            userdata[response_key] = answer
        chosen = None if self._response_cb is None else self._response_cb(userdata, answer)
        if chosen or getattr(answer, "success", True):
            return chosen or "succeeded"
        self._graph.warn(
            Code.NRP280, f"service {self._name}: {getattr(answer, 'status_message', 'no success')}"
        )
        return "aborted"


class SetMaterialColorServiceState(ServiceState):
    """Sets the material of a visual."""

    def __init__(
        self,
        graph: Graph,
        services: Services,
        model_name: str,
        link_name: str,
        visual_name: str,
        material_name: str,
        delay: float = 0.0,
        *_keys: Any,
    ) -> None:
        super().__init__(graph, services, "/gazebo/set_visual_properties")
        self._delay_s = float(delay)
        self.values = (model_name, link_name, visual_name, "material:script:name", material_name)

    def execute(self, userdata: Any) -> str:
        task = Task.here()
        if task is not None and self._delay_s > 0:
            task.wait_until(self._graph.now_ns + round(self._delay_s * NS_PER_S))
        try:
            answer = self._services.call(self._name, *self.values)
        except ServiceException as error:
            self._graph.warn(Code.NRP280, str(error))
            return "aborted"
        if not answer.success:
            self._graph.warn(Code.NRP280, f"service {self._name}: {answer.status_message}")
            return "aborted"
        return "succeeded"


class ClientLogState(State):
    """Shows a text to the user."""

    def __init__(self, graph: Graph, text: str, *_keys: Any, **_more: Any) -> None:
        super().__init__(SERVED)
        self._logger, self._text = ClientLogger(graph), text

    def execute(self, userdata: Any) -> str:
        self._logger.info(self._text)
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
        ClientLogState=bound(ClientLogState, graph),
        WaitForClientLogState=bound(WaitForClientLogState, graph),
        **model_states(graph, services),
    )
