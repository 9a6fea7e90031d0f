"""One learner in one task with one seed: it trains and is tested, and so are the baselines."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from nrp_core.errors import ExperimentError
from nrp_core.experiment import Experiment, Run, experiment_of, tree_of
from nrp_core.messages.std_msgs import Bool, Float64, Float64MultiArray
from nrp_core.recording import FilesRead, dependencies
from nrp_core.seeds import Seeds
from nrp_lab.learning.learner import read_learner
from nrp_lab.learning.task import STEP_MS, Task
from nrp_lab.learning.tasks import TASKS

CONDITIONS = ("learned", "shuffled", "unlearned", "random", "controller")
"""``shuffled``: trained with the rewards of ``learned`` in random order; ``unlearned``: not trained."""
_TRAINED = ("learned", "shuffled")
_PAUSE = 6
"""Number of steps between two episodes, in which traces of the last one decay."""
_LONGEST = "100000 s"
_TOPICS = {
    "/task/observation": "std_msgs/Float64MultiArray",
    "/task/reward": "std_msgs/Float64",
    "/task/failed": "std_msgs/Bool",
    "/task/learning": "std_msgs/Bool",
    "/task/action": "std_msgs/Int32",
}


@dataclass(frozen=True)
class Trial:
    """A task, a learner and a seed.

    Args:
        task: name of the task.
        learner: file of the learner.
        seed: the seed of the brain and of the episodes.
        brain, world: names of the backends.
        training: number of training steps; None: the task's own.
    """

    task: str
    learner: Path
    seed: int
    brain: str = "event"
    world: str = "mujoco"
    training: int | None = None


@dataclass(frozen=True)
class Episode:
    """An episode.

    Args:
        score: from 0 to 1.
        steps: number of steps.
        trains: whether the learner could learn in it.
    """

    score: float
    steps: int
    trains: bool


@dataclass
class Outcome:
    """What came of one condition of a trial.

    Args:
        condition: one of :data:`CONDITIONS`.
        episodes: in their order.
        steps: number of steps of the loop, pauses included.
        cpu_s: CPU time of the steps.
        spikes: number of spikes of all neurons.
        rewards: the reward of every step of training.
    """

    condition: str
    episodes: list[Episode] = field(default_factory=list)
    steps: int = 0
    cpu_s: float = 0.0
    spikes: int = 0
    rewards: list[float] = field(default_factory=list)

    @property
    def score(self) -> float:
        """The mean score of the test."""
        return float(np.mean([one.score for one in self.episodes if not one.trains]))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data without the rewards."""
        return {"score": self.score, **asdict(self) | {"rewards": None}}


def perform(trial: Trial, conditions: Sequence[str] = CONDITIONS) -> list[Outcome]:
    """Perform a trial.

    Raises:
        ExperimentError: the learner is wrong, or changed weights in the test.
    """
    with Run(_experiment(trial)) as run:
        return _perform_in(run, trial, conditions)


def perform_to_keep(trial: Trial) -> dict[str, Any]:
    """Perform all conditions of a trial, and return the outcomes and what they depend on as plain data.

    Raises:
        ExperimentError: the learner is wrong, or changed weights in the test.
    """
    with FilesRead() as files, Run(_experiment(trial)) as run:
        files.packages.add("nrp_lab")  # the task and its episodes
        outcomes = _perform_in(run, trial, CONDITIONS)
        read = dependencies(files, run.experiment, run.world.scene)
    return {"outcomes": [one.to_dict() for one in outcomes], "dependencies": read.to_data()}


def _perform_in(run: Run, trial: Trial, conditions: Sequence[str]) -> list[Outcome]:
    outcomes: list[Outcome] = []
    for condition in conditions:
        rewards = next((one.rewards for one in outcomes if one.condition == "learned"), [])
        outcomes.append(_Episodes(run, trial, condition, rewards).run())
        run.reset()
    return outcomes


def _experiment(trial: Trial) -> Experiment:
    task, learner = TASKS[trial.task], read_learner(trial.learner)
    sizes = {"observed": len(task.observed), "actions": len(task.actions)}
    world: dict[str, Any] = {"backend": trial.world, "scene": str(task.folder / task.body)}
    if task.robot:
        world["robots"] = {Path(task.robot).stem: {"model": str(task.folder / task.robot)}}
    return experiment_of(
        tree_of(
            {
                "name": trial.task,
                "timestep": f"{STEP_MS} ms",
                "duration": _LONGEST,
                "seed": trial.seed,
                "brain": {
                    "backend": trial.brain,
                    "model": str(learner.model),
                    "parameters": sizes | learner.brain_parameters,
                },
                "world": world,
                "transfer_functions": list(map(str, learner.transfer_functions)),
                "function_parameters": sizes | learner.function_parameters,
                "topics": _TOPICS,
            }
        )
    )


