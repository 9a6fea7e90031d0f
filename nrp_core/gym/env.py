"""An experiment as an environment of Gymnasium."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Any, TypeAlias

import gymnasium
import numpy as np
from gymnasium import spaces

from nrp_core.clock import seconds
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.errors import ExperimentError
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run
from nrp_core.gym.acting import act_on
from nrp_core.gym.observing import observe, values_of

Reward: TypeAlias = Callable[[Run, dict[str, Any]], float]
"""Returns the reward of the last step, from the run and the observation by name."""
Terminate: TypeAlias = Callable[[Run, dict[str, Any]], bool]
"""Returns whether the episode is over."""


class NrpEnv(gymnasium.Env[Any, Any]):
    """An experiment that an agent steps.

    Its transfer functions run as well, except those that publish on a topic that the agent acts on.

    An episode is a run of the experiment from time 0. Each has its own noise, which follows from the seed
    of :meth:`reset`; the network is always that of the experiment's seed. Plain global variables in a file
    of transfer functions keep their values between episodes; variables mapped with MapVariable do not.

    Args:
        experiment: as for :func:`nrp_core.run`.
        overrides: ``dotted.key=value``.
        observe: topics, and ``rate:GROUP`` for the mean rate of neurons, Hz. No other topic is subscribed.
        act: topics, or ``source:GROUP`` for the rate of a Poisson source. A mapping gives the bounds: of a
            topic ``{"linear.x": (0, 1)}``, of a source ``(lowest, highest, weight)``.
        reward: by default the number of criteria met in the step, minus those missed in it.
        terminate: by default once every criterion is decided.
        steps: number of loop steps in each step of the environment.
        same_noise: whether all episodes have the noise of the experiment's seed; then a reset restores a
            snapshot.
        render_mode: None or ``rgb_array``.

    Attributes:
        run: the run; it stays open until :meth:`close`.

    Raises:
        ExperimentError: the experiment, an observation or an action is not valid.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 50}  # noqa: RUF012  as declared there

    def __init__(
        self,
        experiment: str | Path,
        overrides: Sequence[str] = (),
        *,
        observe: Sequence[str],
        act: Sequence[str] | Mapping[str, Any] = (),
        reward: Reward | None = None,
        terminate: Terminate | None = None,
        steps: int = 1,
        same_noise: bool = False,
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in (None, "rgb_array"):
            raise ExperimentError(f"render_mode is None or 'rgb_array', not {render_mode!r}")
        if not isinstance(steps, int) or steps < 1:
            raise ExperimentError(f"a step of an environment is at least 1 step of the loop, not {steps}")
        self.render_mode = render_mode
        self.run = Run(load_experiment(experiment, overrides))
        try:
            self._open(list(observe), act if isinstance(act, Mapping) else dict.fromkeys(act))
        except BaseException:
            self.run.close()
            raise
        self._reward, self._terminate = reward, terminate
        self._period_ns = steps * self.run.experiment.timestep
        self.metadata = {**self.metadata, "render_fps": round(1e9 / self._period_ns)}
        self._start = self.run.snapshot() if same_noise else None
        self._decided: dict[str, bool | None] = {}

    def _open(self, observed: list[str], acted: Mapping[str, Any]) -> None:
        if not observed:
            raise ExperimentError("an environment needs at least one observation: a topic, or 'rate:GROUP'")
        own = [function.name for function in self.run.loop.functions if _publishes(function, acted)]
        self.run.loop.change((), own)
        self._acted = act_on(self.run, acted)
        self._camera = self._open_camera() if self.render_mode else None
        self._observed = _observe(self.run, observed)
        self.observation_space = spaces.Dict({name: one.space for name, one in self._observed.items()})
        self.action_space = spaces.Dict({name: one.space for name, one in self._acted.items()})

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin an episode; its noise follows from ``seed``, or from the last given seed."""
        super().reset(seed=seed)
        if self._start is not None:
            self.run.restore(self._start)
        else:
            self.run.loop.reset(seed=int(self.np_random.integers(2**31)))
        self._decided = dict.fromkeys(self.run.outcomes())
        return self._observation(), {"t_s": 0.0}

    def step(self, action: Mapping[str, Any]) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Act, take the steps, and observe; the episode is truncated at the end of the experiment."""
        for name, acted in self._acted.items():
            acted.apply(np.asarray(action[name], np.float64))
        self.run.run_until(seconds(self.run.loop.now_ns + self._period_ns))
        observation = self._observation()
        newly = self._newly_decided()
        reward = float(sum(newly) - sum(not met for met in newly))
        terminated = bool(self._decided) and None not in self._decided.values()
        if self._reward is not None:
            reward = float(self._reward(self.run, observation))
            if not isfinite(reward):
                raise ExperimentError(f"the reward at {self.run.now_s:g} s is {reward}, not a finite number")
        if self._terminate is not None:
            terminated = bool(self._terminate(self.run, observation))
        truncated = self.run.loop.now_ns >= self.run.experiment.duration
        return (
            observation,
            reward,
            terminated,
            truncated,
            {"t_s": self.run.now_s, "criteria": dict(self._decided)},
        )

    def render(self) -> Any:
        """Return the last image of a camera, shape ``(height, width, 3)``; black before the first."""
        if self._camera is None:
            return None
        latest = self._camera.latest
        return np.zeros((1, 1, 3), np.uint8) if latest is None else values_of(latest.message)[..., :3]

    def close(self) -> None:
        """Release both engines."""
        self.run.close()

    def _observation(self) -> dict[str, Any]:
        return {name: one.read() for name, one in self._observed.items()}

    def _newly_decided(self) -> list[bool]:
        outcomes = {name: verdict.passed for name, verdict in self.run.outcomes().items()}
        newly = [met for name, met in outcomes.items() if met is not None and self._decided.get(name) is None]
        self._decided = outcomes
        return newly

    def _open_camera(self) -> Any:
        cameras = [name for name, info in self.run.world.topics.items() if info.type.__name__ == "Image"]
        if not cameras:
            raise ExperimentError("render_mode 'rgb_array' shows the image of a camera, but no robot has one")
        return self.run.world.subscribe(cameras[0])


_observe = observe  # an argument has its name


def _publishes(function: TransferFunction, acted: Mapping[str, Any]) -> bool:
    return any(published.name in acted for published in function.published)


def make_env(experiment: str | Path, overrides: Sequence[str] = (), **settings: Any) -> NrpEnv:
    """Return an environment; the arguments are those of :class:`NrpEnv`.

    Example::

        env = make_env(
            "slalom_pioneer",
            ["transfer_functions=[]"],
            observe=["/pioneer/scan"],
            act={"/pioneer/cmd_vel": {"linear.x": (0, 1), "angular.z": (-2, 2)}},
            reward=lambda run, seen: float(seen["/pioneer/scan"].min() > 0.2),
        )
    """
    return NrpEnv(experiment, overrides, **settings)
