"""Tasks with every seed, in processes; outcomes in files, so that a stopped ladder can continue."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.recording import changes_since
from nrp_core.utilities import WorkerPool, cores, join_with_limit, to_jsonable, writing
from nrp_lab.learning.tasks import TASKS
from nrp_lab.learning.trial import CONDITIONS, Trial, perform_to_keep

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
        folder: where outcomes are kept. They are reused until a file, package or variable that the trial
            read has changed.
        training: number of training steps in each task; None: each task's own.

    Attributes:
        news: a sentence on the changes that make earlier outcomes outdated; empty if none do.

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
        self._trials = {
            self._file(trial): (trial, to_jsonable(asdict(trial)))
            for seed in range(1, seeds + 1)
            for name in self.tasks
            for trial in [Trial(name, learner, seed, brain, world, training)]
        }
        kept = {path: settings for path, (_, settings) in self._trials.items() if path.is_file()}
        outdated = {path: found for path, settings in kept.items() if (found := _changes(path, settings))}
        self._reused = kept.keys() - outdated.keys()
        changes = join_with_limit(list(dict.fromkeys(chain(*outdated.values()))), 5)
        self.news = f"{len(outdated)} earlier outcomes do not count: {changes} changed" if outdated else ""

    @property
    def pending(self) -> list[Trial]:
        """The trials without an outcome that counts."""
        return [trial for path, (trial, _) in self._trials.items() if path not in self._reused]

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
                self._keep(trial, perform_to_keep(trial))
                on_progress(done := done + 1, len(self._trials))
            return
        with WorkerPool(size) as pool:
            for outcome in pool.perform(perform_to_keep, pending):
                if outcome.error is not None:
                    raise outcome.error
                assert outcome.value is not None
                self._keep(outcome.task, outcome.value)
                on_progress(done := done + 1, len(self._trials))

    def standings(self) -> list[Standing]:
        """Return the results of the trials that have an outcome."""
        found: list[Standing] = []
        for name in self.tasks:
            made = [path for path, (trial, _) in self._trials.items() if trial.task == name]
            rows = [json.loads(path.read_text("utf-8"))["outcomes"] for path in made if path in self._reused]
            if rows:
                found += [_standing(name, [row[place] for row in rows]) for place in range(len(CONDITIONS))]
        return found

    def _keep(self, trial: Trial, made: dict[str, Any]) -> None:
        path = self._file(trial)
        with writing(path):
            path.write_text(json.dumps({**self._trials[path][1], **made}), "utf-8")
        self._reused.add(path)

    def _file(self, trial: Trial) -> Path:
        return self.folder / f"{trial.task}-{trial.seed}.json"


def _changes(path: Path, settings: Mapping[str, Any]) -> list[str]:
    """Return the changes since the outcome in a file was made, a phrase for each.

    Raises:
        ExperimentError: it was made with other settings.
    """
    kept = json.loads(path.read_text("utf-8"))
    if other := [key for key, value in settings.items() if kept[key] != value]:
        raise ExperimentError(f"it has the outcome of another {' and '.join(other)}", path=path)
    return changes_since(kept, None)


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
