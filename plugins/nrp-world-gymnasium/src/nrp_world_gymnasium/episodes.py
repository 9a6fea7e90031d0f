"""The episodes of an environment, in sequence."""

from __future__ import annotations

import pickle
from typing import Any

import gymnasium

from nrp_core.errors import SnapshotError


class Episodes:
    """An environment that is stepped with the last action.

    An episode that has ended is followed by the next one in the next step, as with Gymnasium's own
    ``AutoresetMode.NEXT_STEP``; that step ignores the action and has the reward 0.

    Args:
        env: the environment.
        seed: the seed of the first episode; the generator of the environment continues in later ones.
        holds: whether the environment instead keeps its state after the first episode.

    Attributes:
        env: the environment.
        first: the action after :meth:`begin`.
        action: the action of the next step.
        observation: the last observation.
        reward: the reward of the last step.
        total: the sum of rewards in the episode.
        number: the number of the episode, from 0.
        terminated, truncated: whether the last step ended the episode.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], seed: int, *, holds: bool) -> None:
        self.env = env
        self.first: Any = None
        self.reward = self.total = 0.0
        self.terminated = self.truncated = False
        self._holds = holds
        self.begin(seed)

    def begin(self, seed: int) -> None:
        """Begin the first episode."""
        self.observation, _ = self.env.reset(seed=seed)
        self._actions: list[Any] = []
        self.action = self.first
        self.number = 0
        self._forget_rewards()

    def step(self) -> None:
        """Take a step, or begin the next episode."""
        self._actions.append(self.action)
        if not (self.terminated or self.truncated):
            self.observation, reward, terminated, truncated, _ = self.env.step(self.action)
            self.reward, self.terminated, self.truncated = float(reward), bool(terminated), bool(truncated)
            self.total += self.reward
        elif not self._holds:
            self.observation, _ = self.env.reset()
            self.number += 1
            self._forget_rewards()

    def save(self) -> object:
        """Return the actions since the beginning; environments cannot save their state."""
        return self._actions, self.action, pickle.dumps(self.observation)

    def restore(self, seed: int, saved: Any) -> None:
        """Repeat the actions of :meth:`save`.

        Raises:
            SnapshotError: they lead to another observation.
        """
        actions, action, observation = saved
        self.begin(seed)
        for self.action in actions:
            self.step()
        self.action = action
        if pickle.dumps(self.observation) != observation:
            raise SnapshotError(
                "the environment is not deterministic: the same seed and actions led to another observation"
            )

    def _forget_rewards(self) -> None:
        self.reward = self.total = 0.0
        self.terminated = self.truncated = False
