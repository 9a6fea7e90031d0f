"""Several agents in one run, checked by PettingZoo."""

from collections.abc import Iterator
from contextlib import closing
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_lab.gym import make_env
from nrp_lab.gym.parallel import NrpParallelEnv
from pettingzoo.test import parallel_api_test

from nrp_core.errors import ExperimentError

SPEEDS = {"linear.x": (-1.0, 1.0), "angular.z": (-2.0, 2.0)}
ROBOTS = ("cat", "dog")


def agents(**more: Any) -> dict[str, dict[str, Any]]:
    return {
        name: {"observe": [f"motion:{name}"], "act": {f"/{name}/cmd_vel": SPEEDS}, **more} for name in ROBOTS
    }


@pytest.fixture
def env() -> Iterator[NrpParallelEnv]:
    with closing(NrpParallelEnv("chase", ["duration=0.4 s"], agents=agents())) as made:
        yield made


def test_pettingzoo_finds_no_fault(env: NrpParallelEnv) -> None:
    parallel_api_test(env, num_cycles=30)
    assert env.agents == []


def test_each_agent_drives_its_own_robot(env: NrpParallelEnv) -> None:
    env.reset(seed=1)
    actions = {"cat": {"/cat/cmd_vel": np.array([0.0, 0.0])}, "dog": {"/dog/cmd_vel": np.array([1.0, 0.0])}}
    first, *_ = env.step(actions)
    for _ in range(15):
        last, rewards, terminated, truncated, _ = env.step(actions)
    moved = {name: np.abs(last[name][f"motion:{name}"] - first[name][f"motion:{name}"])[0] for name in ROBOTS}
    assert moved["cat"] < 0.01 < 0.1 < moved["dog"]
    assert last["cat"].keys() == {"motion:cat"}
    assert (rewards, terminated, truncated) == (
        dict.fromkeys(ROBOTS, 0.0),
        *[dict.fromkeys(ROBOTS, False)] * 2,
    )


def test_an_agent_alone_gets_what_gymnasium_gives() -> None:
    reward = {"reward": lambda run, seen: float(seen["motion:dog"][0])}
    own = agents(**reward)["dog"]
    action = {"/dog/cmd_vel": np.array([0.5, 0.3])}
    with (
        closing(NrpParallelEnv("chase", agents={"dog": own}, steps=2)) as several,
        closing(make_env("chase", **own, steps=2)) as one,
    ):
        assert several.reset(seed=4)[0]["dog"].keys() == one.reset(seed=4)[0].keys()
        for _ in range(5):
            seen, rewards, *_ = several.step({"dog": action})
            expected, reward_there, *_ = one.step(action)
            assert rewards["dog"] == reward_there
            np.testing.assert_array_equal(seen["dog"]["motion:dog"], expected["motion:dog"])


def test_an_agent_that_has_finished_leaves_and_the_other_goes_on() -> None:
    given = agents()
    given["cat"]["terminate"] = lambda run, seen: run.now_s > 0.05
    with closing(NrpParallelEnv("chase", ["duration=0.2 s"], agents=given)) as env:
        env.reset(seed=1)
        present = []
        while env.agents:
            present.append(env.agents)
            env.step({name: env.action_space(name).sample() for name in env.agents})
        assert present == [["cat", "dog"]] * 3 + [["dog"]] * 7


@pytest.mark.parametrize(
    "wrong",
    [
        {},
        {"cat": {"observe": ["motion:cat"], "acts": ()}},
        {name: {"observe": ["motion:cat"], "act": {"/cat/cmd_vel": SPEEDS}} for name in ROBOTS},
    ],
    ids=["none", "key", "twice"],
)
def test_wrong_agents_are_refused(wrong: dict[str, Any], golden: Golden) -> None:
    with golden.raises(ExperimentError):
        NrpParallelEnv("chase", agents=wrong)


def test_an_action_that_is_missing_is_named(env: NrpParallelEnv, golden: Golden) -> None:
    env.reset(seed=1)
    with golden.raises(ExperimentError):
        env.step({"cat": {"/cat/cmd_vel": np.zeros(2)}})
