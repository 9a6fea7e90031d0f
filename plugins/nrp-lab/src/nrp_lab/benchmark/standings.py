"""How each pair of backends does in a task: score, speed, activity, and whether the pairs agree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from statistics import NormalDist, fmean, median

from nrp_lab.benchmark.agreement import answer_of
from nrp_lab.benchmark.tasks import BenchmarkTask
from nrp_lab.comparison.grid import RunGrid
from nrp_lab.comparison.judgement import Answer
from nrp_lab.sweep.record import INVALID
from nrp_lab.sweep.table import Row

CONFIDENCE = 0.95


@dataclass(frozen=True, slots=True)
class Standing:
    """The runs of one task with one pair of backends.

    Args:
        task: name of the task.
        brain, world: names of the backends.
        runs: number of runs that have ended.
        failed: number of those that an error ended; their score is 0.
        passed: number of those that met all criteria of the experiment.
        score: mean score; None if the task cannot begin with these backends.
        interval: its 95 % confidence interval.
        real_time_factor: simulated time by wall time of the steps, the median of the runs.
        spikes_hz: spikes of all neurons in a simulated second, the mean of the runs.
        synaptic_events_hz: synapses that they reach in a simulated second.
        agreement: what the finding of the experiment depends on, over all pairs that can do the task.
        error: the most severe error; empty if there is none.
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
