"""Tasks with every pair of backends, and their standings: score, speed, activity and agreement."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from math import sqrt
from pathlib import Path
from statistics import NormalDist, fmean, median
from typing import Any

from rich.console import Console
from rich.table import Table

from nrp_lab.benchmark.tasks import MEASURES, TASKS, BenchmarkTask
from nrp_lab.comparison.grid import RunGrid
from nrp_lab.comparison.judgement import Answer, combined
from nrp_lab.sweep.executor import Executor
from nrp_lab.sweep.model import SEED, Axis, Choices, SweepFile
from nrp_lab.sweep.plan import Plan
from nrp_lab.sweep.record import INVALID
from nrp_lab.sweep.report import cell_of, judged_rows
from nrp_lab.sweep.running import Progress, SweepRun
from nrp_lab.sweep.table import Row, write_rows


def answer_of(grid: RunGrid, rows: Sequence[Row]) -> Answer:
    """Return the factors that affect the finding of an experiment; NONE for a single pair of backends.

    Backends that cannot begin the task with any partner are omitted.

    Args:
        grid: the grid of runs.
        rows: the rows of the ended runs.
    """
    begun = [row for row in rows if row["state"] != INVALID]
    cells = [cell_of(row) for row in begun]
    brains = tuple(name for name in grid.brains if any(cell.brain == name for cell in cells))
    worlds = tuple(name for name in grid.worlds if any(cell.world == name for cell in cells))
    if len(brains) * len(worlds) < 2:
        return Answer.NONE
    able = replace(grid, brains=brains, worlds=worlds)
    return combined(one.answer for one in judged_rows(able, begun, MEASURES))


CONFIDENCE = 0.95


@dataclass(frozen=True, slots=True)
class Standing:
    """The runs of one task with one pair of backends.

    Args:
        task: name of the task.
        brain, world: names of the backends.
        runs: number of runs that have ended.
        failed: number of runs that an error ended; their score is 0.
        passed: number of runs that met all criteria of the experiment.
        score: mean score; None if the task cannot begin with these backends.
        interval: its 95 % confidence interval.
        real_time_factor: simulated time by wall time of the steps, the median of the runs.
        spikes_hz: spikes of all neurons in a simulated second, the mean of the runs.
        synaptic_events_hz: synapses that they reach in a simulated second.
        agreement: the factors that affect the experiment's finding, over all pairs that can do the task.
        error: the most severe error, or empty.
    """

    task: str
    brain: str
    world: str
    runs: int
    failed: int
    passed: int
    score: float | None
    interval: tuple[float, float] | None
    real_time_factor: float | None
    spikes_hz: float | None
    synaptic_events_hz: float | None
    agreement: Answer
    error: str = ""


def standings(task: BenchmarkTask, grid: RunGrid, rows: Sequence[Row]) -> list[Standing]:
    """Return the standing of each pair of backends that has runs."""
    agreement = answer_of(grid, rows)
    pairs: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        pairs.setdefault((row["brain.backend"], row["world.backend"]), []).append(row)
    return [_standing(task, brain, world, own, agreement) for (brain, world), own in pairs.items()]


def _standing(task: BenchmarkTask, brain: str, world: str, rows: list[Row], agreement: Answer) -> Standing:
    begun = [row for row in rows if row["state"] != INVALID]
    whole = [row for row in begun if row["error"] is None]
    scores = [task.score(row) for row in begun]
    score = fmean(scores) if scores else None
    return Standing(
        task.name, brain, world, len(rows), sum(row["error"] is not None for row in rows),
        sum(row["passed"] is True for row in rows), score,
        None if score is None else wilson_interval(score, len(scores)),
        median(row["sim_time_s"] / row["wall_time_s"] for row in whole) if whole else None,
        _mean(whole, "activity.spikes"), _mean(whole, "activity.synaptic_events"), agreement,
        next((str(row["error"]) for row in rows if row["error"] is not None), ""),
    )  # fmt: skip


def _mean(rows: Sequence[Row], name: str) -> float | None:
    return fmean(row[name] or 0.0 for row in rows) if rows else None


def wilson_interval(mean: float, n: int) -> tuple[float, float]:
    """Return the 95 % confidence interval of a mean of values from 0 to 1.

    It is that of Wilson (1927, J. Am. Stat. Assoc. 22:209) for a share. No other values from 0 to 1 with the
    same mean spread more than yes and no do, so for graded scores it is, if anything, too wide; and equal
    scores of a few runs do not give an interval without width.

    Args:
        mean: the mean.
        n: number of values, at least 1.
    """
    z = NormalDist().inv_cdf(0.5 + CONFIDENCE / 2)
    middle = (mean + z * z / (2 * n)) / (1 + z * z / n)
    reach = z / (1 + z * z / n) * sqrt(mean * (1 - mean) / n + (z / (2 * n)) ** 2)
    return max(middle - reach, 0.0), min(middle + reach, 1.0)


CSV = "benchmark.csv"
_HEADS = ("task", "brain", "world", "score", "95 %", "passed", "real time", "spikes/s", "synaptic events/s")
_TEXTS = 3


def report(standings: Sequence[Standing], console: Console) -> None:
    """Print the runs that failed, the table, and for each task whether the backends agree."""
    for error, count in Counter(one.error for one in standings if one.error).items():
        console.print(f"{count} {'pair' if count == 1 else 'pairs'} of backends: {error}", markup=False)
    table = Table(box=None, pad_edge=False, header_style="bold")
    for place, head in enumerate(_HEADS):
        table.add_column(head, justify="left" if place < _TEXTS else "right")
    for one in standings:
        table.add_row(*_cells(one))
    console.print(table)
    for name, agreement in {one.task: one.agreement for one in standings}.items():
        console.print(f"{name} ({TASKS[name].asks}): {_agreement(agreement)}", markup=False)


def report_data(standings: Sequence[Standing], folder: Path) -> dict[str, Any]:
    """Return the standings as plain data."""
    return {"folder": folder, "standings": [asdict(one) for one in standings]}


def write_csv(standings: Sequence[Standing], folder: Path) -> Path:
    """Write the standings into the folder of the benchmark, and return the file.

    Raises:
        ExperimentError: it cannot be written.
    """
    return write_rows(folder / CSV, [_row(one) for one in standings])


def _row(one: Standing) -> dict[str, Any]:
    row = asdict(one)
    low, high = row.pop("interval") or (None, None)
    return {**row, "score_low": low, "score_high": high}


def _cells(one: Standing) -> list[str]:
    if one.score is None or one.interval is None:
        return [one.task, one.brain, one.world, "cannot run", *[""] * (len(_HEADS) - _TEXTS - 1)]
    low, high = one.interval
    speed = "-" if one.real_time_factor is None else f"{one.real_time_factor:.1f} x"
    return [
        one.task, one.brain, one.world, f"{one.score:.2f}", f"{low:.2f} to {high:.2f}",
        f"{one.passed} of {one.runs}", speed, _count(one.spikes_hz), _count(one.synaptic_events_hz),
    ]  # fmt: skip


def _count(number: float | None) -> str:
    return "-" if number is None else f"{number:,.0f}"


def _agreement(answer: Answer) -> str:
    return "one pair of backends, nothing to compare" if answer is Answer.NONE else f"the finding: {answer}"


OnProgress = Callable[[str, Progress], None]
"""Called after every run with the name of the task and the progress of its runs."""


class Ladder:
    """Tasks for backends, each a sweep in its own folder below ``folder``.

    Args:
        tasks: the tasks.
        brains, worlds: names of backends.
        seeds: number of seeds, counted up from the experiment's own, as in ``nrp diff``.
        folder: the folder; existing runs are reused.

    Raises:
        ExperimentError: a folder contains other results.
        BackendError: a backend does not exist, or does not load.
    """

    def __init__(
        self, tasks: Sequence[BenchmarkTask], brains: Sequence[str], worlds: Sequence[str], seeds: int,
        folder: Path,
    ) -> None:  # fmt: skip
        self.tasks, self.folder = tuple(tasks), folder
        self.grids = {task.name: RunGrid.of(task.experiment, brains, worlds, seeds) for task in tasks}
        plans = {name: Plan.of(_sweep(grid)) for name, grid in self.grids.items()}
        self._made = {name: SweepRun(plan, folder / name) for name, plan in plans.items()}

    @property
    def runs(self) -> int:
        """The number of all runs."""
        return sum(len(made.plan) for made in self._made.values())

    @property
    def pending(self) -> int:
        """The number of runs that are still to be made."""
        return sum(len(made.pending) for made in self._made.values())

    def report_warnings(self, report: Callable[[str], None]) -> None:
        """Report warnings about the experiments that are still to be run."""
        for made in self._made.values():
            if made.pending:
                made.plan.report_warnings(report)

    def run(self, executor: Executor, on_progress: OnProgress = lambda _task, _progress: None) -> None:
        """Make the pending runs.

        Raises:
            NrpError: the disk is full, or the executor gives up; finished runs are kept.
        """
        for name, made in self._made.items():
            executor.folder = made.folder
            made.run(executor, lambda progress, name=name: on_progress(name, progress))  # type: ignore[misc]

    def standings(self) -> list[Standing]:
        """Return how each pair of backends does in each task, from the runs that have ended."""
        return [
            standing
            for task in self.tasks
            for standing in standings(task, self.grids[task.name], self._made[task.name].rows)
        ]


def _sweep(grid: RunGrid) -> SweepFile:
    """Return the sweep that makes the runs of a grid."""
    vary: dict[str, Axis] = {
        "brain.backend": Choices(grid.brains),
        "world.backend": Choices(grid.worlds),
        **grid.varied,
        SEED: Choices(grid.seeds),
    }
    return SweepFile(experiment=grid.experiment, vary=vary, measure=MEASURES)
