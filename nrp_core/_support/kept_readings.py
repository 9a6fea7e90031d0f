"""What was read from files, kept for later runs of this process until one of the files changes."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from threading import Lock
from typing import Generic, TypeVar

from nrp_core._support.used_files import FilesRead

R = TypeVar("R")


class KeptReadings(Generic[R]):
    """The results of reading files, which nobody changes.

    A result is used again while every file that the reading opened or looked for is as it was, and so are the
    environment variables that it read. To a recording of what is read, a result that is used again counts as
    read. Results of files that were changed just now are not kept, because times of files are coarse.

    Args:
        most: the maximum number of results; the least recently used are dropped.
        may_keep: returns whether a result depends only on files that Python has opened in this reading.
    """

    def __init__(self, most: int, may_keep: Callable[[R], bool]) -> None:
        self._most, self._may_keep = most, may_keep
        self._kept: dict[Hashable, tuple[FilesRead, R]] = {}
        self._lock = Lock()

    def get(self, key: Hashable, read: Callable[[], R]) -> R:
        """Return the result of a reading.

        Args:
            key: everything on which it depends beside the files.
            read: reads.
        """
        with self._lock:
            kept = self._kept.pop(key, None)
        if kept is not None and kept[0].is_current:
            kept[0].announce()
            keeps = True
        else:
            with FilesRead() as files:
                kept = files, read()
            keeps = files.is_settled and self._may_keep(kept[1])
        if keeps:
            with self._lock:
                self._kept[key] = kept
                while len(self._kept) > self._most:
                    del self._kept[next(iter(self._kept))]
        return kept[1]
