"""The decorators that turn a function into a transfer function."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isfinite
from typing import Any, ClassVar

from nrp_core.dsl.functions.collector import register
from nrp_core.dsl.functions.function import TIME, Flow, TransferFunction
from nrp_core.dsl.parameters.source_line import SourceLine
from nrp_core.dsl.parameters.topics import Topic


class _FunctionDecorator:
    """Base of the decorators; :class:`Robot2Neuron` documents the arguments."""

    flow: ClassVar[Flow]
    topic: Topic | None = None

    def __init__(
        self,
        triggers: str | Sequence[str] | None = None,
        throttling_rate: float | None = None,
        *,
        priority: int = 0,
    ) -> None:
        self.place = SourceLine.of_caller()
        if not (triggers is None or isinstance(triggers, (str, list, tuple))):
            raise self.place.error(f"triggers are names of parameters, not {triggers!r}")
        if not (throttling_rate is None or _is_positive(throttling_rate)):
            raise self.place.error(f"throttling_rate is a positive rate in Hz, not {throttling_rate!r}")
        if not isinstance(priority, int):
            raise self.place.error(f"priority is an integer, not {priority!r}")
        self._triggers = TIME if triggers is None else triggers
        self._throttling_rate = throttling_rate
        self._priority = priority

    def __call__(self, function: Callable[..., Any]) -> TransferFunction:
        """Return the transfer function, registered with the current collector."""
        if isinstance(function, TransferFunction):
            raise self.place.error(
                f"'{function.name}' is already a transfer function; "
                f"@{self.flow.value} must be the last decorator, directly above the function"
            )
        if not hasattr(function, "__code__"):
            raise self.place.error(f"@{self.flow.value} decorates a function, not {function!r}")
        made = self._made(function)
        register(made)
        return made

    def _made(self, function: Callable[..., Any]) -> TransferFunction:
        return TransferFunction(
            function, flow=self.flow, topic=self.topic, triggers=self._triggers,
            throttling_rate=self._throttling_rate, priority=self._priority,
        )  # fmt: skip


class Neuron2Robot(_FunctionDecorator):
    """Marks a function from the brain to the robot.

    Args:
        robot_topic: the topic that the return value is published on, unless the value is None. Without a
                topic the value is ignored.
        triggers, throttling_rate, priority: see :class:`Robot2Neuron`.
    """

    flow = Flow.NEURON_TO_ROBOT

    def __init__(
        self,
        robot_topic: Topic | str | None = None,
        triggers: str | Sequence[str] | None = None,
        throttling_rate: float | None = None,
        *,
        priority: int = 0,
    ) -> None:
        super().__init__(triggers, throttling_rate, priority=priority)
        self.topic = None if robot_topic is None else Topic.of(robot_topic)


class Robot2Neuron(_FunctionDecorator):
    """Marks a function from the robot to the brain; its return value is ignored.

    Args:
        triggers: names of subscribed topics and spike recorders; a message or spike of one of them makes the
            function run. By default it runs every step.
        throttling_rate: the largest number of runs per second.
        priority: functions with a higher priority run first within a step.

    Raises:
        TransferFunctionError: an argument is invalid.
    """

    flow = Flow.ROBOT_TO_NEURON


def _is_positive(rate: object) -> bool:
    return isinstance(rate, (int, float)) and not isinstance(rate, bool) and isfinite(rate) and rate > 0
