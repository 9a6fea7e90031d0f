"""A run with an agent: its actions, observations, rewards and episodes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from math import isfinite, nan
from numbers import Real
from typing import Any, TypeAlias

import gymnasium
import numpy as np
from gymnasium import spaces

from nrp_core.checks.warnings import announcement
from nrp_core.clock import seconds
from nrp_core.dsl import MapReward, TransferFunction
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import Run
from nrp_core.utilities import takes
from nrp_lab.gym.brain_reward import BrainReward
from nrp_lab.gym.spaces import SOURCE, Actions, Layout, Observed, act_on, observe

Reward: TypeAlias = Callable[[Run, dict[str, Any]], float] | Mapping[str, float]
"""Returns the reward of the last step from the run and the observation by name; or weights of observables."""
Terminate: TypeAlias = Callable[[Run, dict[str, Any]], bool] | str
"""Returns whether the episode is over; or an event of the experiment, which ends it."""


@dataclass(frozen=True)
class Agent:
    """What an agent observes, sets and is rewarded for; see :class:`~nrp_lab.gym.env.NrpEnv`.

    Raises:
        ExperimentError: nothing is observed, or ``steps`` is not a number of steps.
    """

    observe: Sequence[str]
    act: Mapping[str, Any]
    reward: Reward | None
    terminate: Terminate | None
    steps: int
    same_noise: bool
    reward_to: MapReward | None = None
    max_episode_steps: int | None = None
    flat: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.steps, int) or self.steps < 1:
            raise ExperimentError(
                "a step of an environment is a whole number of steps of the loop, at least 1, not "
                f"{self.steps}"
            )
        if not self.observe:
            raise ExperimentError(
                "an environment needs a list of at least one observation: a topic, or 'rate:GROUP', not "
                f"{self.observe!r:.60}"
            )
        for name, given in (("reward", self.reward), ("terminate", self.terminate)):
            if not isinstance(given, (Mapping, str)) and given is not None and not takes(given, 2):
                shown = f"one that takes {signature(given)}" if callable(given) else f"{given!r:.60}"
                raise ExperimentError(f"{name} is a function of the run and the observation, not {shown}")


def bounds_by_name(act: Sequence[str] | Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the actions with their bounds; None: those of the topic."""
    return act if isinstance(act, Mapping) else dict.fromkeys(act)


def warn_of_findings(run: Run, act: Mapping[str, Any]) -> None:
    """Warn of missing parts and probable mistakes in the experiment of a run, once in a process.

    Args:
        run: the run, at time 0.
        act: the actions by name; checks accept that nothing else publishes or drives their targets.
    """
    acted = [f"'{name.removeprefix(SOURCE)}'" for name in act]
    doubted = [one for one in run.problems if not any(name in one.message for name in acted)]
    if text := announcement(run.experiment.name, doubted):
        gymnasium.logger.warn(text.replace("%", "%%"))


