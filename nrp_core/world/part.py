"""What a part of a world is."""

from __future__ import annotations

from abc import ABC
from collections.abc import Iterable
from typing import Any

from nrp_core.world.topics import Stamped, TopicInfo


class Part(ABC):
    """A thing of the scene that has topics.

    Attributes:
        topics: its topics.
        carried: those of its topics whose messages come from outside, whenever they come; all other
            outgoing topics are read.
        deadline_ns: when it wants to be called though nobody asked, None for never.
        foresees: whether it is called one physics step before each sample, by :meth:`foresee`.
    """

    topics: tuple[TopicInfo, ...] = ()
    carried: frozenset[str] = frozenset()
    deadline_ns: int | None = None
    foresees: bool = False

    @property
    def unwrapped(self) -> Part:
        """The part itself, where another one stands in its place."""
        return self

    def read(self, topic: str, now_ns: int) -> Any:
        """Return the message of an outgoing topic as it is now."""
        raise NotImplementedError(topic)

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        """Take a checked message on an incoming topic."""
        raise NotImplementedError(topic)

    def foresee(self, topic: str, now_ns: int) -> None:
        """Note what the sample in one physics step needs to know of now."""

    def at_deadline(self, now_ns: int) -> None:
        """Do what was due at :attr:`deadline_ns` and set the next one."""

    def attend(self, subscribed: frozenset[str]) -> None:
        """Learn which topics, of all in the world, are subscribed to; called when that has changed."""

    def arrived(self) -> Iterable[tuple[str, Stamped]]:
        """Return the messages that came on carried topics in the last step, oldest first."""
        return ()

    def moved(self) -> None:
        """Go on from where the model was put."""

    def begin(self) -> None:
        """Act on the engine before the first step, where the scene alone does not say what to do."""

    def reset(self) -> None:
        """Return to the state at time 0; the engine has been reset before."""

    def save(self) -> object:
        """Return what changes while running."""
        return None

    def restore(self, saved: Any) -> None:
        """Return to what :meth:`save` gave; the engine has been restored before."""


class PartInPlace(Part):
    """A part that stands in the place of another one and does what that one does.

    Args:
        inner: the other one.
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
