"""One run of a sweep: the task that a worker gets, and the record that it returns."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Self


@dataclass(frozen=True, slots=True)
class Task:
    """One run, with everything that a worker on another machine needs; files have the same path there.

    Args:
        id: a digest of what the run depends on.
        index: its place in the sweep, from 0.
        experiment: a shipped experiment, or the path of a file or folder.
        overrides: ``dotted.key=value``.
        measure: names of metrics.
        until_s: where it stops, s; None: at the end of the experiment.
        code: fingerprints of the packages of the core and the backends, by name.
        recording: a folder to record into; None: the run is not kept.
        attempt: 1, and one more each time a worker died at it.
    """

    id: str
    index: int
    experiment: str
    overrides: tuple[str, ...]
    measure: tuple[str, ...] = ()
    until_s: float | None = None
    code: Mapping[str, str] = field(default_factory=dict)
    recording: str | None = None
    attempt: int = 1

    def again(self) -> Self:
        """Return the same run for another attempt."""
        return replace(self, attempt=self.attempt + 1)


@dataclass(frozen=True, slots=True)
class Record:
    """What came of a run. Everything but times and attempts is the same on every machine.

    Args:
        id, index: of the task.
        seed: the seed.
        brain, world: names of the backends.
        state: ``finished``, ``failed``, ``invalid`` (it could not begin) or ``died`` (its worker, each time).
        complete, passed: as of :class:`~nrp_core.experiment.running.result.Result`.
        problems: codes of its findings, the weightiest first.
        measured: values by ``metric.part``; None: the part has no value in this run.
        sim_time_s: simulated time that was reached.
        wall_time_s: real time of the steps.
        elapsed_s: real time of everything: reading, opening, stepping, measuring.
        trajectory_digest: hash of the poses of all robots at every step.
        error: the error that ended it.
        attempts: how often it was begun.
    """

    id: str
    index: int
    seed: int | None = None
    brain: str = ""
    world: str = ""
    state: str = "invalid"
    complete: bool = False
    passed: bool | None = None
    problems: tuple[str, ...] = ()
    measured: Mapping[str, float | None] = field(default_factory=dict)
    sim_time_s: float = 0.0
    wall_time_s: float = 0.0
    elapsed_s: float = 0.0
    trajectory_digest: str = ""
    error: str | None = None
    attempts: int = 1

    @property
    def failed(self) -> bool:
        """Whether an error ended it; ``--retry-failed`` repeats these."""
        return self.error is not None

    @classmethod
    def died(cls, task: Task, reason: str) -> Self:
        """Return the record of a run whose worker died each time."""
        message = f"its worker died at each of {task.attempt} attempts, at last by {reason}"
        return cls(task.id, task.index, state="died", error=message, attempts=task.attempt)

    def to_line(self) -> str:
        """Return one line of JSON."""
        return json.dumps(asdict(self), separators=(",", ":")) + "\n"

    @classmethod
    def from_line(cls, line: str) -> Self:
        """Read a line of :meth:`to_line`.

        Raises:
            ValueError, TypeError: it is something else.
        """
        data: dict[str, Any] = json.loads(line)
        return cls(**{**data, "problems": tuple(data["problems"])})
