"""The base classes of the parts of a world."""

from __future__ import annotations

from abc import ABC
from collections.abc import Iterable, Sequence
from typing import Any

from nrp_core.world.topics import Stamped, TopicInfo


class Part(ABC):
    """An object of the scene with topics.

    Attributes:
        topics: its topics.
        pushed_topics: its topics that receive messages from outside at any time; all other outgoing topics
            are read.
        number_topics: its incoming topics, all without limits, that :meth:`write` takes as numbers.
        deadline_ns: the time of its next scheduled call, None for never.
        needs_previous_step: whether :meth:`prepare_sample` is called one physics step before each sample.
    """

    topics: tuple[TopicInfo, ...] = ()
    pushed_topics: frozenset[str] = frozenset()
    number_topics: frozenset[str] = frozenset()
    deadline_ns: int | None = None
    needs_previous_step: bool = False

    @property
    def unwrapped(self) -> Part:
        """The part itself, or the part that it wraps."""
        return self

    @property
    def has_deadlines(self) -> bool:
        """Whether it ever has a :attr:`deadline_ns`."""
        return type(self).at_deadline is not Part.at_deadline

    # -- topics

    def read(self, topic: str, now_ns: int) -> Any:
        """Return the current message of an outgoing topic."""
        raise NotImplementedError(topic)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        """Receive a message on an incoming topic.

        Args:
            topic: the topic.
            message: the checked message; on :attr:`number_topics` the numbers in it, in the order of its
                fields, which are finite floats.
            now_ns: the time.
        """
        raise NotImplementedError(topic)

    @classmethod
    def write_all(
        cls, parts: Sequence[Any], topic: str, rows: Sequence[Sequence[float]], times_ns: Sequence[int]
    ) -> bool:
        """Receive numbers on one of the :attr:`number_topics` in several copies, if it can do so at once.

        Returns:
            Whether it has. Otherwise, and after an error, :meth:`write` is called for each part: nothing may
            have changed, or nothing that would change again.
        """
        return False

    def on_subscriptions_changed(self, subscribed: frozenset[str]) -> None:
        """Receive the names of all subscribed topics of the world."""

    def poll(self) -> Iterable[tuple[str, Stamped]]:
        """Return the messages received on pushed topics in the last step, oldest first."""
        return ()

    # -- time

    def begin(self) -> None:
        """Initialise the engine before the first step, beyond the scene."""

    def prepare_sample(self, topic: str, now_ns: int) -> None:
        """Save the present data that the sample one physics step later needs."""

    def at_deadline(self, now_ns: int) -> None:
        """Handle :attr:`deadline_ns` and set the next one."""

    def on_model_moved(self) -> None:
        """Continue from the new pose of the model."""

    # -- state

    def reset(self) -> None:
        """Reset to the state at time 0; called after the engine's reset."""

    def save(self) -> object:
        """Return the state that changes during a run."""
        return None

    def restore(self, saved: Any) -> None:
        """Restore a state from :meth:`save`; called after the engine was restored."""


class PartProxy(Part):
    """A part that wraps another one and behaves like it.

    Args:
        inner: the wrapped part.
    """

    def __init__(self, inner: Part) -> None:
        self.inner = inner
        self.topics, self.number_topics = inner.topics, inner.number_topics
        self.needs_previous_step = inner.needs_previous_step

    @property
    def unwrapped(self) -> Part:
        return self.inner.unwrapped

    @property
    def has_deadlines(self) -> bool:
        return self.inner.has_deadlines

    @property
    def deadline_ns(self) -> int | None:  # type: ignore[override]
        return self.inner.deadline_ns

    def read(self, topic: str, now_ns: int) -> Any:
        return self.inner.read(topic, now_ns)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        self.inner.write(topic, message, now_ns)

    def prepare_sample(self, topic: str, now_ns: int) -> None:
        self.inner.prepare_sample(topic, now_ns)

    def at_deadline(self, now_ns: int) -> None:
        self.inner.at_deadline(now_ns)

    def on_model_moved(self) -> None:
        self.inner.on_model_moved()

    def begin(self) -> None:
        self.inner.begin()

    def reset(self) -> None:
        self.inner.reset()

    def save(self) -> object:
        return self.inner.save()

    def restore(self, saved: Any) -> None:
        self.inner.restore(saved)
