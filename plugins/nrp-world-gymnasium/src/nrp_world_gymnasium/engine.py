"""An environment of Gymnasium as the engine of a world."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import DependencyNotInstalled

from nrp_core.clock import milliseconds, seconds
from nrp_core.errors import (
    BackendLoadError,
    CapabilityError,
    DivergedError,
    ExperimentError,
)
from nrp_core.world import BodyVelocity, Code, Engine, Model, Part, Scene, TopicInfo, WorldCapabilities
from nrp_world_gymnasium.episodes import Episodes
from nrp_world_gymnasium.options import AtEnd, GymnasiumOptions
from nrp_world_gymnasium.part import EnvironmentPart

_STEP_NAMES = ("dt", "tau")
"""Attributes of environments with the simulated time of a step, s: MuJoCo's and Pendulum's; CartPole's."""


class GymnasiumEngine(Engine):
    """One environment, stepped at a fixed rate with the last action.

    Args:
        scene: an empty scene.
        capabilities: the capabilities of the backend.
        seed: the seed of the first episode; the generator of the environment continues in later ones.
        options: the options of the experiment.

    Attributes:
        episodes: the environment and its state.

    Raises:
        CapabilityError: the scene has models, or a space has values that are not messages.
        ExperimentError: the environment does not exist, or it refuses its arguments.
        BackendLoadError: the environment needs a package that is not installed.
    """

    def __init__(
        self, scene: Scene, capabilities: WorldCapabilities, *, seed: int, options: GymnasiumOptions
    ) -> None:
        identity = f"gymnasium:{options.env},arguments {options.arguments},{options.at_end}"
        super().__init__(scene, capabilities, seed=seed, identity=identity)
        if scene.models:
            raise CapabilityError(
                f"the environment '{options.env}' has its own bodies, so it cannot contain "
                f"'{scene.models[0].name}': remove 'scene' and 'robots' from 'world'"
            )
        env = _made(options)
        try:
            self.episodes = Episodes(env, seed, holds=options.at_end is AtEnd.HOLD)
            self._part = EnvironmentPart(self.episodes, options)
        except BaseException:
            env.close()
            raise
        self._compare_steps(env, options)

    @property
    def topics(self) -> Sequence[TopicInfo]:
        """The topics of the environment."""
        return self._part.topics

    def parts(self, usual: Sequence[Part], model: Model | None) -> Sequence[Part]:
        """Return the usual parts of the world, and that of the environment."""
        return [*usual, self._part] if model is None else usual

    def check_state(self, t_ns: int) -> None:
        """Refuse an observation or a reward that is not a number; an infinite one may be intended."""
        seen = [each for each in _arrays(self.episodes.observation) if each.dtype.kind == "f"]
        if any(np.isnan(each).any() for each in (self.episodes.reward, *seen)):
            raise DivergedError("the environment returned a value that is not a number", t_ns=t_ns)

    def _compare_steps(self, env: gymnasium.Env[Any, Any], options: GymnasiumOptions) -> None:
        for name in _STEP_NAMES:
            step_s = getattr(env.unwrapped, name, None)
            if isinstance(step_s, float) and not np.isclose(step_s, seconds(options.timestep)):
                self.warnings.add(
                    Code.NRP372,
                    f"a step of '{options.env}' simulates {1000 * step_s:g} ms, but the option 'timestep' is "
                    f"{milliseconds(options.timestep):g} ms",
                )

    # -- required by the interface

    def _do_advance(self, steps: int) -> None:
        for _ in range(steps):
            self.episodes.step()

    def _do_reset(self, seed: int) -> None:
        self.episodes.begin(seed)

    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        raise self.lacks("has no drives")

    # -- optional

    def _do_save(self) -> object:
        return self.seed, self.episodes.save()

    def _do_restore(self, saved: Any) -> None:
        seed, episodes = saved
        self.episodes.restore(seed, episodes)

    def _do_close(self) -> None:
        self.episodes.env.close()


def _made(options: GymnasiumOptions) -> gymnasium.Env[Any, Any]:
    """Return the environment of an experiment."""
    render = {"render_mode": "rgb_array"} if options.image else {}
    try:
        return gymnasium.make(options.env, **{**render, **options.arguments})
    except DependencyNotInstalled as error:
        raise BackendLoadError(f"the environment '{options.env}' needs more packages: {error}") from error
    except Exception as error:  # whatever the constructor of an environment raises
        raise ExperimentError(f"the environment '{options.env}' cannot be made: {error}") from error


def _arrays(value: Any) -> list[Any]:
    """Return the arrays and numbers of an observation."""
    match value:
        case dict():
            return [each for part in value.values() for each in _arrays(part)]
        case tuple():
            return [each for part in value for each in _arrays(part)]
        case str():
            return []
    return [np.asarray(value)]
