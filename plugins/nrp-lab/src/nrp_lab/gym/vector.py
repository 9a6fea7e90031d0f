"""Many copies of an experiment as one vector environment of Gymnasium."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from nrp_core.brain import BoolArray, FloatArray
from nrp_core.dsl import MapReward
from nrp_core.errors import ExperimentError, LifecycleError, SimulationError, did_you_mean
from nrp_core.experiment import Run
from nrp_core.running import open_run
from nrp_core.utilities import checks_arguments
from nrp_core.world.batch import threads_for
from nrp_lab.copies import calls_text, python_calls
from nrp_lab.gym.agent_run import Agent, AgentRun, Reward, Terminate, bounds_by_name, warn_of_findings
from nrp_lab.gym.env import CLOSED, NOT_BEGUN
from nrp_lab.gym.spaces import Actions, rows_of
from nrp_lab.side_by_side import SideBySide

_logger = logging.getLogger(__name__)


def mode_of(given: str | AutoresetMode) -> AutoresetMode:
    """Return an autoreset mode by its value.

    Raises:
        ExperimentError: the mode does not exist.
    """
    values = [mode.value for mode in AutoresetMode]
    if isinstance(given, AutoresetMode):
        return given
    if given not in values:
        raise ExperimentError(
            f"autoreset_mode is one of {', '.join(values)}, not {given!r}{did_you_mean(str(given), values)}"
        )
    return AutoresetMode(given)


def require_number(name: str, given: Any, least: int) -> None:
    """Refuse a number of copies or threads that is not a whole number, or too low.

    Raises:
        ExperimentError: the number is not valid.
    """
    if not isinstance(given, int | np.integer) or isinstance(given, bool) or given < least:
        raise ExperimentError(f"{name} is a whole number from {least} on, not {given!r}")


def seeds_of(seed: int | Sequence[int | None] | None, copies: int) -> list[int | None]:
    """Return the seed of each copy; None: the copy continues the sequence of its last seed.

    Raises:
        ExperimentError: the numbers of seeds and copies differ.
    """
    if seed is None:
        return [None] * copies
    if isinstance(seed, int | np.integer):
        return [int(seed) + number for number in range(copies)]
    if len(seed) != copies:
        raise ExperimentError(f"{len(seed)} seeds for {copies} copies")
    return [None if one is None else int(one) for one in seed]


def masked(options: dict[str, Any] | None, copies: int) -> list[int]:
    """Return the numbers of the copies to reset: all, or those in ``options["reset_mask"]``.

    Raises:
        ExperimentError: the mask is not an array of a truth value for each copy, or all are False.
    """
    if options is None or "reset_mask" not in options:
        return list(range(copies))
    mask = options["reset_mask"]
    if (
        not isinstance(mask, np.ndarray)
        or mask.shape != (copies,)
        or mask.dtype != np.bool_
        or not mask.any()
    ):
        raise ExperimentError(
            f"reset_mask is an array of {copies} truth values, at least one of them True, not {mask!r:.80}"
        )
    numbers: list[int] = np.flatnonzero(mask).tolist()
    return numbers


def require_going(over: BoolArray, mode: AutoresetMode) -> None:
    """Refuse a step of copies at their end if they are not reset by it.

    Raises:
        LifecycleError: a copy is at its end.
    """
    if mode is AutoresetMode.DISABLED and over.any():
        numbers = ", ".join(map(str, np.flatnonzero(over)))
        mask = 'options={"reset_mask": ...}'
        raise LifecycleError(f"the episodes of these copies are over: {numbers}; reset them with {mask}")


Infos = dict[str, Any]
Failures = dict[int, Exception]
"""The errors of copies by their numbers."""


def infos_of(copies: Sequence[AgentRun], chosen: Sequence[int]) -> Infos:
    """Return time and criteria of some copies after a step; empty without copies.

    Whether a criterion is met is True, False or None, so these arrays have the type ``object``.
    """
    if not len(chosen):
        return {}
    infos = times_of(copies, chosen)
    criteria: Infos = {}
    for name in copies[chosen[0]].decided:
        met = np.full(len(copies), None, object)
        for number in chosen:
            met[number] = copies[number].decided[name]
        criteria |= {name: met, f"_{name}": infos["_t_s"].copy()}
    return infos | {"criteria": criteria, "_criteria": infos["_t_s"].copy()}


def times_of(copies: Sequence[AgentRun], chosen: Sequence[int], infos: Infos | None = None) -> Infos:
    """Return the times of some copies, s, added to those in ``infos``."""
    infos = {} if infos is None else infos
    times = infos.setdefault("t_s", np.zeros(len(copies)))
    mask = infos.setdefault("_t_s", np.zeros(len(copies), np.bool_))
    for number in chosen:
        times[number], mask[number] = copies[number].run.now_s, True
    return infos


def final_infos(copies: Sequence[AgentRun], ended: Sequence[int], seen: Any) -> Infos:
    """Return the last observations and infos of copies that are reset in the step of their end."""
    mask = np.zeros(len(copies), np.bool_)
    mask[ended] = True
    last = np.full(len(copies), None, object)
    for number in ended:
        if isinstance(seen, dict):
            last[number] = {name: rows[number].copy() for name, rows in seen.items()}
        else:
            last[number] = seen[number].copy()
    found = {"final_obs": last, "final_info": infos_of(copies, ended)}
    return found | {f"_{name}": mask.copy() for name in found}


def joined(parts: Sequence[tuple[int, Infos]]) -> Infos:
    """Return the infos of several groups of copies as one.

    Args:
        parts: the number of copies of each group and its infos; entries that a group lacks are masked.
    """
    found: Infos = {}
    for name in dict.fromkeys(name for _, infos in parts for name in infos):
        example = next(infos[name] for _, infos in parts if name in infos)
        if isinstance(example, dict):
            found[name] = joined([(size, infos.get(name, {})) for size, infos in parts])
        else:
            nothing = None if example.dtype == np.dtype(object) else 0
            found[name] = np.concatenate(
                [infos.get(name, np.full(size, nothing, example.dtype)) for size, infos in parts]
            )
    return found


class NrpVectorEnv(VectorEnv[Any, Any, Any]):
    """Copies of an experiment in one process, stepped together.

    Each copy is, bit for bit, the :class:`~nrp_lab.gym.env.NrpEnv` with its seed. Their brains and worlds
    advance on threads, and share what never changes: the network, the scene and the compiled model. Each
    observation of all copies is one array. Values, resets and ``infos`` are those of Gymnasium's
    ``SyncVectorEnv``. The experiment's pace is ignored.

    If a copy fails, as when its physics diverges or its reward raises an error, the others have taken the
    step and their ends are known nevertheless; the error names the copy, which can be reset with
    ``options={"reset_mask": ...}``.

    Args:
        experiment, overrides, observe, act, reward, terminate, steps, same_noise, reward_to, flat: as for a
            single environment; ``reward`` and ``terminate`` are called for each copy.
        num_envs: number of copies.
        max_episode_steps: number of steps after which an episode is truncated, as Gymnasium passes it on for
            registered environments; by default, or if it is -1, only the experiment's end truncates.
        autoreset_mode: ``NextStep``, ``SameStep`` or ``Disabled``, as Gymnasium defines them.
        threads: number of threads that advance the copies; 0: one for each processor, if the engine
            allows it.
        render_mode: must be None; render a single environment instead.

    Attributes:
        runs: the runs of the copies; they stay open until :meth:`close`.
        first_number: the number of the first copy in errors.

    Raises:
        ExperimentError: the experiment, an observation, an action or a number is not valid.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012  as declared there
    first_number = 0

    @checks_arguments("num_envs", "max_episode_steps", "steps", "threads", "autoreset_mode")
    def __init__(
        self,
        experiment: str | Path,
        overrides: Sequence[str] = (),
        *,
        num_envs: int,
        observe: Sequence[str],
        act: Sequence[str] | Mapping[str, Any] = (),
        reward: Reward | None = None,
        terminate: Terminate | None = None,
        steps: int = 1,
        same_noise: bool = False,
        reward_to: MapReward | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        threads: int = 0,
        render_mode: str | None = None,
        flat: bool = False,
    ) -> None:
        require_number("num_envs", num_envs, 1)
        require_number("threads", threads, 0)
        if max_episode_steps == -1:  # Gymnasium's word for no limit
            max_episode_steps = None
        elif max_episode_steps is not None:
            require_number("max_episode_steps", max_episode_steps, 1)
        if render_mode is not None:
            raise ExperimentError(
                f"copies have no render_mode ({render_mode!r}); render a single environment"
            )
        acted = bounds_by_name(act)
        agent = Agent(
            observe, acted, reward, terminate, steps, same_noise, reward_to, max_episode_steps, flat
        )
        self.autoreset_mode = mode_of(autoreset_mode)
        self._opened = ExitStack()
        try:
            self._open(open_run(experiment, overrides), agent, num_envs, threads)
        except BaseException:
            self._opened.close()
            raise
        self.num_envs, self._steps = num_envs, steps
        self._judges = reward is not None or terminate is not None
        first = self._copies[0]
        self.single_observation_space, self.single_action_space = first.observation_space, first.action_space
        self.observation_space: Any = batch_space(first.observation_space, num_envs)
        self.action_space: Any = batch_space(first.action_space, num_envs)
        period_ns = steps * self.runs[0].experiment.timestep
        self.metadata = {"render_fps": round(1e9 / period_ns), "autoreset_mode": self.autoreset_mode,
                         **type(self).metadata}  # fmt: skip
        self._random: list[Any] = [None] * num_envs
        self._has_begun = False
        self._rewards = np.zeros(num_envs)
        self._terminated, self._truncated = np.zeros(num_envs, np.bool_), np.zeros(num_envs, np.bool_)

    def _open(self, first: Run, agent: Agent, num_envs: int, threads: int) -> None:
        self._opened.enter_context(first)
        warn_of_findings(first, agent.act)
        others = [
            self._opened.enter_context(Run(first.experiment, beside=first)) for _ in range(num_envs - 1)
        ]
        self.runs, self._agent = (first, *others), agent
        like = AgentRun(first, agent)
        self._copies = (like, *(AgentRun(run, agent, like) for run in others))
        if calls := self.python_calls:
            _logger.info("%s", calls_text(calls))
        chosen = threads or threads_for([run.world for run in self.runs])
        self._together = self._opened.enter_context(SideBySide(min(chosen, num_envs)))

    @property
    def python_calls(self) -> list[str]:
        """The names of the Python functions that are called for each copy."""
        judging = [name for name in ("reward", "terminate") if callable(getattr(self._agent, name))]
        return [*python_calls(self.runs[0]), *judging]

    # -- as Gymnasium calls it

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode of every copy, or of those in a mask.

        Args:
            seed: of the first copy, to which the others add their numbers; or one for each copy.
            options: ``{"reset_mask": array}`` with a truth value for each copy.

        Raises:
            ExperimentError: it is closed, or a seed or the mask does not fit.
        """
        self._require_open()
        seeds, chosen = seeds_of(seed, self.num_envs), masked(options, self.num_envs)
        for number in chosen:
            if seeds[number] is not None:
                self._random[number], _ = np_random(seeds[number])
        self._begin(chosen)
        self._has_begun = True
        return self.seen_now(), times_of(self._copies, chosen)

    def step(self, actions: Any) -> tuple[Any, FloatArray, BoolArray, BoolArray, Infos]:
        """Act, take the steps and observe; reset finished copies by the autoreset mode."""
        return self.step_rows(rows_of(actions, self.action_space))

    def step_rows(self, rows: FloatArray) -> tuple[Any, FloatArray, BoolArray, BoolArray, Infos]:
        """Do the same with actions as Gymnasium flattens them, a row for each copy."""
        self._require_open()
        if not self._has_begun:
            raise ExperimentError(NOT_BEGUN)
        over = self._terminated | self._truncated
        require_going(over, self.autoreset_mode)
        beginning, stepped = np.flatnonzero(over).tolist(), np.flatnonzero(~over).tolist()
        if stepped and rows.size:
            Actions.apply_all([self._copies[number].actions for number in stepped], rows[stepped])
        failed = self._advance(stepped)
        self._begin(beginning)
        seen, parts = self._observe(failed)
        self._judge([number for number in stepped if number not in failed], parts, failed)
        self._raise(failed)
        rewards = self._rewards.copy()
        terminated, truncated = self._terminated.copy(), self._truncated.copy()
        ended: list[int] = []
        if self.autoreset_mode is AutoresetMode.SAME_STEP:
            ended = np.flatnonzero(terminated | truncated).tolist()
        infos = infos_of(self._copies, [number for number in stepped if number not in ended])
        if ended:
            infos |= final_infos(self._copies, ended, seen)
            self._begin(ended)
            seen = self.seen_now()
        infos = times_of(self._copies, [*beginning, *ended], infos)
        return seen, rewards, terminated, truncated, infos

    def close_extras(self, **_: Any) -> None:
        """Release the engines of all copies."""
        self._opened.close()

    def _require_open(self) -> None:
        if self.closed:
            raise ExperimentError(CLOSED)

    # -- the parts of a step

    def _advance(self, stepped: Sequence[int]) -> Failures:
        """Take the steps of some copies, and return the errors of those that failed."""
        failed: Failures = {}
        for _ in range(self._steps):
            going = [number for number in stepped if number not in failed]
            errors = self._together.step([self.runs[number].loop for number in going])
            failed |= {going[place]: error for place, error in errors.items()}
        for number, error in failed.items():
            self.runs[number].error = error
        return failed

    def _raise(self, failed: Failures) -> None:
        """Raise the error of the first copy that failed; the others have taken the step and were judged.

        Raises:
            SimulationError: a copy failed.
        """
        for number, error in sorted(failed.items())[:1]:
            rest = f" (and {len(failed) - 1} more)" if len(failed) > 1 else ""
            t_ns = self.runs[number].loop.now_ns
            raise SimulationError(f"copy {self.first_number + number}{rest}: {error}", t_ns=t_ns) from error

    def _begin(self, chosen: Iterable[int]) -> None:
        """Begin an episode of some copies."""
        for number in chosen:
            self._copies[number].begin(partial(self._draw, number))
            self._rewards[number], self._terminated[number], self._truncated[number] = 0.0, False, False

    def _draw(self, number: int) -> int:
        """Return the seed of the next episode of a copy, from its own sequence as in a single environment."""
        if self._random[number] is None:
            self._random[number], _ = np_random()
        return int(self._random[number].integers(2**31))

    def seen_now(self) -> Any:
        """Return new arrays, or one, with the observations of all copies, a row for each.

        Raises:
            SimulationError: a copy cannot be observed.
        """
        failed: Failures = {}
        seen, _ = self._observe(failed)
        self._raise(failed)
        return seen

    def _observe(self, failed: Failures) -> tuple[Any, dict[str, Any]]:
        """Return the observations of all copies as they are returned and by name.

        Args:
            failed: gets the errors of copies that cannot be observed.
        """
        seen: Any
        layout, space = self._copies[0].layout, self.observation_space
        if layout is None:
            parts = seen = {name: np.empty(one.shape, one.dtype) for name, one in space.spaces.items()}
        else:
            parts = layout.views(seen := np.empty(space.shape, space.dtype))
        for name, rows in parts.items():
            observed = [copy.observed[name] for copy in self._copies]
            try:
                observed[0].read_all(observed, rows)
            except Exception:  # noqa: BLE001 - one copy's; it is found below
                for number, one in enumerate(observed):
                    try:
                        one.read_all([one], rows[number : number + 1])
                    except Exception as error:  # noqa: BLE001 - raised when the others are judged
                        failed.setdefault(number, error)
        return seen, parts

    def _judge(self, stepped: Iterable[int], seen: dict[str, Any], failed: Failures) -> None:
        """Set the rewards and ends of copies that were stepped, and add the errors of those that fail."""
        own: dict[str, Any] = {}
        if self._judges:  # an image keeps its type
            kinds = self._copies[0].observed
            seen = {name: rows.astype(kinds[name].space.dtype, copy=False) for name, rows in seen.items()}
        for number in stepped:
            if self._judges:
                own = {name: rows[number] for name, rows in seen.items()}
            now_ns = self.runs[number].loop.now_ns
            try:
                judged = self._copies[number].judge(own, now_ns)
            except Exception as error:  # noqa: BLE001 - of the user's function; raised when all are judged
                failed[number] = error
            else:
                self._rewards[number], self._terminated[number], self._truncated[number] = judged
