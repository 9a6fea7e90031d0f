"""One run of a sweep: the task of a worker, its record, and the journal of records."""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, Self

from nrp_core.errors import ExperimentError
from nrp_core.recording import Dependencies
from nrp_core.utilities import writing

INVALID = "invalid"
"""The state of a run that could not begin."""


@dataclass(frozen=True, slots=True)
class Task:
    """One run, with all data for a worker on another machine, where files must have the same paths.

    Args:
        id: a digest of all that determines the run.
        index: its place in the sweep, from 0.
        experiment: a shipped experiment, or the path of a file or folder.
        overrides: ``dotted.key=value``.
        measure: names of metrics.
        until_s: its end time, s; None: the end of the experiment.
        stop_when_failed: criteria; the run stops as soon as one of them is not met.
        code: fingerprints of the packages of the core and the backends, by name.
        recording: a folder to record into; None: the run is not recorded.
        attempt: 1, plus the number of workers that died in it.
    """

    id: str
    index: int
    experiment: str
    overrides: tuple[str, ...]
    measure: tuple[str, ...] = ()
    until_s: float | None = None
    stop_when_failed: tuple[str, ...] = ()
    code: Mapping[str, str] = field(default_factory=dict)
    recording: str | None = None
    attempt: int = 1

    @classmethod
    def from_line(cls, line: str) -> Self:
        """Read a line of :meth:`to_line`."""
        data: dict[str, Any] = json.loads(line)
        lists = ("overrides", "measure", "stop_when_failed")
        return cls(**{**data, **{name: tuple(data[name]) for name in lists}})

    def to_line(self) -> str:
        """Return one line of JSON."""
        return _line(self)

    def again(self) -> Self:
        """Return the same run for another attempt."""
        return replace(self, attempt=self.attempt + 1)


@dataclass(frozen=True, slots=True)
class Record:
    """The result of a run. Everything but times and attempts is the same on every machine.

    Args:
        id, index: of the task.
        seed: the seed.
        brain, world: names of the backends.
        state: ``finished``, ``failed``, ``invalid`` (it could not begin) or ``died`` (its worker, each time).
        complete, passed: as of :class:`~nrp_core.experiment.running.result.Result`.
        problems: codes of its findings, the most severe first.
        measured: values by ``metric.part``; None: the part has no value in this run.
        units: units of measured values that have another unit than their metric, by ``metric.part``.
        drawn: what ``world.randomize`` drew for its seed, by ``world.randomize.QUANTITY.PART``.
        sim_time_s: simulated time at its end.
        wall_time_s: real time of the steps.
        elapsed_s: real time of the whole run: reading, opening, stepping, measuring.
        trajectory_digest: hash of all poses and joints at every step.
        error: the error that ended it.
        attempts: number of attempts.
        depends_on: digest of the dependencies; the journal keeps these in a file of this name.
        dependencies: files that the run read; only until the record is in a journal.
    """

    id: str
    index: int
    seed: int | None = None
    brain: str = ""
    world: str = ""
    state: str = INVALID
    complete: bool = False
    passed: bool | None = None
    problems: tuple[str, ...] = ()
    measured: Mapping[str, float | None] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    drawn: Mapping[str, float] = field(default_factory=dict)
    sim_time_s: float = 0.0
    wall_time_s: float = 0.0
    elapsed_s: float = 0.0
    trajectory_digest: str = ""
    error: str | None = None
    attempts: int = 1
    depends_on: str = ""
    dependencies: Dependencies | None = None

    @property
    def failed(self) -> bool:
        """Whether an error ended it; ``--retry-failed`` repeats these."""
        return self.error is not None

    @classmethod
    def died(cls, task: Task, reason: str) -> Self:
        """Return the record of a run whose worker died each time."""
        message = f"its worker died in each of {task.attempt} attempts; the last cause: {reason}"
        return cls(task.id, task.index, state="died", error=message, attempts=task.attempt)

    def to_line(self) -> str:
        """Return one line of JSON."""
        return _line(replace(self, dependencies=None))

    def depending_on(self, dependencies: Dependencies) -> Self:
        """Return the same record with the dependencies of the run."""
        described = json.dumps(dependencies.to_data(), sort_keys=True).encode()
        digest = hashlib.blake2b(described, digest_size=8).hexdigest()
        return replace(self, depends_on=digest, dependencies=dependencies)

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Self:
        """Return the record of the data in a line of :meth:`to_line`.

        Raises:
            TypeError, KeyError: they have another form.
        """
        return cls(**{**data, "problems": tuple(data["problems"])})


def _line(of: Task | Record) -> str:
    return json.dumps(asdict(of), separators=(",", ":")) + "\n"


JOURNAL = "journal.jsonl"
DEPENDENCIES = "dependencies"
"""The folder, beside the journals, with a file for each set of dependencies."""
JOURNALS = "journal*.jsonl"
"""Jobs of a cluster write their own journals."""


class Journal(AbstractContextManager["Journal"]):
    """A file that records are added to within a block, by one process at a time.

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
            if record.dependencies is not None:
                _keep(record.depends_on, record.dependencies, self._path.parent / DEPENDENCIES)
            data = record.to_line().encode()
            while data:
                data = data[os.write(self._descriptor, data) :]
            os.fsync(self._descriptor)

    def __exit__(self, *_: object) -> None:
        """Let other processes add to it."""
        os.close(self._descriptor)

    def _drop_cut_line(self) -> None:
        """Truncate the file after its last complete line, and continue there."""
        data = self._path.read_bytes()
        with writing(self._path):
            os.ftruncate(self._descriptor, data.rfind(b"\n") + 1)
            os.lseek(self._descriptor, 0, os.SEEK_END)


def _keep(digest: str, dependencies: Dependencies, folder: Path) -> None:
    """Write dependencies into their file, unless it exists; several processes may do the same."""
    path = folder / f"{digest}.json"
    if not path.is_file():
        folder.mkdir(exist_ok=True)
        draft = path.with_suffix(f".{os.getpid()}")
        draft.write_text(json.dumps(dependencies.to_data(), indent=1, sort_keys=True) + "\n", "utf-8")
        draft.replace(path)


def changes_since(folder: Path) -> Callable[[Record], tuple[str, ...]]:
    """Return a function of a record that returns the changed dependencies of its run, as phrases.

    Each file of dependencies is compared once. A record without one, of an older version, may be outdated by
    anything.
    """

    @cache
    def changes(digest: str) -> tuple[str, ...]:
        try:
            data = json.loads((folder / DEPENDENCIES / f"{digest}.json").read_text("utf-8"))
        except (OSError, ValueError):
            return ("everything, as far as is known,",)
        return tuple(Dependencies.from_data(data).changes())

    return lambda record: changes(record.depends_on)


def read_records(folder: Path, is_valid: Callable[[Record], bool] = lambda _: True) -> dict[str, Record]:
    """Return the records of a folder by id; of several records of a run, the last one without an error.

    Args:
        folder: the folder.
        is_valid: returns whether a record counts.

    Raises:
        ExperimentError: a line is not a record.
    """
    found: dict[str, Record] = {}
    for path in sorted(folder.glob(JOURNALS)):
        for record in filter(is_valid, records_in(path)):
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
