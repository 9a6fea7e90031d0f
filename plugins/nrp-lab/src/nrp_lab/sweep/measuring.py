"""Perform and measure the runs of a sweep in a worker, which keeps its last run open."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from nrp_core.clock import seconds
from nrp_core.errors import (
    BackendLoadError,
    CapabilityError,
    ExperimentError,
    NrpError,
    SimulationError,
    did_you_mean,
)
from nrp_core.experiment import Result, Run, load_experiment
from nrp_core.recording import FilesRead, Images, Recording, RecordingFolder, dependencies
from nrp_core.utilities import fingerprint, to_jsonable, work
from nrp_lab.comparison.metric import METRICS, ScalarMetric
from nrp_lab.comparison.signals import RunSignals
from nrp_lab.copies import Attempt, Opened, perform_alone, perform_side_by_side, why_alone
from nrp_lab.sweep.record import Record, Task

_SEED = "seed="


class RunCache:
    """At most one open run that waits for a task, with the files that it has read and the task it was for."""

    def __init__(self) -> None:
        self._waiting: tuple[Run, FilesRead] | None = None
        self._of: tuple[str, tuple[str, ...]] | None = None

    def open(self, task: Task, files: FilesRead, *, keep: bool) -> tuple[Run, FilesRead]:
        """Return a run of a task at time 0, and the files it reads: a new one, or the open one after a reset.

        Args:
            task: the task.
            files: notes what a new run reads.
            keep: whether the open run may be used.
        """
        if keep and self._of == _settings_of(task) and (found := self._reset_run(task)) is not None:
            return found
        if not keep or self._of != _settings_of(task):
            self.close()
        with files:
            return Run(load_experiment(task.experiment, task.overrides)), files

    def give_back(self, task: Task, run: Run, files: FilesRead) -> None:
        """Keep the run of a task open; close one that failed, or that would be the second."""
        if self._waiting is None and run.error is None and not run.loop.failures:
            self._waiting, self._of = (run, files), _settings_of(task)
        else:
            run.close()

    def close(self) -> None:
        """Release its engines."""
        waiting, self._waiting = self._waiting, None
        if waiting is not None:
            waiting[0].close()

    def _reset_run(self, task: Task) -> tuple[Run, FilesRead] | None:
        """Return the open run at time 0; the caller then owns it."""
        seeds = [int(text.removeprefix(_SEED)) for text in task.overrides if text.startswith(_SEED)]
        if self._waiting is None or len(seeds) != 1:
            return None
        run, files = self._waiting
        try:
            with files:
                run.reset(seed=seeds[0])
        except CapabilityError:
            return None
        self._waiting = None
        return run, files


def _settings_of(task: Task) -> tuple[str, tuple[str, ...]]:
    """Return what tasks that differ only in the seed have in common."""
    return task.experiment, tuple(text for text in task.overrides if not text.startswith(_SEED))


RUN_CACHE = RunCache()
"""The run that this process keeps open."""


def perform(task: Task) -> Record:
    """Perform a run and return its record, which also holds an error of the run.

    Raises:
        BackendLoadError: this worker has another version of the code.
    """
    return perform_alone(_attempt(task))


def perform_share(tasks: Iterable[Task]) -> Iterator[Record]:
    """Perform runs, side by side where they allow it, and yield their records as they end.

    Raises:
        BackendLoadError: as :func:`perform`.
    """
    return perform_side_by_side(_attempt(task, is_shared=True) for task in tasks)


def perform_list(tasks: Sequence[Task]) -> list[Record]:
    """Perform runs as :func:`perform_share`, and return all records at once, from another process."""
    return list(perform_share(tasks))


def _attempt(task: Task, *, is_shared: bool = False) -> Attempt[Record]:
    """Open the run of a task, and return its record after its end; others may step meanwhile if it is shared.

    One call of a function for all copies fails for all, so a shared run with a failure is repeated alone.
    """
    require_code(task.code)
    began_ns, files = work.now_ns(), FilesRead()
    try:
        record = yield from _attempt_run(task, files, is_shared=is_shared)
    except NrpError as error:
        record = Record(task.id, task.index, error=_in_one_line(error))
        record = record.depending_on(dependencies(files, None))
    elapsed_s = record.elapsed_s + seconds(work.now_ns() - began_ns)
    return replace(record, elapsed_s=elapsed_s, attempts=task.attempt)


def require_code(code: Mapping[str, str], where: str = "a worker") -> None:
    """Refuse to mix results of different code.

    Raises:
        BackendLoadError: a package here has another fingerprint.
    """
    other = [package for package, expected in code.items() if fingerprint(package) != expected]
    if other:
        names = " and ".join(f"'{package}'" for package in other)
        raise BackendLoadError(
            f"{where} has a different version of {names} from the process that began the sweep; "
            "install the same version on every machine"
        )


def scalar_metric(name: str) -> ScalarMetric:
    """Return a metric by its name.

    Raises:
        ExperimentError: the metric does not exist, or compares two runs.
    """
    if name not in METRICS.names():
        raise ExperimentError(f"there is no metric '{name}'{did_you_mean(name, METRICS.names())}")
    metric = METRICS.load(name)
    if not isinstance(metric, ScalarMetric):
        raise ExperimentError(f"'{name}' compares two runs, so a single run has no value of it")
    return metric


def _attempt_run(task: Task, files: FilesRead, *, is_shared: bool) -> Attempt[Record]:
    """Perform a run; ``elapsed_s`` of its record is the time in which only others stepped, negative."""
    with ExitStack() as stack:
        folder = None if task.recording is None else Path(task.recording)
        metrics = [scalar_metric(name) for name in task.measure]
        if folder is None and any(metric.needs_recording for metric in metrics):
            folder = Path(stack.enter_context(TemporaryDirectory(prefix="nrp-sweep-"))) / "run"
        keep = folder is None
        run, files = RUN_CACHE.open(task, files, keep=keep)
        stack.callback(run.close)
        files.packages |= {METRICS.provider(name).package for name in task.measure}
        others_s = yield from _ended(run, task, folder, files)
        if is_shared and run.loop.failures and not why_alone(run):
            stack.close()
            return replace(perform(task), elapsed_s=-others_s)
        with files:
            result = run.result()
            described = {"seed": result.seed, "settings": run.experiment, "result": result.to_dict()}
            signals = RunSignals(to_jsonable(described) if folder is None else Recording(folder))
            units = {
                f"{one.name}.{part}": unit for one in metrics for part, unit in one.units(signals).items()
            }
            record = _record(task, result, _measured(metrics, signals, result), units)
        read = dependencies(files, run.experiment, run.world.scene, folder)
        record = replace(record, drawn=_drawn(run), elapsed_s=-others_s).depending_on(read)
        if keep:
            stack.pop_all()
            RUN_CACHE.give_back(task, run, files)
        return record


def _ended(run: Run, task: Task, folder: Path | None, files: FilesRead) -> Attempt[float]:
    """Yield a run to be taken to its end, recorded or not; a failure is in the result of the run.

    Returns:
        The wall time in which only other runs stepped, s.
    """
    recorder = None
    if folder is not None:
        images = Images.HASH if task.recording else Images.OFF
        shutil.rmtree(folder, ignore_errors=True)  # of an earlier run, which is outdated or failed
        recorder = RecordingFolder(run, folder, images=images, files=files, snapshots_ns=None)
    state, began_ns, before_s = "failed", work.now_ns(), run.wall_s
    try:
        with _stopping(run, task.stop_when_failed):
            yield Opened(run, task.until_s, files)
        state = "finished"
    except SimulationError:
        pass
    finally:
        others_s = seconds(work.now_ns() - began_ns) - (run.wall_s - before_s)
        if recorder is not None:
            recorder.close(state)
    return max(0.0, others_s)


@contextmanager
def _stopping(run: Run, criteria: Sequence[str]) -> Iterator[None]:
    """Stop the run of a block as soon as one of these criteria is not met."""

    def stop_if_failed(_: Run) -> None:
        passed = run.passed()
        if any(passed[name] is False for name in criteria):
            run.loop.stop()

    if not criteria:
        yield
        return
    observer = run.on_step(stop_if_failed)
    try:
        yield
    finally:
        run.observers.remove(observer)


def _measured(metrics: list[ScalarMetric], signals: RunSignals, result: Result) -> dict[str, float | None]:
    """Return all values; a failed run has only those of its finding."""
    measured: dict[str, float | None] = {}
    for metric in metrics:
        if result.error is None or metric.is_finding:
            for part, value in metric.values(signals).items():
                measured[f"{metric.name}.{part}"] = None if value is None else float(value)
    return to_jsonable(measured)  # type: ignore[no-any-return]  # NaN is null


def _record(task: Task, result: Result, measured: Mapping[str, Any], units: Mapping[str, str]) -> Record:
    return Record(
        task.id,
        task.index,
        seed=result.seed,
        brain=result.brain,
        world=result.world,
        state=result.state,
        complete=result.complete,
        passed=result.passed,
        problems=tuple(dict.fromkeys(problem.code.name for problem in result.problems)),
        measured=measured,
        units=units,
        sim_time_s=result.sim_time_s,
        wall_time_s=result.wall_time_s,
        trajectory_digest=result.trajectory_digest,
        error=result.error,
    )


_COMPONENTS = {"gains": "pid", "sensor_position": "xyz", "sensor_orientation": ("roll", "pitch", "yaw")}


def _drawn(run: Run) -> dict[str, float]:
    """Return the values drawn for the seed of a run, one number for each column of a table."""
    found: dict[str, float] = {}
    for draw in run.world.randomized:
        name = f"world.randomize.{draw.quantity}.{draw.part}"
        if draw.quantity in _COMPONENTS:
            parts = zip(_COMPONENTS[draw.quantity], draw.values, strict=True)
            found |= {f"{name}.{part}": value for part, value in parts}
        else:
            (found[name],) = draw.values
    return found


def _in_one_line(error: NrpError) -> str:
    findings = [str(finding) for finding in getattr(error, "findings", ()) if finding.level == "error"]
    return "; ".join(findings) or str(error)
