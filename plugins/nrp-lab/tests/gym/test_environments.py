"""Experiments as environments of Gymnasium, checked by Gymnasium."""

import subprocess
import sys
import warnings
from collections.abc import Iterator
from contextlib import closing
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import pytest
from golden import Golden
from gymnasium.utils.env_checker import check_env
from nrp_lab.gym import NrpEnv, make_env, make_vec
from nrp_lab.gym.agent_run import Agent
from nrp_lab.gym.env import SHIPPED

import nrp_core
from nrp_core.errors import ExperimentError

DRIVE = {"/pioneer/cmd_vel": {"linear.x": (0.0, 1.0), "angular.z": (-2.0, 2.0)}}


@pytest.fixture
def env() -> Iterator[NrpEnv]:
    """The slalom robot with its own brain, which hears noise."""
    noise = {"source:feelers": (0.0, 300.0, 6.0)}
    with closing(make_env("slalom_pioneer", observe=["rate:wheels"], act=noise)) as made:
        yield made


@pytest.mark.one_of(6)
@pytest.mark.parametrize("name", SHIPPED)
def test_gymnasium_finds_no_fault_with_what_ships(name: str) -> None:
    with closing(gymnasium.make(name)) as made, warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # it recommends bounds of 1; these are in SI units
        check_env(made.unwrapped, skip_render_check=True)
        made.reset(seed=1)
        for _ in range(10):
            seen, reward, terminated, _, _ = made.step(made.action_space.sample())
            assert seen in made.observation_space
            assert (reward, terminated) == (0.0, False)


def test_an_episode_is_the_run_of_the_experiment() -> None:
    with closing(make_env("slalom_pioneer", observe=["rate:wheels"], same_noise=True)) as made:
        for _ in range(2):
            made.reset()
            for _ in range(10):
                made.step({})
            alone = nrp_core.run("slalom_pioneer", until_s=0.2)
            assert made.run.result().trajectory_digest == alone.trajectory_digest


def test_the_states_of_a_group_of_muscles_are_observed_as_one_array() -> None:
    with closing(make_env("reflex_arm", observe=["/arm/muscles/state"])) as made:
        (first,) = made.reset(seed=1)[0].values()
        for _ in range(20):
            (seen,) = made.step({})[0].values()
        state = made.run.world.subscribe("/arm/muscles/state").latest.message
        fields = ("length", "velocity", "force", "activation", "normalized_length", "normalized_force",
                  "normalized_velocity")  # fmt: skip
        assert first.shape == (7 * len(state.name),)
        np.testing.assert_array_equal(seen, np.concatenate([getattr(state, field) for field in fields]))
        assert state.activation.max() > 0.01


def test_the_controls_of_a_group_of_muscles_are_one_action_within_0_and_1(golden: Golden) -> None:
    topic, seen = "/arm/muscles/cmd", ["/arm/muscles/state"]
    with closing(make_env("reflex_arm", act=[topic], observe=seen)) as made:
        space = made.action_space[topic]
        assert (space.low.tolist(), space.high.tolist()) == ([0.0] * 4, [1.0] * 4)
        made.reset(seed=1)
        for _ in range(20):
            made.step({topic: np.array([0.2, 0.0, 1.0, 0.5])})
        state = made.run.world.subscribe(seen[0]).latest.message
        np.testing.assert_allclose(state.activation, [0.2, 0.0, 1.0, 0.5], atol=0.02)  # after 80 ms
    with closing(make_env("reflex_arm", act={topic: {"elbow_flexor": (0.0, 0.5)}}, observe=seen)) as made:
        assert made.action_space[topic].shape == (1,)
    with golden.raises(ExperimentError, match="'elbow'"):
        make_env("reflex_arm", act={topic: {"elbow": (0.0, 0.5)}}, observe=seen)


