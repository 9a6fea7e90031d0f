"""Tasks with every seed, in processes; outcomes in files, so that a stopped ladder can continue."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.utilities import WorkerPool, cores, fingerprint, to_jsonable, writing
from nrp_lab.learning.tasks import TASKS
from nrp_lab.learning.trial import CONDITIONS, Trial, perform

BLOCKS = 10
"""Number of points of a learning curve."""


@dataclass(frozen=True)
class Standing:
    """One condition of a task, over the seeds.

    Args:
        task, condition: their names.
        scores: the mean score of the test of each seed.
        curve: in each block of the training the mean over its steps of the score of their episode, shape
            ``(seeds, blocks)``; empty without training.
        cpu_us, spikes: CPU time and spikes of a step, mean.
    """

    task: str
    condition: str
    scores: tuple[float, ...]
    curve: tuple[tuple[float, ...], ...]
    cpu_us: float
    spikes: float

    @cached_property
    def quartiles(self) -> tuple[float, float, float]:
        """The quartiles of the scores."""
        low, middle, high = np.quantile(self.scores, (0.25, 0.5, 0.75))
        return float(low), float(middle), float(high)

    def better_than(self, others: Iterable[Standing]) -> int:
        """Return the number of seeds with a score clearly above those of all others with the same seed.

        The margin is the largest standard deviation from seed to seed of one of the others: without it, a
        score that another test would exceed by chance counts.
        """
        scores = np.array([other.scores for other in others])
        margin = scores.std(axis=1, ddof=1).max() if scores.shape[1] > 1 else 0.0
        return int((np.array(self.scores) > scores.max(axis=0) + margin).sum())


BASELINES = ("shuffled", "unlearned", "random")
"""The conditions that a learner has to beat."""


class Ladder:
    """Trials of tasks with seeds 1 to ``seeds``.

    Args:
        tasks: names of tasks; none: all.
        learner: file of the learner.
        brain, world: names of backends.
        seeds: their number.
        folder: where outcomes are kept, and found again.
        training: number of training steps in each task; None: each task's own.

    Raises:
        ExperimentError: a task does not exist, or the folder has outcomes of other settings.
    """

    def __init__(
        self, tasks: Sequence[str], learner: Path, brain: str, world: str, seeds: int, folder: Path,
        training: int | None = None,
    ) -> None:  # fmt: skip
        for name in tasks:
            if name not in TASKS:
                raise ExperimentError(f"there is no task '{name}'{did_you_mean(name, TASKS)}")
        self.tasks = [name for name in TASKS if name in tasks or not tasks]
        self.folder = folder
        code = fingerprint("nrp_lab")
        self._trials = {
            self._file(trial): (trial, {**to_jsonable(asdict(trial)), "code": code})
            for seed in range(1, seeds + 1)
            for name in self.tasks
            for trial in [Trial(name, learner, seed, brain, world, training)]
        }
        for path, (_, settings) in self._trials.items():
            if path.is_file():
                kept = json.loads(path.read_text("utf-8"))
                if other := [key for key, value in settings.items() if kept[key] != value]:
                    raise ExperimentError(f"it has the outcome of another {' and '.join(other)}", path=path)

    @property
    def pending(self) -> list[Trial]:
        """The trials without an outcome."""
        return [trial for path, (trial, _) in self._trials.items() if not path.is_file()]

    def run(
        self, workers: int | None, on_progress: Callable[[int, int], None] = lambda _n, _of: None
    ) -> None:
        """Perform the pending trials.

        Args:
            workers: number of processes; None: one per processor; 1: this one.
            on_progress: called with the number of trials with an outcome, and of all.

        Raises:
            NrpError: a trial failed; finished trials are kept.
        """
        pending = self.pending
        self.folder.mkdir(parents=True, exist_ok=True)
        size = min(workers or cores(), max(len(pending), 1))
        done = len(self._trials) - len(pending)
        if size == 1:
            for trial in pending:
                self._keep(trial, [one.to_dict() for one in perform(trial)])
                on_progress(done := done + 1, len(self._trials))
            return
        with WorkerPool(size) as pool:
            for outcome in pool.perform(perform, pending):
                if outcome.error is not None:
                    raise outcome.error
                assert outcome.value is not None
                self._keep(outcome.task, [one.to_dict() for one in outcome.value])
                on_progress(done := done + 1, len(self._trials))

    def standings(self) -> list[Standing]:
        """Return the results of the trials that have an outcome."""
        found: list[Standing] = []
        for name in self.tasks:
            paths = [
                path for path, (trial, _) in self._trials.items() if trial.task == name and path.is_file()
            ]
            rows = [json.loads(path.read_text("utf-8"))["outcomes"] for path in paths]
            if rows:
                found += [_standing(name, [row[place] for row in rows]) for place in range(len(CONDITIONS))]
        return found

    def _keep(self, trial: Trial, outcomes: list[dict[str, Any]]) -> None:
        path = self._file(trial)
        with writing(path):
            path.write_text(json.dumps({**self._trials[path][1], "outcomes": outcomes}), "utf-8")

    def _file(self, trial: Trial) -> Path:
        return self.folder / f"{trial.task}-{trial.seed}.json"


def _standing(task: str, outcomes: list[dict[str, Any]]) -> Standing:
    steps = sum(one["steps"] for one in outcomes)
    return Standing(
        task,
        outcomes[0]["condition"],
        tuple(one["score"] for one in outcomes),
        tuple(curve for one in outcomes if (curve := _curve(one["episodes"]))),
        1e6 * sum(one["cpu_s"] for one in outcomes) / steps,
        sum(one["spikes"] for one in outcomes) / steps,
    )


def _curve(episodes: list[dict[str, Any]]) -> tuple[float, ...]:
    training = [one for one in episodes if one["trains"]]
    scores = np.repeat([one["score"] for one in training], [one["steps"] for one in training])
    return tuple(float(block.mean()) for block in np.array_split(scores, BLOCKS) if block.size)
