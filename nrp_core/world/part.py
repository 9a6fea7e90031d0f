"""The base classes of the parts of a world."""

from __future__ import annotations

from abc import ABC
from collections.abc import Iterable, Sequence
from typing import Any

from nrp_core._support.arrays import FloatArray
from nrp_core.world.topics import Stamped, TopicInfo


class Part(ABC):
    """An object of the scene with topics.

    Attributes:
        topics: its topics.
        carried: its topics whose messages come from outside at any time; all other outgoing topics are read.
        deadline_ns: the time of its next scheduled call, None for never.
        foresees: whether it is called one physics step before each sample, by :meth:`foresee`.
    """

    topics: tuple[TopicInfo, ...] = ()
    carried: frozenset[str] = frozenset()
    deadline_ns: int | None = None
    foresees: bool = False

    @property
    def unwrapped(self) -> Part:
        """The part itself, or the part that it wraps."""
        return self

    @property
    def has_deadlines(self) -> bool:
        """Whether it ever has a :attr:`deadline_ns`."""
        return type(self).at_deadline is not Part.at_deadline

    def read(self, topic: str, now_ns: int) -> Any:
        """Return the current message of an outgoing topic."""
        raise NotImplementedError(topic)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        """Receive a checked message on an incoming topic."""
        raise NotImplementedError(topic)

    def write_numbers(self, topic: str, numbers: Sequence[float], now_ns: int) -> bool:
        """Receive a message that consists of numbers, which are finite, without building it.

        Args:
            topic: the topic.
            numbers: the numbers in the message, in the order of its fields.
            now_ns: the time.

        Returns:
            Whether they were received; if not, they are checked and written as a message.
        """
        return False

    @classmethod
    def write_rows(cls, parts: Sequence[Any], topic: str, rows: FloatArray, now_ns: Sequence[int]) -> bool:
        """Receive messages of numbers, which are unchecked, for the same part in copies of a scene.

        Args:
            parts: the part of each copy, all of this class.
            topic: the topic.
            rows: the numbers in a message for each, in the order of its fields.
            now_ns: the time of each.

        Returns:
            Whether they were received; if not, each is written alone.
        """
        return False

    def foresee(self, topic: str, now_ns: int) -> None:
        """Save the present data that the sample one physics step later needs."""

    def at_deadline(self, now_ns: int) -> None:
        """Handle :attr:`deadline_ns` and set the next one."""

    def attend(self, subscribed: frozenset[str]) -> None:
        """Receive the names of all subscribed topics of the world; called when they have changed."""

    def arrived(self) -> Iterable[tuple[str, Stamped]]:
        """Return the messages received on carried topics in the last step, oldest first."""
        return ()

    def moved(self) -> None:
        """Continue from the new pose of the model."""

    def begin(self) -> None:
        """Initialise the engine before the first step, beyond the scene."""

    def reset(self) -> None:
        """Reset to the state at time 0; called after the engine's reset."""

    def save(self) -> object:
        """Return the state that changes during a run."""
        return None

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`; called after the engine was restored."""


class PartInPlace(Part):
    """A part that wraps another one and behaves like it.

    Args:
        inner: the wrapped part.
    """

    def __init__(self, inner: Part) -> None:
        self.inner = inner
        self.topics, self.foresees = inner.topics, inner.foresees

    @property
    def unwrapped(self) -> Part:
        return self.inner.unwrapped

    @property
    def deadline_ns(self) -> int | None:  # type: ignore[override]
        return self.inner.deadline_ns

    def read(self, topic: str, now_ns: int) -> Any:
        return self.inner.read(topic, now_ns)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        self.inner.write(topic, message, now_ns)

    def foresee(self, topic: str, now_ns: int) -> None:
        self.inner.foresee(topic, now_ns)

    def at_deadline(self, now_ns: int) -> None:
        self.inner.at_deadline(now_ns)

    def moved(self) -> None:
        self.inner.moved()

    def begin(self) -> None:
        self.inner.begin()

    def reset(self) -> None:
        self.inner.reset()

    def save(self) -> object:
        return self.inner.save()

    def restore(self, saved: Any) -> None:
        self.inner.restore(saved)
