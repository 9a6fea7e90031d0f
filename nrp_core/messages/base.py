"""Dataclasses as messages."""

from __future__ import annotations

import dataclasses
import posixpath
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache, partial
from importlib import import_module
from importlib.util import find_spec
from itertools import islice
from math import inf, isfinite
from operator import attrgetter
from typing import Any, TypeVar, cast, dataclass_transform, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt

from nrp_core._support.checked_arguments import checks_arguments
from nrp_core.clock import NS_PER_S

T = TypeVar("T")

_TYPES: dict[str, type] = {}
_PACKAGE = __name__.rpartition(".")[0]


@dataclass_transform(field_specifiers=(dataclasses.field,))
@checks_arguments()
def message(name: str, definition: str = "") -> Callable[[type[T]], type[T]]:
    """Name a class as a message type, and make it a dataclass with slots if it is not a dataclass.

    Args:
        name: ROS's full name, ``package/msg/Type``.
        definition: its fields in ROS's format; needed if the type hints do not give the size of a number.
    """

    def register(cls: type[T]) -> type[T]:
        if "__dataclass_fields__" not in vars(cls):
            cls = dataclass(slots=True)(cls)
        cls.__msgtype__ = name  # type: ignore[attr-defined]
        cls.__definition__ = definition  # type: ignore[attr-defined]
        _TYPES[name] = cls
        return cls

    return register


def array_field(dtype: npt.DTypeLike = np.float64, size: int = 0) -> Any:
    """Return a field whose default is a new array of zeros, by default of none."""
    return dataclasses.field(default_factory=partial(np.zeros, size, dtype))


def type_of(name: str) -> type | None:
    """Return the message class of a full (``a/msg/B``) or short (``a/B``) name, or None."""
    full = name if name.count("/") == 2 else name.replace("/", "/msg/")
    if full not in _TYPES:
        _import_package(name.partition("/")[0])
    return _TYPES.get(full)


@cache
def _import_package(package: str) -> None:
    """Import our modules that define the messages of a package, if any."""
    for name in {package, package.replace("_msgs", "_srvs")}:
        if package.isidentifier() and find_spec(f"{_PACKAGE}.{name}") is not None:
            import_module(f"{_PACKAGE}.{name}")


def message_classes() -> list[type]:
    """Return the loaded message classes that have a name."""
    return list(_TYPES.values())


def type_name(cls: type) -> str:
    """Return the ROS name of a message class; for any other dataclass its class name."""
    return str(getattr(cls, "__msgtype__", cls.__name__))


def alias(field: str) -> property:
    """Return an attribute that is a field by its name in ROS 1."""
    return property(attrgetter(field), lambda self, value: setattr(self, field, value))


_SECS, _NSECS = alias("sec"), alias("nanosec")


@message("builtin_interfaces/msg/Time")
class Time:
    """A time stamp."""

    sec: int = 0
    nanosec: int = 0

    @classmethod
    def from_ns(cls, t_ns: int) -> Time:
        """Build a stamp from nanoseconds."""
        return cls(*divmod(t_ns, NS_PER_S))

    secs, nsecs = _SECS, _NSECS

    def to_ns(self) -> int:
        """Return nanoseconds."""
        return self.sec * NS_PER_S + self.nanosec

    def to_sec(self) -> float:
        """Return seconds."""
        return self.to_ns() / NS_PER_S


TIME_ZERO = Time()


@message("builtin_interfaces/msg/Duration")
class Duration:
    """A duration."""

    sec: int = 0
    nanosec: int = 0

    secs, nsecs = _SECS, _NSECS


def ns_of(time: Time | Duration) -> int:
    """Return a time or a duration in nanoseconds."""
    return time.sec * NS_PER_S + time.nanosec