class _Episodes:
    """Presents episodes to a run: first those of training, then those of the test.

    Before the transfer functions of a step, it publishes the body's observations; after them, it
    commands the body. So an action acts in the step after the one in which it was chosen.
    """

    def __init__(self, run: Run, trial: Trial, condition: str, rewards: Sequence[float]) -> None:
        self._run, self._condition = run, condition
        self._task: Task = TASKS[trial.task](run.world)
        steps = trial.training or self._task.training
        self._to_train = steps if condition in _TRAINED else 0
        self._to_test = self._task.tests
        self._pause = _PAUSE
        self._seeds = Seeds(trial.seed).child("learning")
        self._choices = self._seeds.stream("random actions")
        order = self._seeds.stream("shuffled rewards").permutation(len(rewards))
        self._shuffled = [rewards[index] for index in order] if condition == "shuffled" else []
        self._publications = {name: run.world.advertise(name) for name in list(_TOPICS)[:-1]}
        self._chosen = run.world.subscribe("/task/action")
        self._said: dict[str, bool] = {}
        self._tested: Any = None
        self.outcome = Outcome(condition)

    def run(self) -> Outcome:
        """Run all episodes, from time 0 of the run."""
        run, hooks, outcome = self._run, self._run.loop.hooks, self.outcome
        hooks.before_functions.append(self._present)
        hooks.after_step.append(self._act)
        try:
            began = time.process_time()
            run.run()
            outcome.cpu_s, outcome.steps = time.process_time() - began, run.loop.steps
        finally:
            hooks.before_functions.remove(self._present)
            hooks.after_step.remove(self._act)
            run.world.unsubscribe(self._chosen)
        outcome.spikes = int(run.result().activity["spikes"] or 0)
        return outcome

    @property
    def _trains(self) -> bool:
        return self._to_train > 0

    def _present(self, _: object) -> None:
        if self._pause:
            self._pause -= 1
            if self._pause == 0:
                self._begin()
            self._say(() if self._pause else self._task.scaled())
            return
        task = self._task
        task.steps += 1
        reward, failed = task.judge()
        if self._trains:
            self.outcome.rewards.append(reward)
            if self._shuffled:
                reward = self._shuffled[len(self.outcome.rewards) % len(self._shuffled)]
        if failed or task.steps == task.longest:
            self._say((), reward, failed)
            self._end()
        else:
            self._say(task.scaled(), reward)

    def _begin(self) -> None:
        kind = "training" if self._trains else "test"
        number = sum(one.trains is self._trains for one in self.outcome.episodes)
        self._task.steps = 0
        self._task.begin(self._seeds.stream(f"{kind} {number}"))
        if not self._trains and self._tested is None:
            self._tested = self._weights()

    def _end(self) -> None:
        task = self._task
        self.outcome.episodes.append(Episode(task.score(), task.steps, self._trains))
        self._pause = _PAUSE
        if self._trains:
            self._to_train -= task.steps
            return
        self._to_test -= 1
        if self._to_test == 0:
            if self._weights() != self._tested:
                raise ExperimentError(
                    "the learner changed weights in the test, when /task/learning was false"
                )
            self._run.loop.stop()

    def _say(self, observation: Sequence[float], reward: float = 0.0, failed: bool = False) -> None:
        send = self._publications
        send["/task/observation"].publish(Float64MultiArray(data=np.array(observation)))
        send["/task/reward"].publish(Float64(reward))
        for name, value in (("/task/failed", failed), ("/task/learning", self._trains)):
            if self._said.get(name) is not value:
                self._said[name] = value
                send[name].publish(Bool(value))

    def _act(self, _: object) -> None:
        if self._pause:
            return
        match self._condition:
            case "random":
                action = int(self._choices.integers(len(self._task.actions)))
            case "controller":
                action = self._task.control()
            case _:
                latest = self._chosen.latest
                action = 0 if latest is None else latest.message.data
                if not 0 <= action < len(self._task.actions):
                    most = len(self._task.actions) - 1
                    raise ExperimentError(
                        f"the learner chose action {action}; there are those from 0 to {most}"
                    )
        self._task.act(action)

    def _weights(self) -> list[bytes]:
        brain = self._run.brain
        return [brain.read_weights(one.label).tobytes() for one in brain.network.projections if one.label]
