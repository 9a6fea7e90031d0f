"""An experiment as an environment of Gymnasium, and the environments that ship."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from nrp_core.clock import seconds
from nrp_core.dsl import MapReward
from nrp_core.errors import ExperimentError
from nrp_core.experiment import Run
from nrp_core.running import open_run
from nrp_core.utilities import checks_arguments
from nrp_lab.gym.agent_run import (
    Agent,
    AgentRun,
    Reward,
    Terminate,
    bounds_by_name,
    warn_of_findings,
)
from nrp_lab.gym.spaces import Actions, rows_of, values_of

_LEGS = [f"{row}_{side}" for row in ("front", "middle", "rear") for side in ("left", "right")]
_SPEEDS = {"linear.x": (-1.0, 1.0), "angular.z": (-2.0, 2.0)}

SHIPPED: dict[str, dict[str, Any]] = {
    "nrp/BraitenbergHusky-v0": {
        "experiment": "braitenberg_husky",
        "overrides": ("world.options.image_scale=0.25",),
        "observe": ("/husky/camera",),
        "act": {"/husky/cmd_vel": _SPEEDS},
    },
    "nrp/SlalomPioneer-v0": {
        "experiment": "slalom_pioneer",
        "observe": ("/pioneer/scan", "rate:feelers"),
        "act": {"/pioneer/cmd_vel": _SPEEDS},
    },
    "nrp/FollowingHead-v0": {
        "experiment": "following_head",
        "overrides": ("world.options.image_scale=0.25",),
        "observe": ("/pan_tilt/eye/image_raw", "/pan_tilt/joint_states"),
        "act": {f"/pan_tilt/{joint}/cmd_pos": {"data": (-1.0, 1.0)} for joint in ("pan", "tilt")},
    },
    "nrp/WalkingHexapod-v0": {
        "experiment": "walking_hexapod",
        "observe": ("/hexapod/joint_states",),
        "act": {
            f"/hexapod/{leg}_{joint}/cmd_pos": {"data": (-1.0, 1.0)}
            for leg in _LEGS
            for joint in ("alpha", "beta", "gamma", "delta")
        },
    },
    "nrp/ReachingArm-v0": {
        "experiment": "reaching_arm",
        "observe": ("/arm/joint_states", "/arm/miss"),
        "act": {f"/arm/{joint}/cmd_pos": {"data": (-2.0, 2.0)} for joint in ("shoulder", "elbow")},
    },
    "nrp/Fly-v0": {
        "experiment": "fly",
        "overrides": ("brain.parameters.cells=2500",),
        "observe": ("motion:fly", "/fly/drive"),
        "act": {f"source:{cell}": (0.0, 300.0, 15.0) for cell in ("DNp09_left", "DNp09_right", "MDN")},
    },
}
"""Arguments of :class:`~nrp_lab.gym.env.NrpEnv` by the id of the environment."""


def register_shipped() -> None:
    """Register the environments with Gymnasium, once."""
    for name, settings in SHIPPED.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                name,
                "nrp_lab.gym.env:NrpEnv",
                vector_entry_point="nrp_lab.gym.vector_processes:make_vec",
                kwargs=settings,
            )


CLOSED = "the environment is closed: make another one"
NOT_BEGUN = "reset() comes before the first step()"


class NrpEnv(gymnasium.Env[Any, Any]):
    """An experiment that an agent steps.

    Its transfer functions run as well, except those that publish on a topic that the agent acts on.

    An episode is a run of the experiment from time 0. Each has its own noise, which follows from the seed
    of :meth:`reset`; the network is always that of the experiment's seed. Plain global variables in a file
    of transfer functions keep their values between episodes; variables mapped with MapVariable do not.

    Args:
        experiment: as for :func:`nrp_core.run`.
        overrides: ``dotted.key=value``.
        observe: topics, of which the last message is observed, ``all:TOPIC`` for all messages since the last
            step, a row for each, ``rate:GROUP`` for the mean rate of neurons, Hz, ``motion:MODEL`` for
            position (m), orientation (quaternion x y z w), linear (m/s) and angular velocity (rad/s) of a
            model, and ``joints:MODEL`` for the positions, then the velocities of its joints. No other topic
            is subscribed.
        act: topics, or ``source:GROUP`` for the rate of a Poisson source. A mapping gives the bounds: of a
            topic ``{"linear.x": (0, 1)}``, of a source ``(lowest, highest, weight)``.
        reward: a function, or weights of observables of the experiment, ``{"moved": 1.0}``; by default the
            number of criteria met in the step, minus those missed in it.
        terminate: a function, or the name of an event; by default once every criterion is decided.
        steps: number of loop steps in each step of the environment.
        same_noise: whether all episodes have the noise of the experiment's seed; then a reset restores a
            snapshot.
        reward_to: the projection of the brain that learns from the rewards, as
            ``nrp.MapReward("reward", nrp.brain.projection("learned"), baseline=20)``. The reward of a step
            acts from its end on. Learned weights of all projections are kept from episode to episode; between
            two, the brain rests without input until the dopamine has decayed.
        render_mode: None or ``rgb_array``.
        flat: whether the observations are one array and the actions are one, in the order and with the type
            of Gymnasium's ``flatten_space``. ``reward`` and ``terminate`` get the observations by name.

    Attributes:
        run: the run; it stays open until :meth:`close`.

    Raises:
        ExperimentError: the experiment, an observation or an action is not valid.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 50}  # noqa: RUF012  as declared there

    @checks_arguments("steps")
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
        reward_to: MapReward | None = None,
        render_mode: str | None = None,
        flat: bool = False,
    ) -> None:
        if render_mode not in (None, "rgb_array"):
            raise ExperimentError(f"render_mode is None or 'rgb_array', not {render_mode!r}")
        acted = bounds_by_name(act)
        agent = Agent(observe, acted, reward, terminate, steps, same_noise, reward_to, flat=flat)
        self.render_mode = render_mode
        self.run = open_run(experiment, overrides)
        try:
            warn_of_findings(self.run, acted)
            self._camera = _open_camera(self.run) if render_mode else None
            self._agent_run = AgentRun(self.run, agent)
        except BaseException:
            self.run.close()
            raise
        self.observation_space: Any = self._agent_run.observation_space
        self.action_space: Any = self._agent_run.action_space
        self._reads = [(name, one.read) for name, one in self._agent_run.observed.items()]
        self._refusal: str | None = NOT_BEGUN
        self._is_over = False
        self._warned: set[str] = set()
        self._period_ns = steps * self.run.experiment.timestep
        self.metadata = {**self.metadata, "render_fps": round(1e9 / self._period_ns)}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; its noise follows from ``seed``, or from the last given seed.

        Raises:
            ExperimentError: the environment is closed.
        """
        if self._refusal == CLOSED:
            raise ExperimentError(CLOSED)
        super().reset(seed=seed)
        if options:
            self._warn_once(f"reset() takes no options: {options!r:.60} has no effect")
        self._refusal, self._is_over = None, False
        self._agent_run.begin(lambda: int(self.np_random.integers(2**31)))
        return self._returned(self._observation()), {"t_s": 0.0}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Act, take the steps, and observe; the episode is truncated at the end of the experiment."""
        if self._refusal is not None:
            raise ExperimentError(self._refusal)
        agent_run, run = self._agent_run, self.run
        if self._is_over:
            self._warn_once("step() after the end of an episode: reset() begins the next one")
        if agent_run.layout is None:
            agent_run.actions.apply(action)
        else:
            Actions.apply_all([agent_run.actions], rows_of(action, self.action_space)[np.newaxis])
        run.run_until_ns(run.loop.now_ns + self._period_ns)
        observation, now_ns = self._observation(), run.loop.now_ns
        reward, terminated, truncated = agent_run.judge(observation, now_ns)
        self._is_over = terminated or truncated
        info = {"t_s": seconds(now_ns), "criteria": dict(agent_run.decided)}
        return self._returned(observation), reward, terminated, truncated, info

    def render(self) -> Any:
        """Return the last image of a camera, shape ``(height, width, 3)``; black before the first."""
        if self._camera is None:
            return None
        latest = self._camera.latest
        return np.zeros((1, 1, 3), np.uint8) if latest is None else values_of(latest.message)[..., :3]

    def close(self) -> None:
        """Release both engines."""
        self._refusal = CLOSED
        self.run.close()

    def _warn_once(self, text: str) -> None:
        if text not in self._warned:
            self._warned.add(text)
            gymnasium.logger.warn(text)

    def _observation(self) -> dict[str, Any]:
        seen = {}
        for name, read in self._reads:  # in each step: no comprehension, which is one more call
            seen[name] = read()
        return seen

    def _returned(self, seen: dict[str, Any]) -> Any:
        layout = self._agent_run.layout
        return seen if layout is None else layout.flatten(seen)


def _open_camera(run: Run) -> Any:
    cameras = [name for name, info in run.world.topics.items() if info.type.__name__ == "Image"]
    if not cameras:
        raise ExperimentError("render_mode 'rgb_array' shows the image of a camera, but no robot has one")
    return run.world.subscribe(cameras[0])


def make_env(experiment: str | Path, overrides: Sequence[str] = (), **settings: Any) -> NrpEnv:
    """Return an environment; the arguments are those of :class:`NrpEnv`.

    Example::

        env = make_env(
            "slalom_pioneer",
            ["transfer_functions=[]", "criteria=null"],
            observe=["/pioneer/scan"],
            act={"/pioneer/cmd_vel": {"linear.x": (0, 1), "angular.z": (-2, 2)}},
            reward=lambda run, seen: float(seen["/pioneer/scan"].min() > 0.2),
        )
    """
    return NrpEnv(experiment, overrides, **settings)
