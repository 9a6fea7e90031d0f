"""The tasks, from the easiest to the hardest, and their scores."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_lab.sweep.table import Row

DEGREE: Final = "degree"
MEASURES: Final = ("criteria", "time_to_event", DEGREE, "activity")


@dataclass(frozen=True, slots=True)
class BenchmarkTask:
    """An experiment with a score.

    Args:
        name: its name.
        experiment: the shipped experiment.
        asks: the brain's task, in a few words.
        goals: the criteria that are to be met.
        conditions: criteria that limit how; without a goal they earn nothing.
    """

    name: str
    experiment: str
    asks: str
    goals: tuple[str, ...]
    conditions: tuple[str, ...] = ()

    def score(self, row: Row) -> float:
        """Return the score of a run, from 0 to 1.

        It is the mean degree to which the goals are met, times the smallest degree of the conditions. So a
        robot that does nothing scores 0, however carefully it does it.

        Args:
            row: the row of the run; a run that failed scores 0.
        """
        if row["error"] is not None:
            return 0.0
        goals = [_degree(row, name) for name in self.goals]
        return sum(goals) / len(goals) * min((_degree(row, name) for name in self.conditions), default=1.0)


def _degree(row: Row, name: str) -> float:
    return float(row[f"{DEGREE}.{name}"] or 0.0)


TASKS: Final = {
    task.name: task
    for task in (
        BenchmarkTask(
            "phototaxis",
            "braitenberg_husky",
            "drive to the screen that is red",
            ("reaches_left", "reaches_right"),
        ),
        BenchmarkTask(
            "avoidance",
            "slalom_pioneer",
            "drive through a hall and touch nothing",
            ("gets_through",),
            ("touches_nothing",),
        ),
        BenchmarkTask(
            "tracking",
            "following_head",
            "keep a swinging ball in the middle of the image",
            ("keeps_the_ball_in_the_middle",),
        ),
        BenchmarkTask(
            "walking", "walking_hexapod", "walk to a flag on six legs with 24 joints", ("walks_to_the_flag",)
        ),
        BenchmarkTask(
            "reaching",
            "reaching_arm",
            "learn to reach with an arm whose motors are too weak",
            ("reaches_the_targets",),
        ),
    )
}
"""The tasks by name."""


def tasks_of(names: Iterable[str]) -> list[BenchmarkTask]:
    """Return the tasks of these names in the order of their difficulty, by default all.

    Raises:
        ExperimentError: a task does not exist, or is given twice.
    """
    given = list(names)
    wanted = set(given) or set(TASKS)
    for name in sorted(wanted - TASKS.keys()):
        raise ExperimentError(f"there is no task '{name}'{did_you_mean(name, TASKS)}")
    for place, name in enumerate(given):
        if name in given[:place]:
            raise ExperimentError(f"the task '{name}' is given twice")
    return [task for name, task in TASKS.items() if name in wanted]
