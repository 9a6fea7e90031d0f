"""The observable of topics: a field of the last message."""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter
from typing import Any

from nrp_core.errors import TopicError
from nrp_core.messages.base import type_name
from nrp_core.observables.moments import LastMessage
from nrp_core.observables.observable import Observable, Room, Surroundings


class Field(Observable):
    """A field of the last message of a topic; without a value before the first message.

    Raises:
        TopicError: the topic does not exist, or its message does not have the field.

    Attributes:
        example: the value in an empty message.
    """

    hears = True

    def __init__(self, around: Surroundings, name: str, field: str = "data") -> None:
        self._read, self.name = attrgetter(field), name if field == "data" else f"{name}.{field}"
        subscription = around.world.subscribe(name, depth=None)
        self._last = LastMessage(subscription)
        try:
            self.example = self._read(subscription.topic.type())
        except AttributeError:
            kind = type_name(subscription.topic.type)
            raise TopicError(f"{name} carries {kind}, which has no field '{field}'") from None

    def value(self, now_ns: int) -> Any:
        stamped = self._last.at(now_ns)
        return None if stamped is None else self._read(stamped.message)

    @property
    def last(self) -> Any:
        """The value that was read last."""
        stamped = self._last.last
        return None if stamped is None else self._read(stamped.message)

    @property
    def news_ns(self) -> Sequence[int]:
        """The times of the messages that came since the last reading, ns; they stay unread."""
        return self._last.untaken_ns

    def news(self) -> Sequence[int]:
        return self._last.news()

    def unchanged_ns(self, room: Room) -> int | None:
        return self._last.unchanged_ns

    def restore(self, saved: Any) -> None:
        self._last.restore()
