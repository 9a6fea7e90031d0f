"""Copies of an experiment in several processes, as one vector environment of Gymnasium."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack, suppress
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.vector import VectorEnv
from gymnasium.vector.utils import CloudpickleWrapper, batch_space

from nrp_core.brain import BoolArray, FloatArray
from nrp_core.errors import SimulationError
from nrp_core.utilities import Worker
from nrp_lab.gym.spaces import rows_of
from nrp_lab.gym.vector import NrpVectorEnv, joined, masked, require_going, require_number, seeds_of


class NrpProcessesEnv(VectorEnv[Any, Any, Any]):
    """Copies of an experiment, divided among processes; each has an :class:`.NrpVectorEnv` with its share.

    Values are those of one process. Python code runs for as many copies at a time as there are processes;
    functions that share values share them within a process only. The copies' runs cannot be reached.

    Args:
        experiment, overrides, num_envs, settings: as for :class:`.NrpVectorEnv`; ``threads`` are those of
            each process, by default 1.
        processes: number of processes, at most one for each copy.

    Raises:
        ExperimentError: as for :class:`.NrpVectorEnv`.
        SimulationError: a process has ended.
    """

    def __init__(
        self,
        experiment: str | Path,
        overrides: Sequence[str] = (),
        *,
        num_envs: int,
        processes: int,
        **settings: Any,
    ) -> None:
        require_number("num_envs", num_envs, 1)
        require_number("processes", processes, 1)
        borders = np.linspace(0, num_envs, min(processes, num_envs) + 1).astype(int).tolist()
        self.num_envs = num_envs
        self._shares = [slice(first, end) for first, end in pairwise(borders)]
        self._sizes = [share.stop - share.start for share in self._shares]
        self._over = np.zeros(num_envs, np.bool_)
        with ExitStack() as opened:
            self._workers: list[Worker] = []
            for _ in self._shares:
                self._workers.append(worker := Worker())
                opened.callback(worker.end)
            make: Any = partial(NrpVectorEnv, experiment, overrides, **({"threads": 1} | settings))
            tasks = [
                (CloudpickleWrapper(partial(make, num_envs=size)), share.start)
                for size, share in zip(self._sizes, self._shares, strict=True)
            ]
            found = self._all(_open, tasks)
            seen, acted, self.metadata, _ = found[0]
            _warn(text for *_, texts in found for text in texts)
            self._opened = opened.pop_all()
        self.single_observation_space, self.single_action_space = seen, acted
        self.observation_space: Any = batch_space(seen, num_envs)
        self.action_space: Any = batch_space(acted, num_envs)
        self.autoreset_mode = self.metadata["autoreset_mode"]

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode of every copy, or of those in a mask; see :meth:`.NrpVectorEnv.reset`."""
        seeds, chosen = seeds_of(seed, self.num_envs), masked(options, self.num_envs)
        mask = np.zeros(self.num_envs, np.bool_)
        mask[chosen] = True
        self._over &= ~mask
        seen, infos = zip(
            *self._all(_reset, [(seeds[share], mask[share]) for share in self._shares]), strict=True
        )
        return _rows(seen), joined(list(zip(self._sizes, infos, strict=True)))

    def step(self, actions: Any) -> tuple[Any, FloatArray, BoolArray, BoolArray, dict[str, Any]]:
        """Act, take the steps and observe; see :meth:`.NrpVectorEnv.step`."""
        require_going(self._over, self.autoreset_mode)
        rows = rows_of(actions, self.action_space)
        stepped = self._all(_step, [rows[share] for share in self._shares])
        seen, rewards, terminated, truncated, infos = zip(*stepped, strict=True)
        ends = np.concatenate(terminated), np.concatenate(truncated)
        self._over = ends[0] | ends[1]
        together = joined(list(zip(self._sizes, infos, strict=True)))
        return _rows(seen), np.concatenate(rewards), *ends, together

    def close_extras(self, **_: Any) -> None:
        """End the processes."""
        self._opened.close()

    def _all(self, function: Callable[[Any], Any], tasks: Sequence[Any]) -> list[Any]:
        """Call a function for the task of each process and return the results; all end when one fails."""
        found, errors = [], []
        for worker, task in zip(self._workers, tasks, strict=True):
            with suppress(OSError):  # it has ended, which is noticed below
                worker.connection.send((function, task))
        for worker, share in zip(self._workers, self._shares, strict=True):
            try:
                value, error = worker.connection.recv()
            except (EOFError, OSError):
                copies = f"copies {share.start} to {share.stop - 1}"
                value, error = None, SimulationError(f"the process of {copies} has ended: {worker.end()}")
            found.append(value)
            errors += [] if error is None else [error]
        if errors:
            raise errors[0]
        return found


def make_vec(
    experiment: str | Path, overrides: Sequence[str] = (), *, processes: int = 1, **settings: Any
) -> NrpVectorEnv | NrpProcessesEnv:
    """Return a vector environment; the arguments are those of :class:`.NrpVectorEnv`.

    Args:
        experiment: as for a single environment.
        overrides: as for a single environment.
        processes: number of processes among which copies are divided; 1: this one.
        **settings: the arguments by name.

    Example::

        envs = make_vec(
            "slalom_pioneer",
            ["transfer_functions=[]", "criteria=null"],
            num_envs=64,
            observe=["motion:pioneer", "rate:feelers"],
            act={"/pioneer/cmd_vel": {"linear.x": (0, 1), "angular.z": (-2, 2)}},
        )
    """
    require_number("processes", processes, 1)
    if processes == 1:
        return NrpVectorEnv(experiment, overrides, **settings)
    return NrpProcessesEnv(experiment, overrides, processes=processes, **settings)


_WARNED: set[str] = set()
"""The warnings of processes that were repeated in this one."""


def _warn(texts: Iterable[str]) -> None:
    """Repeat the warnings of the processes, each text once."""
    for text in dict.fromkeys(texts):
        if text not in _WARNED:
            _WARNED.add(text)
            warnings.warn(text, stacklevel=4)


def _rows(parts: Sequence[Any]) -> Any:
    if not isinstance(parts[0], dict):
        return np.concatenate(parts)
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


# -- in the processes

_COPIES: list[NrpVectorEnv] = []
"""The copies of this process."""


def _open(task: tuple[Any, int]) -> tuple[Any, Any, dict[str, Any], list[str]]:
    make, first_number = task
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        copies: NrpVectorEnv = make()
    copies.first_number = first_number
    _COPIES[:] = [copies]
    messages = [str(one.message) for one in caught]
    return copies.single_observation_space, copies.single_action_space, copies.metadata, messages


def _reset(task: tuple[list[int | None], BoolArray]) -> tuple[Any, dict[str, Any]]:
    (copies,), (seeds, mask) = _COPIES, task
    return copies.reset(seed=seeds, options={"reset_mask": mask}) if mask.any() else (copies.seen_now(), {})


def _step(rows: FloatArray) -> tuple[Any, ...]:
    (copies,) = _COPIES
    return copies.step_rows(rows)