@pytest.mark.parametrize(
    ("settings", "action", "words"),
    [
        ({"reward": lambda run, seen: None}, {}, "0.02"),
        ({"reward": lambda run, seen: np.zeros(2)}, {}, r"0.02.*array\(\[0., 0.\]\)"),
        ({"terminate": lambda run, seen: np.zeros(2)}, {}, ""),
        ({"terminate": lambda run, seen: None}, {}, ""),
        ({"terminate": lambda run, seen: 0.4}, {}, "0.4"),
        (
            {"act": {"source:feelers": (0.0, 9.0, 6.0)}},
            {"source:feelers": [1.0, 2.0]},
            r"'source:feelers'.*\(1,\).*\(2,\)",
        ),
        ({}, np.array([1.0]), r"array\(\[1.\]\)"),
        ({}, {"/pioneer/cmd": [1.0]}, "{'/pioneer/cmd'"),
    ],
)
def test_the_actions_of_an_agent_are_checked(
    settings: dict[str, Any], action: Any, words: str, golden: Golden
) -> None:
    with closing(make_env("slalom_pioneer", observe=["rate:wheels"], **settings)) as made:
        with golden.raises(ExperimentError):
            made.step(action)
        made.reset(seed=1)
        with golden.raises(ExperimentError, match=words):
            made.step(action)


def episode(made: NrpEnv, seed: int | None, steps: int = 15) -> list[float]:
    made.reset(seed=seed)
    noise = {"source:feelers": np.array([100.0])}
    return [float(made.step(noise)[0]["rate:wheels"][0]) for _ in range(steps)]


def test_equal_seeds_give_equal_episodes_and_each_episode_has_its_own_noise(env: NrpEnv) -> None:
    first, second = episode(env, 5), episode(env, None)
    assert (episode(env, 5), episode(env, None)) == (first, second)
    assert first != second


