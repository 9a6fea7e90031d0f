"""Parameters of transfer functions: bindings, topics, messages."""

from __future__ import annotations

import dataclasses
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from types import CodeType, TracebackType
from typing import Any, NamedTuple, TypeVar, final

import numpy as np

from nrp_core.brain.interface import Brain
from nrp_core.clock import seconds
from nrp_core.dsl.copies import rows_of
from nrp_core.dsl.messages import message_type
from nrp_core.dsl.selection import BrainRoot
from nrp_core.errors import (
    CapabilityError,
    ExperimentError,
    Instead,
    TopicError,
    TransferFunctionError,
    did_you_mean,
)
from nrp_core.findings import Code
from nrp_core.messages.base import find_layout, type_name
from nrp_core.world.topics import Publication, Stamped, TopicInfo
from nrp_core.world.world import World


class Adapter:
    """The value of a parameter in a transfer function."""

    __slots__ = ()

    def runs_users_code(self) -> bool:
        """Return whether :meth:`refresh`, :meth:`commit` or sending runs code of users, which may hang."""
        return not type(self).__module__.startswith("nrp_core.")

    def refresh(self, now_ns: int) -> None:
        """Update it just before the function runs."""

    def commit(self) -> None:
        """Apply the changes that the function made; called when the function has returned."""

    def deliver(self) -> None:
        """Apply changes that another function could read; called when all functions of the step have run."""

    def has_news(self) -> bool | None:
        """Return whether something came that the function has not seen; None: it triggers no function."""
        return None

    def reset(self) -> None:
        """Return to the state at time 0."""

    def set_active(self, active: bool) -> None:
        """Activate or silence it; it keeps its settings."""

    def set_read(self, is_read: bool) -> None:
        """Set whether the function reads it; a sensor without readers costs nothing."""

    def release(self) -> None:
        """Release its resources in brain and world."""

    def save(self) -> Any:
        """Return its own state; brain and world save theirs."""
        return None

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`."""

    def value_text(self) -> str:
        """Return the value that the function reads as text, for reports; empty if it only writes."""
        return ""


E = TypeVar("E", bound=ExperimentError)


@dataclass(frozen=True, slots=True)
class SourceLine:
    """A line of a file.

    Args:
        path: the file name that Python reports; ``<stdin>`` and the like if there is no file.
        line: 1-based.
    """

    path: str
    line: int

    @classmethod
    def of_caller(cls) -> SourceLine:
        """Return the line that called into this package, or into a module that extends it.

        Such a module defines the variable ``__extends_dsl__``.
        """
        frame = sys._getframe(1)
        while frame.f_back is not None and _is_language(frame.f_globals):
            frame = frame.f_back
        return cls(frame.f_code.co_filename, frame.f_lineno)

    @classmethod
    def of_code(cls, code: CodeType) -> SourceLine:
        """Return the first line of a function, including its decorators."""
        return cls(code.co_filename, code.co_firstlineno)

    def __str__(self) -> str:
        return f"{self.path}:{self.line}"

    def error(self, message: str, instead: Instead | None = None) -> TransferFunctionError:
        """Return an error at this line."""
        return TransferFunctionError(message, path=self.path, line=self.line, instead=instead)

    def located(self, error: E, context: str) -> E:
        """Return an error of the same class with its place; an error that has a place is unchanged."""
        if error.path is not None:
            return error
        message = f"{context}: {error.message}"
        return type(error)(message, path=self.path, line=self.line, instead=error.instead)


def line_in(trace: TracebackType | None, path: str) -> int | None:
    """Return the innermost line of a file in a traceback, or None."""
    line = None
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == path:
            line = trace.tb_lineno
        trace = trace.tb_next
    return line


def _is_language(names: Mapping[str, object]) -> bool:
    return str(names.get("__name__", "")).startswith(_PACKAGE) or "__extends_dsl__" in names


_PACKAGE = __name__.rpartition(".")[0] + "."


_LIMIT = 300


def brief(value: Any) -> str:
    """Return a value on one line: arrays by type and shape, messages by their fields."""
    text = _text(value)
    return text if len(text) <= _LIMIT else text[: _LIMIT - 3] + "..."


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray) and value.size > 3:
        return f"{value.dtype} array of shape {value.shape}"
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = (f"{item.name}={_text(getattr(value, item.name))}" for item in dataclasses.fields(value))
        return f"{type(value).__name__}({', '.join(fields)})"
    return repr(value).replace("\n", " ")


def _unchanged(message: Any) -> Any:
    return message


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic of the robot, or one that the user declares.

    Args:
        name: absolute, ``/husky/camera``.
        topic_type: the message class or its ROS name; None: the world's.

    Raises:
        TopicError: the message type does not exist.
    """

    name: str
    topic_type: Any = None

    def __post_init__(self) -> None:
        place = SourceLine.of_caller()
        if not isinstance(self.name, str) or not self.name:
            raise place.error(f"the name of a topic is a string such as '/husky/camera', not {self.name!r}")
        if self.topic_type is not None:
            try:
                object.__setattr__(self, "topic_type", message_type(self.topic_type))
            except TopicError as error:
                raise place.located(error, f"topic '{self.name}'") from None

    @classmethod
    def of(cls, given: Topic | str) -> Topic:
        """Return a topic that is given as an object or by name."""
        if isinstance(given, (Topic, str)):
            return given if isinstance(given, Topic) else cls(given)
        raise SourceLine.of_caller().error(f"expected a Topic or its name, not {given!r}")

    @property
    def process(self) -> Callable[[Any], Any]:
        """The function that converts each message."""
        return _unchanged

    def require_type(self, info: TopicInfo) -> None:
        """Refuse a topic of another type.

        Raises:
            TopicError: the type differs.
        """
        if self.topic_type is not None and type_name(self.topic_type) != type_name(info.type):
            raise TopicError(
                f"'{self.name}' carries {type_name(info.type)}, not {type_name(self.topic_type)}"
            )

    def __str__(self) -> str:
        return self.name if self.topic_type is None else f"{self.name} ({type_name(self.topic_type)})"


@dataclass(frozen=True, slots=True)
class PreprocessedTopic(Topic):
    """A topic with converted messages.

    Args:
        name, topic_type: the name and the message type of the topic.
        pre_processing: called with each message. It turns a received message into the ``value`` that the
            function reads, and a value that the function sends into the message.
    """

    pre_processing: Callable[[Any], Any] = _unchanged

    def __post_init__(self) -> None:
        Topic.__post_init__(self)
        if not callable(self.pre_processing):
            raise SourceLine.of_caller().error(
                f"topic '{self.name}': pre_processing must be a function, not {self.pre_processing!r:.60}"
            )

    @property
    def process(self) -> Callable[[Any], Any]:
        return self.pre_processing


class ReceivedMessage(NamedTuple):
    """A message on a topic.

    Attributes:
        t: when it came, s: the time of its sample plus the delay of the topic.
        value: the message.
    """

    t: float
    value: Any


class SubscribedTopic(Adapter):
    """The messages on a topic.

    Attributes:
        value: the last message; before the first message, the initial value.
        changed: whether a message came since the function last ran. A topic that can be read at any
            time, such as the poses of all models, has always changed.
    """

    __slots__ = (
        "_dropped", "_function", "_initial", "_new", "_process", "_received", "_seen", "_subscription",
        "_world", "changed", "value",
    )  # fmt: skip

    def __init__(self, world: World, topic: Topic, initial: Any = None, function: str = "") -> None:
        _require(topic, world)
        self._world, self._function = world, function
        self._subscription = world.subscribe(topic.name, depth=None)
        self._initial = initial
        self._process = topic.process
        self._seen: Stamped | None = None
        self._new: list[Stamped] = []
        self._received: list[ReceivedMessage] | None = None
        self._dropped = 0
        self.value = initial
        self.changed = False
        try:
            topic.require_type(self._subscription.topic)
        except TopicError:
            self.release()
            raise

    def __getattr__(self, name: str) -> Any:
        if name in self.__slots__ or name.startswith("__"):
            raise AttributeError(name)  # not set yet, as in a copy
        of_message = hasattr(self.value, name)
        hint = f"its message has: '.value.{name}'" if of_message else "its last message is its '.value'"
        raise AttributeError(
            f"the topic '{self.name}' has no attribute '{name}'; {hint}", name=name, obj=self
        )

    @property
    def messages(self) -> list[ReceivedMessage]:
        """All messages since the function last ran, oldest first, each with its time.

        The last of them is :attr:`value`. A topic that can be read at any time has one message in each call.
        If the function has not run for longer than a second, or than the period of its throttling rate, the
        messages before that are not in it; a finding of the run reports them.
        """
        if self._received is None:
            before, process = self._new[:-1], self._process
            self._received = [ReceivedMessage(seconds(one.t_ns), process(one.message)) for one in before]
            self._received += [ReceivedMessage(seconds(one.t_ns), self.value) for one in self._new[-1:]]
            if self._dropped:
                self._report_dropped()
        return self._received

    def _report_dropped(self) -> None:
        kept_s = seconds(self._subscription.keep_ns)
        message = (
            f"'{self._function}' did not run for so long that {self._dropped} messages of '{self.name}' were "
            f"dropped; '.messages' keeps those of the last {kept_s:g} s before a step"
        )
        self._world.warnings.add(Code.NRP282, message, subject=self.name)

    def runs_users_code(self) -> bool:
        return self._process is not _unchanged

    @property
    def info(self) -> TopicInfo:
        """The description of the topic."""
        return self._subscription.topic

    @property
    def name(self) -> str:
        """Name of the topic."""
        return self.info.name

    def has_news(self) -> bool:
        return self._subscription.has_news

    def refresh(self, now_ns: int) -> None:
        subscription = self._subscription
        self._dropped = subscription.dropped
        self._receive(subscription.take())

    def refresh_until(self, t_ns: int, most: int | None = None) -> None:
        """Show the messages until a time, at most ``most``, as new since the function last ran."""
        self._dropped = self._subscription.dropped
        until = sum(one.t_ns <= t_ns for one in self.untaken) if most is None else most
        self._receive(self._subscription.take(until))

    @property
    def untaken(self) -> tuple[Stamped, ...]:
        """The messages that came since the last refresh, oldest first."""
        return self._subscription.messages

    def _receive(self, new: list[Stamped]) -> None:
        """Show messages to the function as those since it last ran."""
        self._new, self._received = new, None
        self.changed = bool(new)
        if new:
            self._seen = new[-1]
            self.value = self._process(self._seen.message)

    def reset(self) -> None:
        self._seen, self._new, self._received, self._dropped = None, [], None, 0
        self.value = self._initial
        self.changed = False

    def save(self) -> Any:
        stored, untaken = self._subscription.save()
        return self.value, self.changed, self._seen, not untaken, stored

    def restore(self, saved: Any) -> None:
        self.value, self.changed, self._seen, is_taken, stored = saved
        self._new, self._received, self._dropped = [], None, 0
        if self._subscription.latest is None:  # the subscription began after the save
            self._subscription.restore(stored)
        if is_taken:
            self._subscription.take()

    def set_read(self, is_read: bool) -> None:
        self._subscription.is_read = is_read

    def release(self) -> None:
        self._world.unsubscribe(self._subscription)

    def value_text(self) -> str:
        return f"value = {brief(self.value)}"


class PublishedTopic(Adapter):
    """A topic that the function publishes on."""

    __slots__ = ("_layout", "_process", "_publication", "_wrap")

    def __init__(self, world: World, topic: Topic) -> None:
        _require(topic, world)
        self._publication: Publication = world.advertise(topic.name)
        topic.require_type(self._publication.topic)
        self._process = topic.process
        info = self._publication.topic
        self._wrap = _wrapper(info.type)
        is_plain = self._process is _unchanged and info.limits is None
        self._layout = find_layout(info.type) if is_plain else None

    def runs_users_code(self) -> bool:
        return self._process is not _unchanged

    @property
    def info(self) -> TopicInfo:
        """The description of the topic."""
        return self._publication.topic

    def send_message(self, message: Any) -> None:
        """Send a message; it takes effect in the next step.

        If the message type has one field, a plain number or string is its value.

        Raises:
            TopicError: the message has another type, or contains a number that is not finite.
        """
        message = self._process(message)
        self._publication.publish(self._wrap(message) if isinstance(message, _PLAIN) else message)

    @staticmethod
    def send_message_of_copies(topics: Sequence[PublishedTopic], message: Any) -> None:
        """Send a message of arrays, with a row for the topic of each copy."""
        n = len(topics)
        rows = topics[0].rows_in(message, n) if n > 1 else None
        if rows is None:
            for topic, own in zip(topics, rows_of(message, n), strict=True):
                topic.send_message(own)
            return
        for topic, row in zip(topics, rows, strict=True):
            topic.send_numbers(row)

    def rows_in(self, message: Any, n: int) -> list[list[float]] | None:
        """Return the numbers in a message of arrays, for :meth:`send_numbers` of ``n`` copies of the topic.

        Returns:
            None if the messages of the copies must be sent themselves.
        """
        if self._layout is None or type(message) is not self._publication.topic.type:
            return None
        return self._layout.rows(message, n)

    def send_numbers(self, numbers: Sequence[float]) -> None:
        """Send a message that consists of these numbers; see :meth:`send_message`."""
        self._publication.publish_numbers(numbers)


_OWN = "; declare a new topic under 'topics', or publish it in one function and read it in another"


def _require(topic: Topic, world: World) -> None:
    """Refuse a topic that does not exist.

    Raises:
        TopicError: the topic does not exist.
    """
    if topic.name in world.topics:
        return
    if reason := _not_commanded(topic.name, world):
        raise TopicError(f"no topic '{topic.name}': {reason}")
    elsewhere = [name for name, info in world.topics.items() if _is_namesake(topic, name, info)]
    hint = did_you_mean(topic.name, elsewhere or world.topics, cutoff=0.0 if elsewhere else 0.6)
    if hint.instead is not None:
        raise TopicError(f"no topic '{topic.name}'{hint}", instead=hint.instead)
    needs = f", which needs its type: Topic('{topic.name}', TYPE)" if topic.topic_type is None else ""
    raise TopicError(f"no topic '{topic.name}'{_OWN}{needs}")


def _not_commanded(name: str, world: World) -> str:
    """Return why the joint of a topic such as ``/arm/elbow/cmd_pos`` takes no commands; empty if it may."""
    robot, _, rest = name.removeprefix("/").partition("/")
    models = [model for model in world.scene.models if model.name == robot]
    for joint in (joint for model in models for joint in model.joints if rest == f"{joint.name}/cmd_pos"):
        if joint.mimic is not None:
            return f"the joint '{joint.name}' follows '{joint.mimic.leader}' and takes no commands"
        if joint.kind == "fixed":
            return f"the joint '{joint.name}' is fixed and takes no commands"
    return ""


def _is_namesake(topic: Topic, name: str, info: TopicInfo) -> bool:
    """Return whether a topic differs only by a prefix: ``/scan`` and ``/pioneer/scan``."""
    (shorter, longer) = sorted((topic.name, name), key=len)
    return info.type is topic.topic_type and longer.endswith(shorter) and longer != shorter


_PLAIN = (bool, int, float, str)


def _wrapper(kind: type) -> Callable[[Any], Any]:
    """Return a function that wraps a plain value in a message, or returns it unchanged to be refused."""
    if is_dataclass(kind) and len(fields(kind)) == 1:
        return kind
    return lambda value: value


@dataclass(frozen=True, slots=True)
class Binding:
    """The bindings of the parameters of one function.

    Args:
        function: its name.
        brain, world: the two sides.
        variables: the variables that all functions of an experiment share, by key.
    """

    function: str
    brain: Brain
    world: World
    variables: dict[str, Any] = field(default_factory=dict)

    @property
    def root(self) -> BrainRoot:
        """The root that selectors are evaluated on."""
        return BrainRoot(self.brain.network)


class ParameterMapping(ABC):
    """The binding of a parameter, with its line in the file.

    Args:
        parameter: name of the parameter.

    Attributes:
        reads: the topic that the mapping subscribes to, if any.
        writes: the topic that the mapping publishes on, if any.
    """

    reads: Topic | None = None
    writes: Topic | None = None

    def __init__(self, parameter: str) -> None:
        self.place = SourceLine.of_caller()
        if not isinstance(parameter, str):
            raise self.place.error(f"a mapping needs the name of a parameter, not {parameter!r}")
        self.parameter = parameter

    @final
    def bind(self, binding: Binding) -> Adapter:
        """Return the parameter's value for the function.

        Raises:
            ExperimentError: neurons, topic or settings do not exist; the message names the line of the
                binding.
            CapabilityError: the backend lacks a capability.
        """
        context = f"transfer function '{binding.function}', parameter '{self.parameter}'"
        try:
            return self._do_bind(binding)
        except ExperimentError as error:
            raise self.place.located(error, context) from None
        except CapabilityError as error:
            raise CapabilityError(f"{self.place}: {context}: {error}") from error
        except (ValueError, TypeError) as error:
            raise self.place.error(f"{context}: {error}") from error

    @abstractmethod
    def _do_bind(self, binding: Binding) -> Adapter: ...

    @abstractmethod
    def __str__(self) -> str:
        """A short description of the binding."""
