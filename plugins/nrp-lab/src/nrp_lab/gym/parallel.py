"""Several agents in one run, which act at the same time, by the parallel interface of PettingZoo."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gymnasium.spaces import Dict
from gymnasium.utils.seeding import np_random

from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.running import open_run
from nrp_core.utilities import checks_arguments, require_extra
from nrp_lab.gym.agent_run import (
    Agent,
    AgentRun,
    bounds_by_name,
    require_named,
    warn_of_findings,
)
from nrp_lab.gym.env import CLOSED
from nrp_lab.gym.spaces import Actions

require_extra("pettingzoo", "nrp-lab[parallel]", "nrp_lab.gym.parallel")

from pettingzoo import ParallelEnv  # noqa: E402

_KEYS = ("observe", "act", "reward", "terminate")


class NrpParallelEnv(ParallelEnv):  # type: ignore[misc]
    """An experiment in which several agents act, for example one for each robot.

    Transfer functions, episodes and seeds are as in :class:`~nrp_lab.gym.env.NrpEnv`. An agent whose episode
    is terminated acts no more; its last commands hold. At the end of the experiment all are truncated.

    Args:
        experiment: as for :func:`nrp_core.run`.
        overrides: ``dotted.key=value``.
        agents: for each agent, by name, what :class:`~nrp_lab.gym.env.NrpEnv` takes as ``observe``, ``act``,
            ``reward`` and ``terminate``. The functions get the observation of the agent.
        steps: number of loop steps in each step of the environment.
        same_noise: whether all episodes have the noise of the experiment's seed.

    Attributes:
        run: the run; it stays open until :meth:`close`.

    Raises:
        ExperimentError: the experiment, an agent, an observation or an action is not valid, or two agents act
            on one topic or source.
    """

    metadata: dict[str, Any] = {"name": "nrp_parallel", "render_modes": []}  # noqa: RUF012  as declared there
    render_mode = None

    @checks_arguments("steps")
    def __init__(
        self,
        experiment: str | Path,
        overrides: Sequence[str] = (),
        *,
        agents: Mapping[str, Mapping[str, Any]],
        steps: int = 1,
        same_noise: bool = False,
    ) -> None:
        self._given = {name: _agent(name, given, steps, same_noise) for name, given in agents.items()}
        together = _together(self._given, steps, same_noise)
        self.run = open_run(experiment, overrides)
        try:
            warn_of_findings(self.run, together.act)
            self._agent_run = agent_run = AgentRun(self.run, together)
            for agent in self._given.values():
                require_named(self.run, agent)
        except BaseException:
            self.run.close()
            raise
        self._actions = {
            name: Actions(self.run, {one: agent_run.acted[one] for one in agent.act})
            for name, agent in self._given.items()
        }
        self.observation_spaces = {
            name: Dict({one: agent_run.observed[one].space for one in agent.observe})
            for name, agent in self._given.items()
        }
        self.action_spaces = {name: actions.space for name, actions in self._actions.items()}
        self.possible_agents, self.agents = [*self._given], list[str]()
        self._random, _ = np_random()
        self._refusal: str | None = "reset() comes before the first step()"
        self._period_ns = steps * self.run.experiment.timestep

    def observation_space(self, agent: str) -> Dict:
        """Return the observations of an agent."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Dict:
        """Return the actions of an agent."""
        return self.action_spaces[agent]

    def reset(
        self,
        seed: int | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin an episode of all agents; its noise follows from ``seed``, or from the last given seed.

        Raises:
            ExperimentError: the environment is closed.
        """
        if self._refusal == CLOSED:
            raise ExperimentError(CLOSED)
        if seed is not None:
            self._random, _ = np_random(seed)
        self._refusal, self.agents = None, [*self.possible_agents]
        self._agent_run.begin(lambda: int(self._random.integers(2**31)))
        return self._observations(), {name: {"t_s": 0.0} for name in self.agents}

    def step(
        self, actions: Mapping[str, Mapping[str, Any]]
    ) -> tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Let all agents act, take the steps, and observe.

        Raises:
            ExperimentError: the action of an agent is missing, or not valid.
        """
        if self._refusal is not None:
            raise ExperimentError(self._refusal)
        for name in self.agents:
            if name not in actions:
                raise ExperimentError(f"the action of the agent '{name}' is missing")
            self._actions[name].apply(actions[name])
        run, agents = self.run, self.agents
        if agents:
            run.run_until_ns(run.loop.now_ns + self._period_ns)
        observations, now_ns = self._observations(), run.loop.now_ns
        decided = self._agent_run.decide()
        judged = {
            name: self._agent_run.rate(self._given[name], observations[name], *decided) for name in agents
        }
        terminated = {name: ends for name, (_, ends) in judged.items()}
        truncated = dict.fromkeys(agents, now_ns >= run.experiment.duration)
        self.agents = [name for name in agents if not (terminated[name] or truncated[name])]
        info = {"t_s": seconds(now_ns), "criteria": dict(self._agent_run.decided)}
        rewards = {name: reward for name, (reward, _) in judged.items()}
        return observations, rewards, terminated, truncated, {name: dict(info) for name in agents}

    def render(self) -> None:
        """Return nothing: the cockpit shows a run."""

    def close(self) -> None:
        """Release both engines."""
        self._refusal = CLOSED
        self.run.close()

    def _observations(self) -> dict[str, dict[str, Any]]:
        seen = {name: one.read() for name, one in self._agent_run.observed.items()}
        return {name: {one: seen[one] for one in self._given[name].observe} for name in self.agents}


def _agent(name: str, given: Mapping[str, Any], steps: int, same_noise: bool) -> Agent:
    """Return an agent.

    Raises:
        ExperimentError: it has an unknown key, or a value that is not valid.
    """
    for key in given:
        if key not in _KEYS:
            raise ExperimentError(f"the agent '{name}' has no '{key}'{did_you_mean(key, _KEYS)}")
    act = bounds_by_name(given.get("act", ()))
    reward, terminate = given.get("reward"), given.get("terminate")
    return Agent(given.get("observe", ()), act, reward, terminate, steps, same_noise)


def _together(agents: Mapping[str, Agent], steps: int, same_noise: bool) -> Agent:
    """Return one agent that observes and sets what all of them do.

    Raises:
        ExperimentError: two of them set the same.
    """
    act: dict[str, Any] = {}
    for name, agent in agents.items():
        for one, bounds in agent.act.items():
            if one in act:
                raise ExperimentError(f"the agent '{name}' acts on '{one}' as another agent does")
            act[one] = bounds
    observe = dict.fromkeys(one for agent in agents.values() for one in agent.observe)
    return Agent([*observe], act, None, None, steps, same_noise)
