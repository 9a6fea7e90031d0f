"""Run tasks with every brain in every world from every seed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from nrp_lab.benchmark.standings import Standing, standings
from nrp_lab.benchmark.tasks import MEASURES, BenchmarkTask
from nrp_lab.comparison.grid import RunGrid
from nrp_lab.sweep.axes import Axis, Choices
from nrp_lab.sweep.executors.interface import Executor
from nrp_lab.sweep.model import SEED, SweepFile
from nrp_lab.sweep.plan import Plan
from nrp_lab.sweep.running import Progress, SweepRun

Tell = Callable[[str, Progress], None]
"""Called after every run with the name of the task and the progress of its runs."""


class Ladder:
    """Tasks for backends, each a sweep in its own folder below ``folder``.

    Args:
        tasks: the tasks.
        brains, worlds: names of backends.
        seeds: number of seeds, counted up from the experiment's own, as in ``nrp diff``.
        folder: the folder; runs that it already holds are not repeated.

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

    def tell_doubts(self, say: Callable[[str], None]) -> None:
        """Tell what a check doubts about the experiments that are still to be run."""
        for made in self._made.values():
            if made.pending:
                made.plan.tell_doubts(say)

    def run(self, executor: Executor, tell: Tell = lambda _task, _progress: None) -> None:
        """Make the pending runs.

        Raises:
            NrpError: the disk is full, or the executor gives up; finished runs are kept.
        """
        for name, made in self._made.items():
            executor.folder = made.folder
            made.run(executor, lambda progress, name=name: tell(name, progress))  # type: ignore[misc]

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
