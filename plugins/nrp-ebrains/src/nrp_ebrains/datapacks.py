"""Datapacks: the data that functions and engines of NRP-core 4 exchange, as JSON or as a message."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from google.protobuf.message import Message

from nrp_core.errors import ExperimentError


class Identity(NamedTuple):
    """The name of a datapack and the engine that it is of."""

    name: str
    engine: str


class DataPackIdentifier:
    """The identity of a datapack as functions write it.

    Args:
        name: the name of the datapack.
        engine_name: its engine.
        type: the kind of its data, which is not used.
    """

    def __init__(self, name: str, engine_name: str, type: str = "") -> None:  # noqa: A002 - name of that program
        self.name, self.engine_name, self.type = name, engine_name, type

    @property
    def identity(self) -> Identity:
        """Name and engine."""
        return Identity(self.name, self.engine_name)


def plain(value: Any) -> Any:
    """Return a copy of data as JSON has it: numbers, texts, lists and dictionaries with texts as keys.

    Raises:
        TypeError: JSON has no such value.
    """
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, JsonData):
        return plain(value.value)
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    raise TypeError(f"a datapack holds numbers, texts, lists and dictionaries, not {type(value).__name__}")


class JsonData:
    """Data of a JSON datapack: null at first, an object after an item is set, a list after ``append``.

    Args:
        value: the data.
    """

    def __init__(self, value: Any = None) -> None:
        self.value = value

    def __getitem__(self, key: Any) -> Any:
        if self.value is None:
            raise KeyError(f"the datapack is empty: it has no {key!r}")
        return self.value[key]

    def __setitem__(self, key: Any, value: Any) -> None:
        if self.value is None:
            self.value = {}
        self.value[key] = plain(value)

    def append(self, value: Any) -> None:
        """Append an item to the list."""
        if self.value is None:
            self.value = []
        self.value.append(plain(value))

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or self.value is None:
            raise AttributeError(f"the data of a datapack has no '{name}'")
        return getattr(self.value, name)

    def __iter__(self) -> Iterator[Any]:
        return iter(self.value or ())

    def __len__(self) -> int:
        return len(self.value or ())

    def __bool__(self) -> bool:
        return bool(self.value)

    def __contains__(self, key: object) -> bool:
        return self.value is not None and key in self.value

    def __eq__(self, other: object) -> bool:
        return bool(self.value == (other.value if isinstance(other, JsonData) else other))

    __hash__ = None  # type: ignore[assignment] # it can change

    def __str__(self) -> str:
        """Return it as JSON."""
        return json.dumps(self.value)

    __repr__ = __str__

    def json_type(self) -> str:
        """Return the name of its type in JSON."""
        kinds: list[tuple[Any, str]] = [
            (type(None), "null"), (bool, "boolean"), (Mapping, "object"), (list, "array"), (str, "string"),
            (int, "number_integer"), (float, "number_float"),
        ]  # fmt: skip
        return next(name for kind, name in kinds if isinstance(self.value, kind))


_EMPTY = object()
"""The data of a datapack that has not arrived."""


@dataclass
class DataPack:
    """A datapack.

    Args:
        name: its name.
        engine_name: the engine that it is from, or for.
        content: its data; by default none.
        updated: whether it arrived in this iteration.
    """

    name: str
    engine_name: str
    content: Any = _EMPTY
    updated: bool = False

    @property
    def data(self) -> Any:
        """The data.

        Raises:
            ExperimentError: none exists yet.
        """
        if self.content is _EMPTY:
            raise ExperimentError(
                f"the datapack '{self.name}' of '{self.engine_name}' is empty; test isEmpty() first"
            )
        return self.content

    @property
    def identity(self) -> Identity:
        """Name and engine."""
        return Identity(self.name, self.engine_name)

    def isEmpty(self) -> bool:  # noqa: N802 - name of that program
        """Return whether it has no data yet."""
        return self.content is _EMPTY

    def isUpdated(self) -> bool:  # noqa: N802 - name of that program
        """Return whether it arrived in this iteration."""
        return self.updated

    def copy(self) -> DataPack:
        """Return the same data under a name that can be changed."""
        return DataPack(self.name, self.engine_name, self.content, self.updated)


class JsonDataPack(DataPack):
    """A datapack with JSON, empty at first."""

    def __init__(self, name: str, engine: str) -> None:
        super().__init__(name, engine, JsonData(), updated=True)


class RawData:
    """Data that a status function returns.

    Args:
        data: the data.
    """

    def __init__(self, data: Any) -> None:
        self.data = data


class JsonRawData(RawData):
    """JSON that a status function returns."""

    def __init__(self) -> None:
        super().__init__(JsonData())


def datapack_class(message: type[Message]) -> type[DataPack]:
    """Return the class of datapacks with messages of one type; unset numbers of joints are NaN."""

    class MessageDataPack(DataPack):
        def __init__(self, name: str, engine: str) -> None:
            super().__init__(name, engine, _fresh(message), updated=True)

    return MessageDataPack


def raw_data_class(message: type[Message]) -> type[RawData]:
    """Return the class of raw data with messages of one type."""

    class MessageRawData(RawData):
        def __init__(self) -> None:
            super().__init__(_fresh(message))

    return MessageRawData


def _fresh(message: type[Message]) -> Message:
    made = message()
    if made.DESCRIPTOR.full_name == "Gazebo.Joint":  # "leave it as it is"
        for field in made.DESCRIPTOR.fields:
            setattr(made, field.name, math.nan)
    return made


def copied(content: Any) -> Any:
    """Return a copy of the data of a datapack."""
    if isinstance(content, Message):
        other = type(content)()
        other.CopyFrom(content)
        return other
    return plain(content)
