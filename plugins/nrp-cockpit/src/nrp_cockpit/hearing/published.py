"""The messages that were published on a topic of a world."""

from __future__ import annotations

from nrp_core.recording.layout import Role
from nrp_core.recording.writing.signals import Add, RecordEntry, Signal, about_role
from nrp_core.world.topics import Stamped
from nrp_core.world.world import World


class PublishedMessages(Signal):
    """The messages on all topics that functions, events and users publish on.

    Args:
        world: the world of the topics.
    """

    _about = about_role(Role.PUBLISHED)

    def __init__(self, world: World) -> None:
        self._world = world
        self._pending: list[tuple[str, Stamped]] = []
        world.add_observer(self._note)

    def take(self, now_ns: int, add: Add) -> None:
        pending, self._pending = self._pending, []
        for topic, stamped in pending:
            add(RecordEntry(stamped.t_ns, topic, type(stamped.message), self._about, message=stamped.message))

    def close(self) -> None:
        self._world.remove_observer(self._note)

    def _note(self, topic: str, stamped: Stamped) -> None:
        self._pending.append((topic, stamped))