def invalid_field(value: Any) -> str | None:
    """Return the error in the fields of a message, or None.

    A float field must hold a finite number, other plain fields a value of their type. Nested messages and
    lists of them are checked, arrays are not (a laser's range may be infinite).
    """
    cls: type = type(value)
    for field, kind, nested, listed in _fields(cls):
        item = getattr(value, field)
        if type(item) is float and kind is float:  # the most common case
            wrong = None if -inf < item < inf else f" is {item}"
        elif (type(item) is kind and kind in _EXACT) or (type(item) is np.ndarray and listed):
            wrong = None
        elif nested and type(item) is kind:
            wrong = None if holds_finite_floats(item) else _within(invalid_field(item), "")
        elif isinstance(item, list) and listed:
            if not item or _PLAIN.keys() >= {*map(type, item)}:  # no messages
                continue
            wrong = _first(_within(invalid_field(m), f"[{i}]") for i, m in enumerate(item) if _is_message(m))
        else:
            wrong = _invalid_value(item, kind)
        if wrong:
            return f"{field}{wrong}"
    return None


def holds_finite_floats(value: Any) -> bool:
    """Return whether all fields are finite floats or messages of finite floats, faster than field by field.

    Integers are as good as floats, of which they have the size.
    """
    cls: type = type(value)
    quick = _all_floats(cls)
    if quick is None:
        return False
    read, kinds, first = quick
    try:
        held = read(value)
    except AttributeError:  # a field holds a message of another type
        return False
    found = tuple(map(type, held))
    if found == kinds:
        return isfinite(sum(held[first:]))
    if found[:first] != kinds[:first] or not {*found[first:]} <= {int, float}:
        return False
    return all(-_LARGEST <= number <= _LARGEST for number in held[first:])


_MOST_WITHIN = 100
"""Maximum depth of nested messages that are read at once; one that contains its own type is infinite."""
_PLAIN: dict[Any, tuple[tuple[type, ...], str]] = {
    float: ((int, float, np.integer, np.floating), "a number"),
    int: ((int, np.integer), "a whole number"),
    bool: ((bool, int, np.bool_), "true or false"),
    str: ((str,), "a text"),
}


_EXACT = (int, bool, str)  # every value of these types is valid
_LISTS = (list, tuple, np.ndarray)
_LARGEST = sys.float_info.max  # integers have no such limit


def _invalid_value(item: Any, kind: Any) -> str | None:
    """Return the error for a value that is not a list, to follow the name of its field."""
    if get_origin(kind) is list:
        return None if isinstance(item, _LISTS) else f" must be a list, not {item!r:.40}"
    if kind not in _PLAIN:
        return _invalid_message(item, kind) if dataclasses.is_dataclass(kind) else None
    accepted, what = _PLAIN[kind]
    if not isinstance(item, accepted):
        return f" must be {what}, not {item!r:.40}"
    if kind is not float or (
        abs(item) <= _LARGEST if isinstance(item, int) else -inf < cast("float", item) < inf
    ):
        return None
    return f" is {item!s:.40}"


def _invalid_message(item: Any, kind: Any) -> str | None:
    if type(item) is not kind and not isinstance(item, kind) and type_name(type(item)) != type_name(kind):
        return f" must be a {type_name(kind)}, not {item!r:.40}"
    return _within(invalid_field(item), "")


def _within(wrong: str | None, place: str) -> str | None:
    return wrong and f"{place}.{wrong}"


def _is_message(item: Any) -> bool:
    return dataclasses.is_dataclass(item) and not isinstance(item, type)


def _first(found: Iterable[str | None]) -> str | None:
    return next(filter(None, found), None)


@lru_cache(maxsize=256)
def _all_floats(cls: type) -> tuple[Callable[[Any], tuple[Any, ...]], tuple[type, ...], int] | None:
    """Return a reader of all fields of a message of floats, nested messages first; None for other messages.

    Returns:
        The reader, the types of the values, and the number of nested messages.
    """
    if not dataclasses.is_dataclass(cls):
        return None
    messages: list[tuple[str, type]] = []
    floats: list[tuple[str, type]] = []
    within = [("", cls)]
    for prefix, owner in within:
        for name, kind, nested, _ in _fields(owner):
            (messages if nested else floats).append((prefix + name, kind))
            if nested and len(within) < _MOST_WITHIN:
                within.append((f"{prefix}{name}.", kind))
    paths, kinds = [path for path, _ in messages + floats], tuple(kind for _, kind in messages + floats)
    if len(paths) < 2 or len(within) == _MOST_WITHIN or any(kind is not float for _, kind in floats):
        return None
    return attrgetter(*paths), kinds, len(messages)


