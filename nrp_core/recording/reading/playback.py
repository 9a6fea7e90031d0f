"""Read the messages of a recording on some topics in step with the time."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from nrp_core.recording.reading.reader import Recorded, RecordingReader


class Playback:
    """Reads a recording in step with the time; only the messages since the last call are in memory.

    Args:
        recording: the recording, read again from its beginning after :meth:`reset`.
        topics: the topics that are read; those without a message are silent.
    """

    def __init__(self, recording: RecordingReader, topics: Collection[str]) -> None:
        self._recording, self._topics = recording, frozenset(topics) & recording.topics.keys()
        self.reset()

    def reset(self) -> None:
        """Go back to the beginning."""
        self.latest: dict[str, Recorded] = {}
        self._messages: Iterator[Recorded] = self._recording.messages(self._topics)
        self._next = next(self._messages, None)

    @property
    def ended(self) -> bool:
        """Whether all messages were read."""
        return self._next is None

    def until(self, t_ns: int) -> list[Recorded]:
        """Return the messages since the last call up to ``t_ns``, in order."""
        come: list[Recorded] = []
        while self._next is not None and self._next.t_ns <= t_ns:
            come.append(self._next)
            self.latest[self._next.topic] = self._next
            self._next = next(self._messages, None)
        return come
