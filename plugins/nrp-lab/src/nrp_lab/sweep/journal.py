"""The records of a sweep, one line of JSON each, written as soon as a run ends.

Several processes may add to one folder, each to its own file. A line truncated by a kill or a full disk is
dropped; every line before it is on the disk.
"""

from __future__ import annotations

import fcntl
import json
import os
from pathlib import Path
from types import TracebackType
from typing import Self

from nrp_core._support.writing import writing
from nrp_core.errors import ExperimentError
from nrp_lab.sweep.record import Record

JOURNAL = "journal.jsonl"
JOURNALS = "journal*.jsonl"
"""Jobs of a cluster write their own journals."""


class Journal:
    """A file that records are added to, by one process at a time.

    Raises:
        ExperimentError: another process adds to it, or it cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        with writing(path):
            self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(self._descriptor)
            raise ExperimentError("another process is working on this sweep", path=path) from error
        self._drop_cut_line()

    def add(self, record: Record) -> None:
        """Add a record and wait until it is on the disk.

        Raises:
            ExperimentError: it cannot be written; earlier records are kept.
        """
        with writing(self._path):
            data = record.to_line().encode()
            while data:
                data = data[os.write(self._descriptor, data) :]
            os.fsync(self._descriptor)

    def close(self) -> None:
        """Let other processes add to it."""
        os.close(self._descriptor)

    def _drop_cut_line(self) -> None:
        """Truncate the file after its last complete line, and continue there."""
        data = self._path.read_bytes()
        with writing(self._path):
            os.ftruncate(self._descriptor, data.rfind(b"\n") + 1)
            os.lseek(self._descriptor, 0, os.SEEK_END)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def read_records(folder: Path) -> dict[str, Record]:
    """Return the records of a folder by id; of several records of a run, the last one without an error.

    Raises:
        ExperimentError: a line is not a record.
    """
    found: dict[str, Record] = {}
    for path in sorted(folder.glob(JOURNALS)):
        for record in records_in(path):
            if record.id not in found or not record.failed or found[record.id].failed:
                found[record.id] = record
    return found


def records_in(path: Path) -> list[Record]:
    """Return the records of one journal, without a truncated line.

    Raises:
        ExperimentError: a line is not a record.
    """
    *lines, _cut = path.read_text("utf-8").split("\n")
    try:  # all at once, which is much faster
        return list(map(Record.from_data, json.loads(f"[{','.join(lines)}]")))
    except (ValueError, TypeError, KeyError):
        return [_record(path, number, line) for number, line in enumerate(lines, 1)]


def _record(path: Path, number: int, line: str) -> Record:
    try:
        return Record.from_data(json.loads(line))
    except (ValueError, TypeError, KeyError) as error:
        raise ExperimentError("this line is not a record of a run", path=path, line=number) from error
