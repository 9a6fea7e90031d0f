"""Make the pending runs of a sweep, from the command line or in one call from Python."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import ceil
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import tree_of
from nrp_core.paths import path_of
from nrp_core.utilities import checks_arguments, join_with_limit, require_extra
from nrp_lab.sweep.executor import Executor, executor
from nrp_lab.sweep.model import read_sweep, sweep_of
from nrp_lab.sweep.plan import Plan, PlannedRun
from nrp_lab.sweep.record import JOURNAL, Journal, Task, changes_since, read_records
from nrp_lab.sweep.table import RECORDINGS, Row, claim, data_frame, rows_of, units_of, write_tables

if TYPE_CHECKING:
    import pandas as pd


@dataclass(slots=True)
class Progress:
    """The progress of a sweep.

    Args:
        total: number of runs, all or those selected by ``--only``.
        done: number of finished runs, including earlier ones.
        failed: number of these that an error ended.
        left_s: the expected remaining time, s; None before the first run has ended.
    """

    total: int
    done: int
    failed: int
    left_s: float | None = None

    def __str__(self) -> str:
        """Return failures and remaining time as text, for a progress bar."""
        parts = [f"{self.failed} failed"] if self.failed else []
        if self.left_s is not None and self.done < self.total:
            parts.append(f"{duration_text(self.left_s)} left")
        return ", ".join(parts)


OnProgress = Callable[[Progress], None]


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


class _Times:
    """The times that runs took, s, as far as their mean needs them."""

    def __init__(self, times_s: Iterable[float]) -> None:
        self._count, self._sum_s, self._longest_s = 0, 0.0, 0.0
        for time_s in times_s:
            self.add(time_s)

    def add(self, time_s: float) -> None:
        """Add the time of a run; 0: unknown."""
        if time_s:
            self._count += 1
            self._sum_s += time_s
            self._longest_s = max(self._longest_s, time_s)

    def expected_s(self, runs: int, executor: Executor) -> float | None:
        """Return the expected time of further runs, s, or None before the first one."""
        if not self._count:
            return None
        sum_s, count = self._sum_s, self._count
        if count > 1:  # the longest may have compiled code
            sum_s, count = sum_s - self._longest_s, count - 1
        return sum_s / count * ceil(runs / executor.size)


class SweepRun:
    """A sweep in its folder.

    Args:
        plan: the sweep.
        folder: its folder; created, or reused if it contains the same sweep.
        choice: the selection of runs.

    Attributes:
        outdated: the changed dependencies of earlier runs, with the number of runs. These do not
            count as made.

    Raises:
        ExperimentError: the folder contains something else, or no run is selected.
    """

    def __init__(self, plan: Plan, folder: Path, choice: Choice | None = None) -> None:
        claim(folder, plan)
        self.plan, self.folder, self.choice = plan, folder, choice or Choice()
        self._read()
        self._chosen = chosen(plan.runs, self.choice.only, list(plan.sweep.vary))

    def discount_changed(self) -> None:
        """Discount the runs that were made before something that they read was changed, in the tables too.

        A sweep takes hours, in which files are edited; :attr:`news` names these. Dependencies are compared
        with this machine, so runs of other machines cannot be checked.
        """
        self._read()
        write_tables(self.folder, self.rows, self.units)

    def _read(self) -> None:
        changes = changes_since(self.folder)
        self.records = read_records(self.folder, lambda record: not changes(record))
        older = [one for one in read_records(self.folder).values() if one.id not in self.records]
        self.outdated = Counter(change for record in older for change in changes(record))

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
    def news(self) -> str:
        """A sentence on the changes that make earlier runs outdated; empty if none do."""
        if not self.outdated:
            return ""
        changes = join_with_limit([change for change, _ in self.outdated.most_common()], 5)
        return f"{max(self.outdated.values())} earlier runs do not count: {changes} changed"

    @property
    def rows(self) -> list[Row]:
        """The rows of all finished runs, also of those not selected this time."""
        return rows_of(self.plan.runs, self.records)

    @property
    def units(self) -> dict[str, str]:
        """The units of the measured columns."""
        return units_of(self.records.values())

    def expected_s(self, executor: Executor) -> float | None:
        """Return the expected time of the pending runs, s, from the finished ones, or None."""
        times = _Times(record.elapsed_s for record in self.records.values())
        return times.expected_s(len(self.pending), executor)

    def run(
        self,
        executor: Executor,
        on_progress: OnProgress = lambda _: None,
        tasks: Sequence[Task] | None = None,
    ) -> None:
        """Make runs, write each into the journal as it ends, and derive the tables, even if interrupted.

        Args:
            executor: the open executor.
            on_progress: called at the beginning and after every run.
            tasks: the runs to make; by default all pending ones.

        Raises:
            NrpError: the disk is full, or the executor gives up; finished runs are kept.
        """
        tasks = self.pending if tasks is None else tasks
        done = len(self._chosen) - len(self.pending)
        times = _Times(record.elapsed_s for record in self.records.values())
        left_s = times.expected_s(len(self.pending), executor)
        progress = Progress(len(self._chosen), done, self._failed(), left_s)
        on_progress(progress)
        try:
            with Journal(self.folder / JOURNAL) as journal:
                for record in executor.perform(tasks) if tasks else ():
                    journal.add(record)
                    self.records[record.id] = record
                    progress.done += 1
                    progress.failed += record.failed
                    times.add(record.elapsed_s)
                    progress.left_s = times.expected_s(progress.total - progress.done, executor)
                    on_progress(progress)
        finally:
            write_tables(self.folder, self.rows, self.units)

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


def require_workers(workers: object) -> None:
    """Check the number of runs at once.

    Raises:
        ExperimentError: it is not a whole number from 1 on, or None.
    """
    if workers is not None and (not isinstance(workers, int) or isinstance(workers, bool) or workers < 1):
        raise ExperimentError(f"'workers' is a whole number, at least 1, not {workers!r:.60}")


@checks_arguments("description", "workers")
def sweep(
    description: str | Path | Mapping[str, Any],
    out: str | Path | None = None,
    *,
    on: str = "local",
    workers: int | None = None,
    only: Sequence[str] | str = (),
    retry_failed: bool = False,
    record: bool = False,
    confirmed: bool = False,
    on_progress: OnProgress = lambda _: None,
) -> pd.DataFrame:
    """Make the runs of a sweep and return their table, one row per run.

    The findings of ``nrp validate`` about the experiment are a Python warning before the first run.

    Example::

        table = sweep({"experiment": "slalom_pioneer", "vary": {"seed": {"from": 1, "to": 20}}})
        print(table["criteria.gets_through"].mean())

    Args:
        description: the file of the sweep, or its contents.
        out: the folder of the results; runs that it already holds are not repeated. By default temporary.
        on: ``local``, ``dask``, ``slurm`` or ``tcp://scheduler:8786``.
        workers: number of runs at once.
        only: conditions on the runs, ``key=value``, or their numbers, ``0..9``.
        retry_failed: whether to repeat the runs that failed.
        record: whether to keep a recording of every run, in ``out``.
        confirmed: whether more than 100 000 runs are allowed.
        on_progress: called after every run with the progress.

    Raises:
        ExperimentError: the sweep or the folder is not valid.
        BackendError: a requirement is not installed or cannot be reached.
    """
    require_workers(workers)
    require_extra("pandas", "nrp-lab[sweep]", "a table of a sweep in Python")
    if isinstance(description, Mapping):
        plan = Plan.of(sweep_of(tree_of(description)), confirmed=confirmed)
    else:
        file, source = read_sweep(path_of(description))
        plan = Plan.of(file, source, confirmed=confirmed)
    with TemporaryDirectory(prefix="nrp-sweep-") as temporary:
        folder = Path(temporary) if out is None else path_of(out)
        chosen = (only,) if isinstance(only, str) else tuple(only)
        made = SweepRun(plan, folder, Choice(chosen, retry_failed, record))
        if made.news:
            warnings.warn(made.news, stacklevel=4)
        if made.pending:
            plan.report_warnings(partial(warnings.warn, stacklevel=4))
        with executor(on, folder, workers) as where:
            made.run(where, on_progress)
        if on == "local":
            made.discount_changed()
            if made.news:
                warnings.warn(made.news, stacklevel=4)
        return data_frame(made.rows, made.units)