def test_an_environment_that_forgets_the_seed_is_noticed(
    env: NrpEnv, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = episode(env, 5)
    reset = env.reset
    monkeypatch.setattr(env, "reset", lambda seed=None: reset())
    assert episode(env, 5) != first


def test_bounds_come_from_the_messages_and_actions_move_the_robot() -> None:
    bare = ["transfer_functions=[]", "criteria=null"]
    with closing(make_env("slalom_pioneer", bare, observe=["/pioneer/scan"], act=DRIVE)) as made:
        scan = made.observation_space["/pioneer/scan"]
        assert scan.low.max() == 0
        with nrp_core.Run(nrp_core.load_experiment("slalom_pioneer", bare)) as run:
            assert made.run.world.subscribed - run.world.subscribed == {"/pioneer/scan"}
        made.reset(seed=0)
        before = made.run.world.model_motion("pioneer").pose.position[0]
        for _ in range(50):
            seen, *_ = made.step({"/pioneer/cmd_vel": np.array([0.5, 0.0])})
        moved = made.run.world.model_motion("pioneer").pose.position[0] - before
        assert moved == pytest.approx(0.5, abs=0.05)  # m in 1 s at 0.5 m/s
        assert 0 < seen["/pioneer/scan"].min() < seen["/pioneer/scan"].max()


@pytest.mark.parametrize("name", ["reward", "terminate"])
@pytest.mark.parametrize(
    ("given", "shown"),
    [
        (lambda seen: 1.0, r"not one that takes \(seen\)"),
        (lambda: 1.0, r"not one that takes \(\)"),
        (lambda run, seen, gain: 1.0, r"not one that takes \(run, seen, gain\)"),
        (1.0, "not 1.0"),
        (lambda run, seen, gain=2.0: gain, ""),
        (lambda *given: 1.0, ""),
        (max, ""),  # it does not say
    ],
)
def test_a_function_that_cannot_take_run_and_observation_is_refused(
    name: str, given: Any, shown: str, golden: Golden
) -> None:
    settings = {"reward": None, "terminate": None, name: given}
    if not shown:
        Agent(["rate:wheels"], {}, steps=1, same_noise=False, **settings)
        return
    with golden.raises(ExperimentError, match=f"{name}.*{shown}"):
        Agent(["rate:wheels"], {}, steps=1, same_noise=False, **settings)


def test_reward_end_and_length_of_an_episode() -> None:
    settings: dict[str, Any] = {
        "reward": lambda run, seen: run.now_s,
        "terminate": lambda run, seen: run.now_s > 0.3,
        "steps": 5,
    }
    short = ["duration=400 ms", "criteria=null"]
    with closing(make_env("slalom_pioneer", short, observe=["rate:wheels"], **settings)) as made:
        made.reset()
        ends = [made.step({})[1:4] for _ in range(4)]
    assert ends == [(0.1, False, False), (0.2, False, False), (0.3, False, False), (0.4, True, True)]


def test_a_source_drives_neurons() -> None:
    act = {"source:feelers": (0.0, 300.0, 6.0)}
    bare = ["transfer_functions=[]", "criteria=null"]
    with closing(make_env("slalom_pioneer", bare, observe=["rate:feelers"], act=act)) as made:
        rates = []
        for rate in (0.0, 250.0):
            made.reset(seed=2)
            for _ in range(20):
                seen, *_ = made.step({"source:feelers": np.array([rate])})
            rates.append(seen["rate:feelers"][0])
    assert rates[0] == 0
    assert rates[1] > 20


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("observe", "act", "message"),
    [
        (["/pioneer/scna"], {}, "no topic '/pioneer/scna' to observe; did you mean '/pioneer/scan'?"),
        (["rate:wheel"], {}, "no group of neurons 'wheel'; did you mean 'wheels'?"),
        (["joint:pioneer"], {}, "'joint:pioneer' cannot be observed; did you mean 'joints:'?"),
        ([], {}, "an environment needs a list of at least one observation"),
        ("/pioneer/scan", {}, "observe is '/pioneer/scan'; it must be a list of texts"),
        (
            ["rate:wheels"],
            "/pioneer/cmd_vel",
            "act is '/pioneer/cmd_vel'; it must be a list of texts or a dictionary",
        ),
        (["rate:wheels"], {"source:feelers": (-5.0, 200.0, 6.0)}, "with rates from 0 Hz on and a weight"),
        (["rate:wheels"], {"source:feelers": (0.0, 200.0, 0.0)}, "weight that is not 0, not (0.0, 200.0, 0"),
        (["rate:wheels"], {"/pioneer/cmd_vl": None}, "did you mean '/pioneer/cmd_vel'?"),
        (["rate:wheels"], {"/pioneer/cmd_vel": {"linear.w": (0, 1)}}, "has no number 'linear.w'"),
        (
            ["rate:wheels"],
            {"/pioneer/cmd_vel": ["linear.x"]},
            "of '/pioneer/cmd_vel' are {'field': (low, high)}",
        ),
        (
            ["rate:wheels"],
            {"/pioneer/cmd_vel": {"linear.x": 1.0}},
            "are two numbers, the lower one first, not 1.0",
        ),
        (["rate:wheels"], {"/pioneer/cmd_vel": {"linear.x": (0, np.inf)}}, "lower one first, not (0, inf)"),
        (["rate:wheels"], {"source:feelers": (200.0, 0.0)}, "the bounds of the rate of 'feelers' are two"),
        (
            ["rate:wheels"],
            {"/pioneer/cmd_vel": {"linear.x": (0, 1), "linear.y": (0, 1)}},
            "moves nothing: the drive of 'pioneer' takes linear.x and angular.z",
        ),
        (
            ["/pioneer/clearance"],
            DRIVE | {"/pioneer/clearance": None},
            "no message arrives on /pioneer/clearance",
        ),
    ],
)
def test_a_mistake_is_named(observe: Any, act: Any, message: str) -> None:
    with pytest.raises(nrp_core.NrpError) as raised:
        make_env("slalom_pioneer", observe=observe, act=act)
    assert message in str(raised.value)


