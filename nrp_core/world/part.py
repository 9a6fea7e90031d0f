"""What a part of a world is."""

from __future__ import annotations

from abc import ABC
from typing import Any

from nrp_core.world.topics import TopicInfo


class Part(ABC):
    """A thing of the scene that serves topics.

    Attributes:
        topics: what it serves.
        deadline_ns: when it wants to be called though nobody asked, None for never.
        foresees: whether it is called one physics step before each sample, by :meth:`foresee`.
    """

    topics: tuple[TopicInfo, ...] = ()
    deadline_ns: int | None = None
    foresees: bool = False

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

    def begin(self) -> None:
        """Act on the engine before the first step, where the scene alone does not say what to do."""

    def reset(self) -> None:
        """Return to the state at time 0; the engine has been reset before."""

    def save(self) -> object:
        """Return what changes while running."""
        return None

    def restore(self, saved: Any) -> None:
        """Return to what :meth:`save` gave; the engine has been restored before."""
