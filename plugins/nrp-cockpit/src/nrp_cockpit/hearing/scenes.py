"""The scene of a recording at any time, from the recorded changes."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field

from nrp_cockpit.hearing.stored import StoredMessages
from nrp_core.recording.layout import SCENE
from nrp_core.world.messages.base import Time, type_name
from nrp_core.world.messages.cdr import Codec
from nrp_core.world.messages.foxglove_msgs import SceneEntity, SceneEntityDeletion, SceneUpdate

SCENE_TYPE = type_name(SceneUpdate)
"""The type of scenes for viewers; recordings of version 0.1 have another type."""


@dataclass(slots=True)
class _Past:
    """The history of one entity: the times of changes, and the entity then; None: it was removed."""

    times_ns: list[int] = field(default_factory=list)
    entities: list[SceneEntity | None] = field(default_factory=list)

    def at(self, t_ns: int) -> SceneEntity | None:
        nth = bisect_right(self.times_ns, t_ns)
        return self.entities[nth - 1] if nth else None


class RecordedScenes:
    """Reads the changes of a scene lazily, each once.

    Args:
        messages: of the recording.
    """

    def __init__(self, messages: StoredMessages) -> None:
        self._messages, self._codec = messages, Codec({})
        self._codec.define(SCENE_TYPE, messages.topics[SCENE].definition)
        self._pasts: dict[str, _Past] = {}
        self._first: bytes | None = None
        self._updates, self._until_ns = 0, -1

    def at(self, t_ns: int) -> bytes | None:
        """Return the message that makes any viewer show the scene of a time.

        Until the first change it is the recorded message.
        """
        self._read(t_ns)
        if self._updates < 2:
            return self._first
        entities, deletions = [], []
        for name, past in self._pasts.items():
            entity = past.at(t_ns)
            if entity is None:
                deletions.append(SceneEntityDeletion(Time.from_ns(self._until_ns), id=name))
            else:
                entities.append(entity)
        return bytes(self._codec.encode(SceneUpdate(deletions, entities)))

    def entities(self, t_ns: int) -> list[SceneEntity]:
        """Return the entities that exist at a time."""
        self._read(t_ns)
        found = (past.at(t_ns) for past in self._pasts.values())
        return [entity for entity in found if entity is not None]

    def _read(self, t_ns: int) -> None:
        if t_ns <= self._until_ns:
            return
        for stored in self._messages.between([SCENE], self._until_ns, t_ns):
            self._first = self._first or stored.data
            self._updates += 1
            self._add(stored.t_ns, self._codec.decode(stored.data, SCENE_TYPE))
        self._until_ns = t_ns

    def _add(self, t_ns: int, update: SceneUpdate) -> None:
        for deletion in update.deletions:
            gone = self._pasts if deletion.type == SceneEntityDeletion.ALL else (deletion.id,)
            for name in tuple(gone):
                self._note(name, t_ns, None)
        for entity in update.entities:
            self._note(entity.id, t_ns, entity)

    def _note(self, name: str, t_ns: int, entity: SceneEntity | None) -> None:
        past = self._pasts.setdefault(name, _Past())
        past.times_ns.append(t_ns)
        past.entities.append(entity)