class AgentRun:
    """A run that an agent steps; each episode begins at its time 0.

    Args:
        run: the run, at time 0.
        agent: the agent.
        like: the same in another run of the experiment, which has the shapes of observations.

    Attributes:
        acted, observed: the actions and observations by their names.
        actions: the actions together.
        layout: where the observations lie in one array; None: each has its own.
        observation_space, action_space: the spaces of the agent.
        decided: the criteria, and whether they are met; None: undecided.
    """

    def __init__(self, run: Run, agent: Agent, like: AgentRun | None = None) -> None:
        self.run, self._agent = run, agent
        require_named(run, agent)
        lasts, step = run.experiment.duration, agent.steps * run.experiment.timestep
        limit = agent.max_episode_steps
        self._ends_ns = lasts if limit is None else min(lasts, limit * step)
        if step > lasts:
            raise ExperimentError(
                f"a step of an environment of {agent.steps} steps of the loop takes {seconds(step):g} s, and "
                f"an episode {seconds(lasts):g} s"
            )
        replaced = [function.name for function in run.loop.functions if _publishes(function, agent.act)]
        run.loop.change((), replaced)
        self.acted = act_on(run, agent.act)
        self.actions = Actions(run, self.acted)
        self.observed: dict[str, Observed] = observe(
            run, agent.observe, None if like is None else like.observed, agent.steps
        )
        if (
            like is None and run.loop.functions
        ):  # their files may have kept values of the steps for the shapes
            run.continue_as(run.experiment)
            run.loop.change((), replaced)
        self._brain_reward = None if agent.reward_to is None else BrainReward(run, agent.reward_to)
        self._start = run.snapshot() if agent.same_noise else None
        self.decided: dict[str, bool | None] = {}
        judging = agent.reward, agent.terminate, agent.reward_to
        self._is_judged = bool(run.experiment.criteria) or any(one is not None for one in judging)
        seen = spaces.Dict({name: one.space for name, one in self.observed.items()})
        self.layout = Layout(seen) if agent.flat else None
        self.observation_space: spaces.Space[Any] = self.layout.space if self.layout else seen
        acted = self.actions.space
        self.action_space: spaces.Space[Any] = Layout(acted).space if agent.flat else acted

    def begin(self, draw: Callable[[], int]) -> None:
        """Begin an episode.

        Args:
            draw: returns the seed of its noise.
        """
        learned = {} if self._brain_reward is None else self._brain_reward.end_of_episode()
        if self._start is not None:
            self.run.restore(self._start)
        else:
            self.run.loop.reset(seed=draw())
        for label, weights in learned.items():
            self.run.brain.set_weights(label, weights)
        self.decided = dict.fromkeys(self.run.experiment.criteria)

    def judge(self, seen: dict[str, Any], now_ns: int) -> tuple[float, bool, bool]:
        """Return the reward of the last step, and whether the episode is terminated and truncated.

        Args:
            seen: the observation after it, for functions of the caller.
            now_ns: the time after it, ns.

        Raises:
            ExperimentError: the reward is not a finite number, or the end neither true nor false.
        """
        if not self._is_judged:
            return 0.0, False, now_ns >= self._ends_ns
        reward, terminated = self.rate(self._agent, seen, *self.decide())
        if self._brain_reward is not None:
            self._brain_reward.give(reward)
        return reward, terminated, now_ns >= self._ends_ns

    def decide(self) -> tuple[float, bool]:
        """Return the criteria met since the last call minus those missed, and whether all are decided."""
        outcomes, before = self.run.passed(), self.decided
        reward = 0.0
        if outcomes != before:
            newly = [met for name, met in outcomes.items() if met is not None and before.get(name) is None]
            reward = float(2 * sum(newly) - len(newly))
            self.decided = outcomes
        return reward, bool(outcomes) and None not in outcomes.values()

    def rate(self, agent: Agent, seen: dict[str, Any], reward: float, terminated: bool) -> tuple[float, bool]:
        """Return the reward of an agent for the last step, and whether its episode is terminated.

        Args:
            agent: the agent.
            seen: its observation after the step.
            reward: the reward of an agent without one of its own.
            terminated: the end of an agent without one of its own.

        Raises:
            ExperimentError: see :meth:`judge`.
        """
        run = self.run
        if agent.reward is not None:
            given = _rewards(run, agent.reward, seen)
            reward = float(given) if np.ndim(given) == 0 and isinstance(given, _NUMBERS) else nan
            if not isfinite(reward):
                raise ExperimentError(f"the reward at {run.now_s:g} s is {given!r:.60}, not a finite number")
        if agent.terminate is not None:
            ends = _ends(run, agent.terminate, seen)
            if np.size(ends) != 1 or not (ends == True or ends == False):  # noqa: E712  of NumPy's types too
                hint = "; see .any() and .all()" if np.size(ends) > 1 else ""
                raise ExperimentError(f"terminate returned {ends!r:.60}, not true or false{hint}")
            terminated = bool(ends)
        return reward, terminated


_NUMBERS = (Real, np.ndarray, np.generic)


def _rewards(run: Run, reward: Reward, seen: dict[str, Any]) -> Any:
    """Return a function's result, or a weighted sum of observables; one without a value counts as 0."""
    if not isinstance(reward, Mapping):
        return reward(run, seen)
    values = run.observables
    return float(sum(weight * (values[name] or 0.0) for name, weight in reward.items()))


def _ends(run: Run, terminate: Terminate, seen: dict[str, Any]) -> Any:
    """Return a function's result, or whether an event has happened."""
    return run.events[terminate] is not None if isinstance(terminate, str) else terminate(run, seen)


def require_named(run: Run, agent: Agent) -> None:
    """Refuse a reward of unknown observables, and an end at an unknown event.

    Raises:
        ExperimentError: the observable or event does not exist.
    """
    known = run.experiment.observables
    for name in agent.reward if isinstance(agent.reward, Mapping) else ():
        if name not in known:
            raise ExperimentError(f"reward: there is no observable '{name}'{did_you_mean(name, known)}")
    events = run.experiment.events
    if isinstance(agent.terminate, str) and agent.terminate not in events:
        hint = did_you_mean(agent.terminate, events)
        raise ExperimentError(f"terminate: there is no event '{agent.terminate}'{hint}")


def _publishes(function: TransferFunction, acted: Mapping[str, Any]) -> bool:
    return any(published.name in acted for published in function.published)