def test_a_reward_that_is_not_a_number_and_half_a_step_are_refused(golden: Golden) -> None:
    nowhere: dict[str, Any] = {"reward": lambda run, seen: float("nan")}
    with closing(make_env("slalom_pioneer", observe=["rate:wheels"], **nowhere)) as made:
        made.reset()
        with golden.raises(nrp_core.NrpError, match=r"0\.02"):
            made.step({})
    with golden.raises(nrp_core.NrpError, match=r"1\.5"):
        make_env("slalom_pioneer", observe=["rate:wheels"], steps=1.5)  # type: ignore[arg-type]
    with golden.raises(nrp_core.NrpError, match=r"51.*1\.02"):
        make_env("slalom_pioneer", observe=["rate:wheels"], steps=51, overrides=["duration=1 s"])
    with golden.raises(nrp_core.NrpError, match=r"1\.0"):
        make_env("slalom_pioneer", observe=["rate:wheels"], reward=1.0)  # type: ignore[arg-type]
    with golden.raises(nrp_core.NrpError, match="same_noise.*'no'"):
        make_env("slalom_pioneer", observe=["rate:wheels"], same_noise="no")  # type: ignore[arg-type]


def test_a_step_after_the_end_is_warned_of_once() -> None:
    made = make_env("slalom_pioneer", observe=["rate:wheels"], terminate=lambda run, seen: run.now_s > 0.03)
    with closing(made), warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for steps, told in ((2, 0), (2, 0), (4, 1), (3, 1)):
            made.reset()
            for _ in range(steps):
                made.step({})
            assert len(caught) == told
        made.reset(options={})
        made.reset(options={"pose": 1})
    after_the_end, options = (str(one.message) for one in caught)
    assert "step() after the end of an episode" in after_the_end
    assert "reset() takes no options: {'pose': 1} has no effect" in options


def test_the_bounds_of_a_velocity_are_those_that_its_drive_uses() -> None:
    with closing(make_env("slalom_pioneer", observe=["rate:wheels"], act=["/pioneer/cmd_vel"])) as made:
        assert made.action_space["/pioneer/cmd_vel"].shape == (2,)  # linear.x and angular.z


def test_an_action_beyond_its_bounds_is_clipped_and_warned_of_once() -> None:
    """As Gymnasium's Pendulum and MountainCarContinuous clip; rounding of single precision is not told."""
    act = {"/pioneer/cmd_vel": {"linear.x": (0.0, 0.3), "angular.z": (-1.0, 1.0)}}
    ends = {}
    with closing(make_env("slalom_pioneer", observe=["motion:pioneer"], act=act)) as made:
        for forward in (0.3, float(np.float32(0.3)), 30.0):
            made.reset(seed=1)
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                for _ in range(5):
                    seen, *_ = made.step({"/pioneer/cmd_vel": np.array([forward, 0.5])})
            ends[forward] = seen["motion:pioneer"].tobytes(), [str(one.message) for one in caught]
    assert len({end for end, _ in ends.values()}) == 1
    silent, rounded, (told,) = (messages for _, messages in ends.values())
    assert not silent + rounded
    assert "'linear.x' of the action '/pioneer/cmd_vel' is 30; it is clipped to its bounds, 0 to 0.3" in told


def test_without_gymnasium_the_command_that_installs_it_is_named() -> None:
    program = "import sys; sys.modules['gymnasium'] = None\nimport nrp_lab.gym"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert "nrp_lab.gym needs gymnasium; try: pip install 'nrp-lab[gym]'" in done.stderr


def test_a_closed_environment_says_so(golden: Golden) -> None:
    one = make_env("slalom_pioneer", observe=["rate:wheels"])
    one.reset(seed=1)
    many = make_vec("slalom_pioneer", num_envs=2, observe=["rate:wheels"])
    many.reset(seed=1)
    for made in (one, many):
        made.close()
        for call in (partial(made.step, {}), made.reset):
            with golden.raises(ExperimentError):
                call()
