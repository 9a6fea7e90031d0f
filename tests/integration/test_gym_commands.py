"""Commands on topics in many copies: bit for bit those of single environments, and without a message each."""

from collections.abc import Callable, Iterator
from contextlib import closing
from cProfile import Profile
from typing import Any

import numpy as np
import pytest

from nrp_core.errors import TopicError
from nrp_core.gym import NrpEnv, NrpVectorEnv, make_env, make_vec

COPIES = 3
AGENT: dict[str, Any] = {
    "observe": ["motion:husky"],
    "act": {"/husky/cmd_vel": {"linear.x": (-1, 1), "angular.z": (-2, 2)}},
}
OVERRIDES = ["transfer_functions=[]", "criteria=null", "events=null"]
COMMANDS = np.array(  # of each step: forward and turn of each copy; some stay, some turn back, some stop
    [
        [[0.5, 0.1], [0.0, 0.0], [-0.3, 2.0]],
        [[0.5, 0.1], [0.2, -1.0], [0.3, -2.0]],
        [[0.1, 0.0], [0.2, -1.0], [0.0, 0.0]],
        [[0.9, -0.5], [0.0, 0.0], [0.0, 0.7]],
    ]
)
MOST_CALLS = 165
"""Calls of functions, built-in ones included, in a step of one more copy; with a message for each: 186."""
MOST_CALLS_OF_RESET = 800
"""Of all functions in a reset by snapshot; 1992 where it paints every visual of the room again."""


@pytest.fixture(scope="module")
def copies() -> Iterator[NrpVectorEnv]:
    with closing(make_vec("braitenberg_husky", OVERRIDES, num_envs=COPIES, threads=1, **AGENT)) as envs:
        assert isinstance(envs, NrpVectorEnv)
        yield envs


@pytest.fixture(scope="module")
def single() -> Iterator[NrpEnv]:
    with closing(make_env("braitenberg_husky", OVERRIDES, **AGENT)) as env:
        yield env


def driven(env: Any, commands: Any) -> list[Any]:
    return [env.step({"/husky/cmd_vel": command})[0]["motion:husky"] for command in commands]


def test_commanded_copies_move_as_they_do_alone(copies: NrpVectorEnv, single: NrpEnv) -> None:
    copies.reset(seed=4)
    together = driven(copies, COMMANDS)
    for number in range(COPIES):
        single.reset(seed=4 + number)
        alone = driven(single, COMMANDS[:, number])
        assert np.array([rows[number] for rows in together]).tobytes() == np.array(alone).tobytes()
    assert np.ptp(together[-1][:, 0]) > 0.001


def test_a_command_after_a_restored_state_moves_copies_as_it_does_one(
    copies: NrpVectorEnv, single: NrpEnv
) -> None:
    """The first command after it counts as in force before, so no velocity jumps."""
    copies.reset(seed=4)
    single.reset(seed=4)
    for env in (copies, single):
        driven(env, COMMANDS[:2] if env is copies else COMMANDS[:2, 0])
    for run in (*copies.runs, single.run):
        run.restore(run.snapshot())
    together, alone = driven(copies, COMMANDS[2:]), driven(single, COMMANDS[2:, 0])
    assert np.array([rows[0] for rows in together]).tobytes() == np.array(alone).tobytes()


@pytest.mark.parametrize(("forward", "turn"), [(0.5, float("nan")), (float("inf"), 0.0)])
def test_a_command_that_is_no_number_is_refused_in_copies(
    copies: NrpVectorEnv, forward: float, turn: float
) -> None:
    copies.reset(seed=4)
    with pytest.raises(TopicError, match=r"nan|inf"):
        driven(copies, np.array([[[0.1, 0.0], [0.1, 0.0], [forward, turn]]]))


def calls_in(call: Callable[[], object]) -> int:
    """Return the number of calls of functions, those of built-in ones included.

    A hook in Python would be given the frames that Numba makes up for compiled functions, and would read and
    write their variables; the profiler in C, which Numba supports, does neither.
    """
    profile = Profile()
    profile.runcall(call)
    return sum(entry.callcount for entry in profile.getstats())


def test_a_step_of_one_more_copy_makes_few_calls(copies: NrpVectorEnv) -> None:
    counts = []
    for number in (1, COPIES):
        with closing(make_vec("braitenberg_husky", OVERRIDES, num_envs=number, threads=1, **AGENT)) as envs:
            envs.reset(seed=4)
            steps = iter(COMMANDS[:, :number])
            envs.step({"/husky/cmd_vel": next(steps)})
            counts.append(calls_in(lambda: envs.step({"/husky/cmd_vel": next(steps)})))  # noqa: B023
    assert (counts[1] - counts[0]) / (COPIES - 1) < MOST_CALLS, counts


def test_a_reset_by_snapshot_makes_few_calls() -> None:
    with closing(make_env("braitenberg_husky", OVERRIDES, same_noise=True, **AGENT)) as env:
        env.reset()  # the first one paints
        env.step({"/husky/cmd_vel": COMMANDS[0, 0]})
        assert calls_in(env.reset) < MOST_CALLS_OF_RESET
