"""Make the pending runs of a sweep."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from nrp_core._support.stopwatch import work
from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_lab.sweep.executors.interface import Executor
from nrp_lab.sweep.folder import RECORDINGS, claim
from nrp_lab.sweep.journal import JOURNAL, Journal, read_records
from nrp_lab.sweep.plan import Plan, PlannedRun
from nrp_lab.sweep.record import Task
from nrp_lab.sweep.table import Row, rows_of, write_tables


@dataclass(slots=True)
class Progress:
    """The progress of a sweep.

    Args:
        total: number of runs, all or those selected by ``--only``.
        done: number of finished runs, including earlier ones.
        failed: number of these that an error ended.
        begun_with: number of runs that were finished before.
        began_ns: start of this process's work, on its monotonic clock.
    """

    total: int
    done: int
    failed: int
    begun_with: int = 0
    began_ns: int = field(default_factory=work.now_ns)

    @property
    def left_s(self) -> float | None:
        """The expected remaining time, s; None before the first run has ended."""
        made = self.done - self.begun_with
        return seconds(work.now_ns() - self.began_ns) / made * (self.total - self.done) if made else None

    def __str__(self) -> str:
        """Return failures and remaining time as text, for a progress bar."""
        parts = [f"{self.failed} failed"] if self.failed else []
        if self.left_s is not None and self.done < self.total:
            parts.append(f"{duration_text(self.left_s)} left")
        return ", ".join(parts)


Tell = Callable[[Progress], None]


@dataclass(frozen=True, slots=True)
class Choice:
    """The selection of runs to make.

    Args:
        only: conditions, each ``KEY=VALUE`` or numbers of runs such as ``0..9``; a run must match all keys.
        retry_failed: whether runs that failed are made again.
        recorded: whether to keep recordings.
    """

    only: tuple[str, ...] = ()
    retry_failed: bool = False
    recorded: bool = False


class SweepRun:
    """A sweep in its folder.

    Args:
        plan: the sweep.
        folder: its folder; created, or reused if it contains the same sweep.
        choice: the selection of runs.

    Raises:
        ExperimentError: the folder contains something else, or no run is selected.
    """

    def __init__(self, plan: Plan, folder: Path, choice: Choice | None = None) -> None:
        claim(folder, plan)
        self.plan, self.folder, self.choice = plan, folder, choice or Choice()
        self.records = read_records(folder)
        self._chosen = chosen(plan.runs, self.choice.only, list(plan.sweep.vary))

    def extend(self, plan: Plan) -> None:
        """Continue with a plan of the same sweep with more runs."""
        claim(self.folder, plan)
        self.plan = plan
        self._chosen = chosen(plan.runs, self.choice.only, list(plan.sweep.vary))

    @property
    def pending(self) -> list[Task]:
        """The runs that are still to be made; of equal ones only the first."""
        tasks = {run.task.id: run.task for run in reversed(self._chosen) if not self._is_done(run)}
        return [self._task(task) for task in reversed(tasks.values())]

    @property
    def rows(self) -> list[Row]:
        """The rows of all finished runs, also of those not selected this time."""
        return rows_of(self.plan.runs, self.records)

    def expected_s(self, executor: Executor) -> float | None:
        """Return the expected time of the pending runs, s, from the finished ones; None if there are none."""
        known = [record.elapsed_s for record in self.records.values() if record.elapsed_s]
        if not known:
            return None
        pending = len(self.pending)
        return sorted(known)[len(known) // 2] * pending / max(min(executor.size, pending), 1)

    def run(
        self, executor: Executor, tell: Tell = lambda _: None, tasks: Sequence[Task] | None = None
    ) -> None:
        """Make runs, write each into the journal as it ends, and derive the tables, even if interrupted.

        Args:
            executor: the open executor.
            tell: called at the beginning and after every run.
            tasks: the runs to make; by default all pending ones.

        Raises:
            NrpError: the disk is full, or the executor gives up; finished runs are kept.
        """
        tasks = self.pending if tasks is None else tasks
        done = len(self._chosen) - len(self.pending)
        progress = Progress(len(self._chosen), done, self._failed(), done)
        tell(progress)
        try:
            with Journal(self.folder / JOURNAL) as journal:
                for record in executor.perform(tasks) if tasks else ():
                    journal.add(record)
                    self.records[record.id] = record
                    progress.done += 1
                    progress.failed += record.failed
                    tell(progress)
        finally:
            write_tables(self.folder, self.rows)

    def _failed(self) -> int:
        return sum(self.records[run.task.id].failed for run in self._chosen if self._is_done(run))

    def _is_done(self, run: PlannedRun) -> bool:
        record = self.records.get(run.task.id)
        return record is not None and not (record.failed and self.choice.retry_failed)

    def _task(self, task: Task) -> Task:
        if not self.choice.recorded:
            return task
        return replace(task, recording=str((self.folder / RECORDINGS / task.id).resolve()))


def chosen(runs: Sequence[PlannedRun], only: Iterable[str], keys: Sequence[str]) -> list[PlannedRun]:
    """Return the runs that match conditions.

    Raises:
        ExperimentError: a condition has another form, names a setting that does not vary, or matches no run.
    """
    found = list(runs)
    for text in only:
        key, equals, value = text.partition("=")
        if equals:
            if key not in keys:
                raise ExperimentError(f"--only {text}: '{key}' does not vary{did_you_mean(key, keys)}")
            values = sorted({str(run.values[key]) for run in found})
            found = [run for run in found if str(run.values[key]) == value]
            if not found:
                raise ExperimentError(f"--only {text}: no run has this value{did_you_mean(value, values)}")
        else:
            first, last = _numbers(text)
            found = [run for run in found if first <= run.task.index <= last]
            if not found:
                raise ExperimentError(f"--only {text}: the runs are 0..{len(runs) - 1}")
    return found


def _numbers(text: str) -> tuple[int, int]:
    first, _, last = text.partition("..")
    if not (first.isdecimal() and (last or first).isdecimal()):
        raise ExperimentError(
            f"--only takes KEY=VALUE, the number of a run, or numbers such as 0..9, not '{text}'"
        )
    return int(first), int(last or first)


def duration_text(duration_s: float) -> str:
    """Return a duration as text, with at most two units."""
    total = round(duration_s)
    if total < 60:
        return f"{duration_s:.2g} s" if duration_s < 10 else f"{total} s"
    minutes, rest = divmod(total, 60)
    if minutes < 60:
        return f"{minutes} min {rest} s" if minutes < 10 and rest else f"{minutes} min"
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    return f"{days} d {hours} h" if days else f"{hours} h {minutes} min"
