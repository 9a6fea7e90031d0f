"""Transfer functions and the decorators that make them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from enum import Enum
from math import isfinite
from typing import Any, ClassVar, NamedTuple, Self, get_args

from nrp_core.brain.interface import Brain
from nrp_core.clock import seconds
from nrp_core.dsl.calls import ONCE, Call, Calls, Throttle, calls_for_messages
from nrp_core.dsl.copies import Copies, gathered, rows_of
from nrp_core.dsl.parameters import (
    Adapter,
    Binding,
    ParameterMapping,
    PublishedTopic,
    SourceLine,
    SubscribedTopic,
    Topic,
)
from nrp_core.errors import ExperimentError, LifecycleError, TopicError, TriggerError, did_you_mean
from nrp_core.world.world import World

_collected: ContextVar[list[TransferFunction] | None] = ContextVar("collected", default=None)


@contextmanager
def collecting() -> Iterator[list[TransferFunction]]:
    """Collect the transfer functions declared in this context, in order.

    Each thread or task has a context of its own, so experiments can load concurrently.
    """
    functions: list[TransferFunction] = []
    token = _collected.set(functions)
    try:
        yield functions
    finally:
        _collected.reset(token)


def register(function: TransferFunction) -> None:
    """Add a function to the current collection, if any.

    Raises:
        TransferFunctionError: the name is taken.
    """
    functions = _collected.get()
    if functions is not None:
        require_new_name(function, functions)
        functions.append(function)


def require_new_name(function: TransferFunction, others: Iterable[TransferFunction]) -> None:
    """Refuse a function whose name is taken.

    Raises:
        TransferFunctionError: the name is taken.
    """
    for other in others:
        if other.name == function.name:
            raise function.place.error(name_taken_message(function.name, other.place))


def name_taken_message(name: str, place: object) -> str:
    """Return the message about a function whose name is already taken by a function at a place."""
    return f"the transfer function '{name}' already exists, at {place}; rename one"


TIME = "t"


class Flow(Enum):
    """The direction in which a transfer function mainly carries information."""

    NEURON_TO_ROBOT = "Neuron2Robot"
    ROBOT_TO_NEURON = "Robot2Neuron"


class TransferFunction:
    """A decorated function. Calling it calls the undecorated function with the given arguments.

    Once bound, each parameter's device, topic or variable is an attribute:
    ``linear_twist.left_wheel_neuron``.

    Args:
        function: its first parameter is ``t``, the simulated time in seconds; mappings bind the others.
        flow: its direction.
        topic: the topic of its return value; None: the value is ignored.
        triggers: names of parameters whose new messages or spikes make it run; ``t``: every step.
        calls: whether the messages of a step make it run ``once``, or ``each`` of them makes it run.
        throttling_rate: the largest number of runs per second.
        priority: functions with a higher priority run first within a step.
        vectorized: whether its arguments are :class:`~nrp_core.dsl.copies.Copies`.

    Attributes:
        deferring: the parameters with changes that wait for :meth:`deliver`, once bound.
        publisher: publishes its return value, once bound; None without a topic.
        runs_users_code: whether :meth:`prepare` and :meth:`complete` run users' code, such as
            ``pre_processing``.
        origin: equal for functions of one file with the same text and the same values of parameters, which
            copies call together; by default its module.

    Raises:
        TransferFunctionError: the function has another form.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        *,
        flow: Flow,
        topic: Topic | None = None,
        triggers: Sequence[str] = (TIME,),
        throttling_rate: float | None = None,
        priority: int = 0,
        calls: Calls = "once",
        vectorized: bool = False,
    ) -> None:
        self.function, self.vectorized = function, vectorized
        self.name = function.__name__
        self.__code__ = inspect.unwrap(function).__code__
        self.origin: Hashable = id(inspect.unwrap(function).__globals__)
        self.place = SourceLine.of_code(self.__code__)
        self.__doc__ = function.__doc__
        self.flow, self.topic, self.priority = flow, topic, priority
        self.parameters = self._parameters_of(function)
        self.triggers, self.calls = self._checked_triggers(triggers), calls
        self._runs_each_step = TIME in self.triggers
        self.throttle = Throttle(throttling_rate)
        self.mappings: dict[str, ParameterMapping] = {}
        self._adapters: dict[str, Adapter] = {}
        self.deferring: dict[str, Adapter] = {}
        self._arguments: tuple[Adapter, ...] | None = None
        self._active = True

    # -- declaration

    def _parameters_of(self, function: Callable[..., Any]) -> tuple[str, ...]:
        if not _runs_when_called(function):
            raise self._error("must be a plain function, not a generator and not async")
        given = inspect.signature(function).parameters.values()
        if any(p.kind is not inspect.Parameter.POSITIONAL_OR_KEYWORD for p in given):
            raise self._error("takes plain parameters only, no *, ** or /")
        names = [parameter.name for parameter in given]
        if names[:1] != [TIME]:
            raise self._error("must have the time, t, as its first parameter")
        return tuple(names[1:])

    def _checked_triggers(self, triggers: Sequence[str]) -> tuple[str, ...]:
        names = (triggers,) if isinstance(triggers, str) else tuple(triggers)
        for name in names:
            if name not in (TIME, *self.parameters):
                hint = did_you_mean(name, self.parameters)
                raise self._trigger_error(f"'{name}', which is not one of its parameters{hint}")
        return names

    def add(self, mapping: ParameterMapping) -> None:
        """Bind a parameter.

        Raises:
            TransferFunctionError: the parameter does not exist, or is already bound.
        """
        name = mapping.parameter
        if name == TIME:
            raise mapping.place.error("the parameter 't' is the simulation time and cannot be mapped")
        if name not in self.parameters:
            hint = did_you_mean(name, self.parameters)
            message = f"'{self.name}' has no parameter '{name}' to map{hint}"
            raise mapping.place.error(message, hint.instead)
        if name in self.mappings:
            first = self.mappings[name].place
            raise mapping.place.error(f"'{self.name}': parameter '{name}' is mapped twice, first at {first}")
        self.mappings[name] = mapping

    @property
    def subscribed(self) -> list[Topic]:
        """The topics that it reads."""
        return [mapping.reads for mapping in self.mappings.values() if mapping.reads is not None]

    @property
    def published(self) -> list[Topic]:
        """The topics that it publishes, including the topic of its return value."""
        written = [mapping.writes for mapping in self.mappings.values() if mapping.writes is not None]
        return written if self.topic is None else [*written, self.topic]

    # -- binding

    @property
    def is_bound(self) -> bool:
        """Whether the parameters are bound to a brain and a world."""
        return self._arguments is not None

    @property
    def adapters(self) -> dict[str, Adapter]:
        """The device, topic or variable of each parameter, once bound."""
        return self._adapters

    def bind(self, brain: Brain, world: World, *, variables: dict[str, Any] | None = None) -> Self:
        """Bind every parameter to its device, topic or variable.

        Args:
            brain: the brain.
            world: the world.
            variables: the variables that functions share; by default none.

        Raises:
            ExperimentError: a parameter is not mapped, or names something that does not exist.
            LifecycleError: the function is already bound.
        """
        if self.is_bound:
            raise LifecycleError(f"transfer function '{self.name}' is already bound; call unbind() first")
        self.require_mappings()
        binding = Binding(self.name, brain, world, {} if variables is None else variables)
        try:
            self._connect(binding)
        except BaseException:
            self.unbind()
            raise
        return self

    def require_mappings(self) -> None:
        """Require a mapping of each parameter.

        Raises:
            TransferFunctionError: a parameter is not mapped.
        """
        for parameter in self.parameters:
            if parameter not in self.mappings:
                raise self._error(f"has no mapping for its parameter '{parameter}', e.g. with MapSpikeSink")

    def _connect(self, binding: Binding) -> None:
        for parameter in self.parameters:
            self._adapters[parameter] = self.mappings[parameter].bind(binding)
        self.publisher = self._publisher_of(binding)
        triggering = [self._trigger(name) for name in self.triggers if name != TIME]
        each = triggering if self.calls == "each" else []
        self._called_by = [adapter for adapter in each if isinstance(adapter, SubscribedTopic)]
        self._triggering = [adapter for adapter in triggering if adapter not in self._called_by]
        still, plain = Adapter.refresh, Adapter.commit
        self._refreshed = [a for a in self._adapters.values() if type(a).refresh is not still]
        self._committed = {n: a for n, a in self._adapters.items() if type(a).commit is not plain}
        later = Adapter.deliver
        self.deferring = {n: a for n, a in self._adapters.items() if type(a).deliver is not later}
        self._arguments = tuple(self._adapters.values())
        used = self._arguments if self.publisher is None else (*self._arguments, self.publisher)
        self.runs_users_code = any(adapter.runs_users_code() for adapter in used)
        self.active = self._active

    def _trigger(self, name: str) -> Adapter:
        adapter = self._adapters[name]
        if adapter.has_news() is None:
            raise self._trigger_error(f"'{name}'; only subscribed topics and spike recorders can trigger it")
        return adapter

    def _publisher_of(self, binding: Binding) -> PublishedTopic | None:
        try:
            return None if self.topic is None else PublishedTopic(binding.world, self.topic)
        except TopicError as error:
            context = f"return value of transfer function '{self.name}'"
            raise self.place.located(error, context) from None

    def unbind(self) -> None:
        """Release its devices and topics in brain and world."""
        for adapter in self._adapters.values():
            adapter.release()
        self._adapters = {}
        self._arguments = None

    # -- running

    @property
    def active(self) -> bool:
        """Whether it runs; the devices of an inactive function are silent."""
        return self._active

    @active.setter
    def active(self, active: bool) -> None:
        self._active = active
        for adapter in self._adapters.values():
            adapter.set_active(active)
            if active:
                adapter.set_read(True)

    def quarantine(self) -> None:
        """Deactivate it until it is replaced or reset: its sensors are no longer read."""
        self.active = False
        for adapter in self._adapters.values():
            adapter.set_read(False)

    def calls_due(self, t_ns: int, t: float | None = None) -> Iterable[Call]:
        """Return its calls in the step that began at ``t_ns``, in order; they receive ``t`` (s)."""
        if not self._active:
            return ()
        if self._called_by:
            return self._calls_for_messages(t_ns, t)
        is_due = (self._runs_each_step or self._is_triggered()) and self.throttle.admits(t_ns, t)
        return ONCE if is_due else ()

    def _calls_for_messages(self, t_ns: int, t: float | None) -> Iterator[Call]:
        yield from calls_for_messages(self._called_by, self.throttle.admits)
        if self._is_triggered() and self.throttle.admits(t_ns, t):
            yield Call()

    def _is_triggered(self) -> bool:
        return self._runs_each_step or any(one.has_news() for one in self._triggering)

    def run(self, now_ns: int, t: float | None = None, call: Call = ONCE[0]) -> Any:
        """Run it on its bound parameters, and send its return value to its topic.

        Changes of weights and the like wait for :meth:`deliver`.

        Args:
            now_ns: the time that brain and world have reached.
            t: the time in seconds that is passed to the function; by default ``now_ns``.
            call: which of the calls in this step it is; one for a message passes the time of the message.

        Raises:
            LifecycleError: it is not bound.
            TopicError: its topic cannot carry the return value.
            NetworkError: it has set an impossible weight.
        """
        prepared = self.prepare(now_ns, t, call)
        if self.vectorized:
            (result,) = call_for_copies([(self, prepared)])
        else:
            result = self.function(prepared, *self._arguments)  # type: ignore[misc]  # it is bound
        self.complete(result)
        return result

    def prepare(self, now_ns: int, t: float | None, call: Call) -> float:
        """Update its parameters for a call, as :meth:`run` does; return the time for the function, s."""
        if self._arguments is None:
            raise LifecycleError(f"'{self.name}' is not bound; call bind(brain, world) first")
        if call.t_ns is None:
            for adapter in self._refreshed:
                adapter.refresh(now_ns)
        else:
            t = seconds(call.t_ns)
            self._refresh_for(call, now_ns)
        return seconds(now_ns) if t is None else t

    def complete(self, result: Any) -> None:
        """Apply what a call has changed, and send its return value, as :meth:`run` does."""
        for name, changed in self._committed.items():
            self._finish(name, changed.commit)
        if result is not None and self.publisher is not None:
            try:
                if isinstance(result, _Numbers):
                    self.publisher.send_numbers(result.numbers)
                else:
                    self.publisher.send_message(result)
            except TopicError as error:
                raise self.place.located(error, f"return value of '{self.name}'") from None

    def _refresh_for(self, call: Call, now_ns: int) -> None:
        """Show the messages up to a given one, and the present state of the devices."""
        assert call.t_ns is not None
        counts = dict(zip(map(id, self._called_by), call.messages, strict=True))
        for adapter in self._refreshed:
            if isinstance(adapter, SubscribedTopic):
                adapter.refresh_until(call.t_ns, counts.get(id(adapter)))
            else:
                adapter.refresh(now_ns)

    def deliver(self) -> None:
        """Apply the changes that wait until all functions of the step have run.

        Raises:
            NetworkError: it has set an impossible weight.
        """
        for name, changed in self.deferring.items():
            self._finish(name, changed.deliver)

    def _finish(self, parameter: str, apply: Callable[[], None]) -> None:
        try:
            apply()
        except ExperimentError as error:
            raise self.place.located(error, f"parameter '{parameter}' of '{self.name}'") from None

    def reset(self) -> None:
        """Return to the state at time 0."""
        self.throttle.reset()
        for adapter in self._adapters.values():
            adapter.reset()

    def save(self) -> Any:
        """Return its own state; brain and world save theirs."""
        adapters = {name: (_kind(adapter), adapter.save()) for name, adapter in self._adapters.items()}
        return self._active, self.throttle.save(), adapters

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`, of this function or one of the same name.

        Parameters that are new or of another kind keep their values.
        """
        self._active, throttle, adapters = saved
        for bound in self._adapters.values():
            bound.set_read(True)
        self.throttle.restore(throttle)
        for name, (kind, state) in adapters.items():
            adapter = self._adapters.get(name)
            if adapter is not None and _kind(adapter) == getattr(kind, "__qualname__", kind):  # once a class
                adapter.restore(state)

    def inputs(self) -> dict[str, str]:
        """Return the values of its parameters as text, for reports."""
        shown = {name: adapter.value_text() for name, adapter in self._adapters.items()}
        return {name: text for name, text in shown.items() if text}

    # -- Python's protocols

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return self.function(*args, **kwargs)

    def __getattr__(self, name: str) -> Any:
        adapters, parameters = self.__dict__.get("_adapters", {}), self.__dict__.get("parameters", ())
        if name in adapters:
            return adapters[name]
        if name in parameters:
            raise AttributeError(f"'{self.name}' is not bound; bind(brain, world) creates '{name}'")
        raise AttributeError(f"transfer function has no attribute '{name}'{did_you_mean(name, parameters)}")

    def __repr__(self) -> str:
        parameters = ", ".join((TIME, *self.parameters))
        return f"<{self.flow.value} {self.name}({parameters}) at {self.place}>"

    def __str__(self) -> str:
        lines = [f"{self.flow.value} {self.name}, {self.place}"]
        lines += [f"  {name}: {self.mappings.get(name, 'not mapped')}" for name in self.parameters]
        lines += [] if self.topic is None else [f"  returns to {self.topic}"]
        return "\n".join(lines)

    def _error(self, message: str) -> ExperimentError:
        return self.place.error(f"transfer function '{self.name}' {message}")

    def _trigger_error(self, message: str) -> TriggerError:
        message = f"transfer function '{self.name}' cannot be triggered by {message}"
        return TriggerError(message, path=self.place.path, line=self.place.line)


class _Numbers(NamedTuple):
    """The numbers that a message consists of, as a result of a call for several copies."""

    numbers: Sequence[float]


def call_for_copies(calls: Sequence[tuple[TransferFunction, float]]) -> Sequence[Any]:
    """Call a vectorised function once for several copies.

    Args:
        calls: the function of each copy, prepared, and its time, s.

    Returns:
        The result for each copy, for :meth:`TransferFunction.complete`.
    """
    functions, times = zip(*calls, strict=True)
    arguments = (Copies(each) for each in zip(*(one.adapters.values() for one in functions), strict=True))
    result, n = functions[0].function(gathered([*times]), *arguments), len(functions)
    publisher = functions[0].publisher
    rows = None if publisher is None or n == 1 else publisher.rows_in(result, n)
    return rows_of(result, n) if rows is None else [_Numbers(row) for row in rows]


def _runs_when_called(function: Callable[..., Any]) -> bool:
    waiting = (inspect.isgeneratorfunction, inspect.iscoroutinefunction, inspect.isasyncgenfunction)
    return not any(waits(function) for waits in waiting)


def _kind(adapter: Adapter) -> str:
    """Return the name of an adapter's class; a class that a functions file defines cannot be pickled."""
    return type(adapter).__qualname__


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
        calls: Calls = "once",
        vectorized: bool = False,
    ) -> None:
        self.place = SourceLine.of_caller()
        if not (triggers is None or isinstance(triggers, (str, list, tuple))):
            raise self.place.error(f"triggers are names of parameters, not {triggers!r}")
        if not (throttling_rate is None or _is_positive(throttling_rate)):
            raise self.place.error(f"throttling_rate is a positive rate in Hz, not {throttling_rate!r}")
        if not isinstance(priority, int):
            raise self.place.error(f"priority is an integer, not {priority!r}")
        if calls not in get_args(Calls):
            raise self.place.error(f"calls is 'once' or 'each', not {calls!r}")
        if calls == "each" and triggers in (None, TIME):
            raise self.place.error("calls='each' needs the topics whose messages call it: triggers=[...]")
        self._triggers = TIME if triggers is None else triggers
        self._throttling_rate = throttling_rate
        self._priority, self._calls, self._vectorized = priority, calls, vectorized

    def __call__(self, function: Callable[..., Any]) -> TransferFunction:
        """Return the transfer function, registered with the current collector."""
        if isinstance(function, TransferFunction):
            raise self.place.error(
                f"'{function.name}' is already a transfer function; "
                f"@{self.flow.value} must be the last decorator, directly above the function"
            )
        if not hasattr(function, "__code__"):
            raise self.place.error(f"@{self.flow.value} decorates a function, not {function!r}")
        made = self._make(function)
        register(made)
        return made

    def _make(self, function: Callable[..., Any]) -> TransferFunction:
        return TransferFunction(
            function, flow=self.flow, topic=self.topic, triggers=self._triggers,
            throttling_rate=self._throttling_rate, priority=self._priority, calls=self._calls,
            vectorized=self._vectorized,
        )  # fmt: skip


class Neuron2Robot(_FunctionDecorator):
    """Marks a function from the brain to the robot.

    Args:
        robot_topic: the topic that the return value is published on, unless the value is None. Without a
                topic the value is ignored.
        triggers, throttling_rate, priority, calls, vectorized: see :class:`Robot2Neuron`.
    """

    flow = Flow.NEURON_TO_ROBOT

    def __init__(
        self,
        robot_topic: Topic | str | None = None,
        triggers: str | Sequence[str] | None = None,
        throttling_rate: float | None = None,
        *,
        priority: int = 0,
        calls: Calls = "once",
        vectorized: bool = False,
    ) -> None:
        super().__init__(triggers, throttling_rate, priority=priority, calls=calls, vectorized=vectorized)
        self.topic = None if robot_topic is None else Topic.of(robot_topic)


class Robot2Neuron(_FunctionDecorator):
    """Marks a function from the robot to the brain; its return value is ignored.

    Args:
        triggers: names of subscribed topics and spike recorders; a message or spike of one of them makes the
            function run. By default it runs every step.
        throttling_rate: the largest number of runs per second.
        priority: functions with a higher priority run first within a step.
        calls: ``once``: the function runs once in a step in which messages came, and has all of them in
            ``.messages``. ``each``: it runs once for each message of a triggering topic, in the order of
            their times; ``t`` is the time of the message, and every topic shows its last message by then. A
            spike recorder makes it run once in a step.
        vectorized: whether it is called once for all copies that an environment steps together: numbers of
            its parameters and messages are arrays, whose first axis is that of the copies. A run alone is
            one copy.

    Raises:
        TransferFunctionError: an argument is invalid.
    """

    flow = Flow.ROBOT_TO_NEURON


def _is_positive(rate: object) -> bool:
    return isinstance(rate, (int, float)) and not isinstance(rate, bool) and isfinite(rate) and rate > 0