@lru_cache(maxsize=256)
def _fields(cls: type) -> tuple[tuple[str, Any, bool, bool], ...]:
    """Return name and declared type of each field, and whether it is a message, or may hold a list."""
    if not dataclasses.is_dataclass(cls):
        return ()
    try:
        hints = get_type_hints(cls)
    except (NameError, TypeError):  # the names of its file are gone: built-in types are still known
        hints = {}
    plain = {kind.__name__: kind for kind in _PLAIN}
    names = [spec.name for spec in dataclasses.fields(cls)]
    kinds = [hints.get(s.name) or plain.get(str(s.type), s.type) for s in dataclasses.fields(cls)]
    found = []
    for name, kind in zip(names, kinds, strict=True):
        nested = dataclasses.is_dataclass(kind)
        found.append((name, kind, nested, not nested and kind not in _PLAIN))
    return tuple(found)


class NumberLayout:
    """How a message that consists of floats only is built from them, and they are read from it.

    Args:
        paths: the path of each number in the message, ``linear.x``, in the order of the fields.
        build: builds the message from an iterator over the numbers.
    """

    def __init__(self, paths: Sequence[str], build: Callable[[Iterator[float]], Any]) -> None:
        self.paths, self.build = tuple(paths), build
        self._read = attrgetter(*paths)

    def message(self, numbers: Iterable[float]) -> Any:
        """Return the message with these numbers, one for each of :attr:`paths`."""
        return self.build(iter(numbers))

    def rows(self, message: Any, n: int) -> list[list[float]] | None:
        """Return the numbers in each of ``n`` messages, given one message of arrays or of common numbers.

        Returns:
            None if it has other values, integers too, or arrays of another length.
        """
        try:
            read: Any = self._read(message)
            values = (read,) if len(self.paths) == 1 else read
            rows = np.empty((n, len(values)))
            for k, value in enumerate(values):
                is_array = type(value) is np.ndarray and value.shape == (n,)
                if not (value.dtype.char in "efd" if is_array else type(value) is float):
                    return None
                rows[:, k] = value
        except (AttributeError, TypeError, ValueError):
            return None
        return rows.tolist()

    def numbers(self, message: Any) -> list[float]:
        """Return the numbers in a message."""
        read: Any = self._read(message)
        return [float(read)] if len(self.paths) == 1 else [*map(float, read)]


@lru_cache
def find_layout(cls: type) -> NumberLayout | None:
    """Return the layout of a message class; None if its messages hold anything but floats."""
    if not dataclasses.is_dataclass(cls):
        return None
    paths: list[str] = []
    builders: list[Callable[[Iterator[float]], Any]] = []
    example = cls()
    for field in dataclasses.fields(cls):
        value = getattr(example, field.name)
        if isinstance(value, float):
            paths.append(field.name)
            builders.append(next)
            continue
        inner: NumberLayout | None = find_layout(type(value))  # type: ignore[arg-type]
        if inner is None:
            return None
        paths += [f"{field.name}.{path}" for path in inner.paths]
        builders.append(inner.build)
    if not paths:
        return None
    if all(build is next for build in builders):
        return NumberLayout(paths, lambda numbers: cls(*islice(numbers, len(paths))))
    return NumberLayout(paths, lambda numbers: cls(*[build(numbers) for build in builders]))


def layout_of(cls: type) -> NumberLayout:
    """Return the layout of a message class whose messages consist of floats.

    Raises:
        TypeError: they do not.
    """
    layout = find_layout(cls)
    if layout is None:
        raise TypeError(f"messages of {type_name(cls)} do not consist of floats only")
    return layout


def resolve_name(name: str, namespace: str) -> str:
    """Return the absolute name of a topic: a relative one is below the namespace, as in ROS."""
    return posixpath.normpath(posixpath.join("/", namespace, name.removeprefix("~/")))
