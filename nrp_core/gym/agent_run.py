"""A run with an agent in it: what the agent sets and sees, its rewards, and its episodes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, nan
from numbers import Real
from typing import Any, TypeAlias

import numpy as np
from gymnasium import spaces

from nrp_core.clock import seconds
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.errors import ExperimentError
from nrp_core.experiment.running.run import Run
from nrp_core.gym.acting import act_on
from nrp_core.gym.observing import Observed, observe

Reward: TypeAlias = Callable[[Run, dict[str, Any]], float]
"""Returns the reward of the last step, from the run and the observation by name."""
Terminate: TypeAlias = Callable[[Run, dict[str, Any]], bool]
"""Returns whether the episode is over."""


@dataclass(frozen=True)
class Agent:
    """What an agent observes, sets and is rewarded for; see :class:`~nrp_core.gym.env.NrpEnv`.

    Raises:
        ExperimentError: nothing is observed, or ``steps`` is not a number of steps.
    """

    observe: Sequence[str]
    act: Mapping[str, Any]
    reward: Reward | None
    terminate: Terminate | None
    steps: int
    same_noise: bool

    def __post_init__(self) -> None:
        if not isinstance(self.steps, int) or self.steps < 1:
            raise ExperimentError(
                f"a step of an environment is at least 1 step of the loop, not {self.steps}"
            )
        if isinstance(self.observe, str) or not self.observe:
            raise ExperimentError(
                "an environment needs a list of at least one observation: a topic, or 'rate:GROUP', not "
                f"{self.observe!r:.60}"
            )
        if not isinstance(self.same_noise, bool):
            raise ExperimentError(f"same_noise is true or false, not {self.same_noise!r:.60}")


def bounds_by_name(act: Sequence[str] | Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the actions with their bounds; None: those of the topic.

    Raises:
        ExperimentError: it is one text.
    """
    if isinstance(act, str):
        raise ExperimentError(f"actions are a list, or {{topic or 'source:GROUP': bounds}}, not {act!r:.60}")
    return act if isinstance(act, Mapping) else dict.fromkeys(act)


class AgentRun:
    """A run that an agent steps; each episode begins at its time 0.

    Args:
        run: the run, at time 0.
        agent: the agent.
        like: the same in another run of the experiment, which knows the shapes of observations.

    Attributes:
        acted, observed: the actions and observations by their names.
        decided: the criteria, and whether they are met; None: undecided.
    """

    def __init__(self, run: Run, agent: Agent, like: AgentRun | None = None) -> None:
        self.run, self._agent = run, agent
        lasts, step = run.experiment.duration, agent.steps * run.experiment.timestep
        if step > lasts:
            raise ExperimentError(
                f"a step of an environment of {agent.steps} steps of the loop takes {seconds(step):g} s, and "
                f"an episode {seconds(lasts):g} s"
            )
        replaced = [function.name for function in run.loop.functions if _publishes(function, agent.act)]
        run.loop.change((), replaced)
        self.acted = act_on(run, agent.act)
        self.observed: dict[str, Observed] = observe(
            run, agent.observe, None if like is None else like.observed
        )
        if (
            like is None and run.loop.functions
        ):  # their files may have kept values of the steps for the shapes
            run.continue_as(run.experiment)
            run.loop.change((), replaced)
        self._start = run.snapshot() if agent.same_noise else None
        self.decided: dict[str, bool | None] = {}

    @property
    def observation_space(self) -> spaces.Dict:
        """The observations."""
        return spaces.Dict({name: one.space for name, one in self.observed.items()})

    @property
    def action_space(self) -> spaces.Dict:
        """The actions."""
        return spaces.Dict({name: one.space for name, one in self.acted.items()})

    def begin(self, draw: Callable[[], int]) -> None:
        """Begin an episode.

        Args:
            draw: returns the seed of its noise.
        """
        if self._start is not None:
            self.run.restore(self._start)
        else:
            self.run.loop.reset(seed=draw())
        self.decided = dict.fromkeys(self.run.experiment.criteria)

    def judge(self, seen: dict[str, Any]) -> tuple[float, bool, bool]:
        """Return the reward of the last step, and whether the episode is terminated and truncated.

        Raises:
            ExperimentError: the reward is not a finite number.
        """
        run, agent = self.run, self._agent
        newly = self._newly_decided() if self.decided else []
        reward = float(sum(newly) - sum(not met for met in newly))
        terminated = bool(self.decided) and None not in self.decided.values()
        if agent.reward is not None:
            given = agent.reward(run, seen)
            reward = float(given) if np.ndim(given) == 0 and isinstance(given, _NUMBERS) else nan
            if not isfinite(reward):
                raise ExperimentError(f"the reward at {run.now_s:g} s is {given!r:.60}, not a finite number")
        if agent.terminate is not None:
            ends = agent.terminate(run, seen)
            if np.size(ends) != 1:
                raise ExperimentError(
                    f"terminate returned {ends!r:.60}, not true or false; see .any() and .all()"
                )
            terminated = bool(ends)
        return reward, terminated, run.loop.now_ns >= run.experiment.duration

    def _newly_decided(self) -> list[bool]:
        outcomes = self.run.passed()
        if outcomes == self.decided:
            return []
        newly = [met for name, met in outcomes.items() if met is not None and self.decided.get(name) is None]
        self.decided = outcomes
        return newly


_NUMBERS = (Real, np.ndarray, np.generic)


def _publishes(function: TransferFunction, acted: Mapping[str, Any]) -> bool:
    return any(published.name in acted for published in function.published)
