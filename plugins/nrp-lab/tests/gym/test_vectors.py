"""Many copies as one environment: bit for bit what Gymnasium makes of single ones, whatever ends them."""

from collections.abc import Iterator
from contextlib import closing
from functools import partial
from typing import Any

import gymnasium
import nrp_lab.gym
import numpy as np
import pytest
from golden import Golden
from gymnasium.spaces import flatten_space, unflatten
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers.vector import (
    FlattenObservation,
    NormalizeObservation,
    NormalizeReward,
    RecordEpisodeStatistics,
)
from nrp_lab.gym import NrpProcessesEnv, NrpVectorEnv, make_env, make_vec, vector_processes

from nrp_core.errors import ExperimentError, LifecycleError, NrpError, SimulationError
from nrp_core.experiment.making.plan import Plan
from nrp_core.scene.rigid import ModelMotion, Pose

assert nrp_lab.gym, "importing it registers the shipped experiments"
COPIES = 2
LIVELY_HZ = 140
# the function of these short runs does not publish the clearance that a criterion needs
pytestmark = pytest.mark.filterwarnings(r"ignore:[\s\S]*'/pioneer/clearance'")
FUNCTION = """
steps = 0

@nrp.MapSpikeSink("feelers", nrp.brain.feelers, nrp.population_rate)
@nrp.Neuron2Robot(Topic("/pioneer/cmd_vel", geometry_msgs.msg.Twist))
def drive(t, feelers):
    global steps
    steps += 1
    turn = geometry_msgs.msg.Vector3(0, 0, 0.02 * feelers.rate)
    return geometry_msgs.msg.Twist(geometry_msgs.msg.Vector3(0.02 * steps), turn)
"""
AGENT: dict[str, Any] = {
    "observe": ["rate:feelers", "/pioneer/scan", "motion:pioneer", "joints:pioneer"],
    "act": {"source:feelers": (0.0, 300.0, 6.0)},
    "reward": lambda run, seen: float(seen["/pioneer/scan"].min()) + run.now_s,
    "terminate": lambda run, seen: seen["rate:feelers"][0] > LIVELY_HZ,
}


@pytest.fixture(scope="module")
def overrides(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Short runs whose transfer function keeps a value in a variable of its file."""
    file = tmp_path_factory.mktemp("functions") / "drive.py"
    file.write_text(FUNCTION)
    return ["duration=100 ms", f"transfer_functions=[{file}]"]


@pytest.fixture
def single(overrides: list[str]) -> Iterator[SyncVectorEnv]:
    """Single environments, stepped one after the other by Gymnasium; their functions have not run before."""
    with closing(SyncVectorEnv([lambda: make_env("slalom_pioneer", overrides, **AGENT)] * COPIES)) as envs:
        yield envs


@pytest.fixture
def copies(overrides: list[str]) -> Iterator[NrpVectorEnv]:
    with closing(make_vec("slalom_pioneer", overrides, num_envs=COPIES, threads=2, **AGENT)) as envs:
        yield envs


def episodes(envs: Any, mode: AutoresetMode) -> Iterator[tuple[Any, ...]]:
    """Yield the returned values of resets and steps; the action of each copy is different."""
    envs.autoreset_mode = mode
    draw = np.random.default_rng(0)
    yield envs.reset(seed=5)
    for _ in range(12):
        stepped = envs.step({"source:feelers": draw.uniform(100, 300, (COPIES, 1))})
        yield stepped
        if mode is AutoresetMode.DISABLED and (over := stepped[2] | stepped[3]).any():
            yield envs.reset(options={"reset_mask": over})
    yield envs.reset(seed=[7, 8], options={"reset_mask": np.array([False, True])})


def assert_equal(found: Any, expected: Any) -> None:
    """Check that nested values are equal in every bit."""
    if isinstance(expected, dict):
        assert found.keys() == expected.keys()
        for key in expected:
            assert_equal(found[key], expected[key])
    elif isinstance(expected, tuple) or getattr(expected, "dtype", None) == np.dtype(object):
        assert len(found) == len(expected)
        for one, other in zip(found, expected, strict=True):
            assert_equal(one, other)
    else:
        assert np.array_equal(found, expected)


@pytest.mark.one_of(6)
@pytest.mark.parametrize("mode", AutoresetMode)
def test_copies_are_what_gymnasium_makes_of_single_environments(
    single: SyncVectorEnv, copies: NrpVectorEnv, mode: AutoresetMode
) -> None:
    assert copies.observation_space == single.observation_space
    assert copies.action_space == single.action_space
    found, expected = [*episodes(copies, mode)], [*episodes(single, mode)]
    assert_equal(tuple(found), tuple(expected))
    steps = [one for one in found if len(one) == 5]
    assert sum(one[2].sum() for one in steps), "some were terminated"
    assert sum(one[3].sum() for one in steps), "some reached the end of the experiment"
    assert len({float(one[0]["motion:pioneer"][copy, 0]) for one in steps for copy in range(COPIES)}) > 12


FLAT = ["/pioneer/scan", "rate:feelers", "motion:pioneer"]
TWO_ACTS = {
    "source:feelers": (0.0, 300.0, 6.0),
    "/pioneer/cmd_vel": {"linear.x": (0, 1), "angular.z": (-2, 2)},
}


def flattened(env: gymnasium.Env[Any, Any]) -> gymnasium.Env[Any, Any]:
    """Return what wrappers of Gymnasium make of an environment with named observations and actions."""
    acted = env.action_space
    seen = gymnasium.wrappers.FlattenObservation(env)
    return gymnasium.wrappers.TransformAction(seen, lambda row: unflatten(acted, row), flatten_space(acted))


@pytest.fixture(scope="module")
def pairs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Any]]:
    """Flat copies, those that wrappers flatten, and flat single environments."""
    file = tmp_path_factory.mktemp("functions") / "none.py"
    file.write_text(FUNCTION.replace("steps += 1", "steps = 1"))
    short = ["duration=100 ms", f"transfer_functions=[{file}]"]
    named: dict[str, Any] = AGENT | {"experiment": "slalom_pioneer", "overrides": short}
    named |= {"observe": FLAT, "act": TWO_ACTS}
    flat = named | {"flat": True}
    with (
        closing(SyncVectorEnv([lambda: flattened(make_env(**named))] * COPIES)) as wrapped,
        closing(SyncVectorEnv([lambda: make_env(**flat)] * COPIES)) as alone,
        closing(make_vec(num_envs=COPIES, **flat)) as together,
    ):
        yield {"one by one": wrapped, "alone": alone, "together": together, "settings": flat}


@pytest.mark.one_of(2)
@pytest.mark.parametrize("made", ["alone", "together"])
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_flat_copies_are_what_wrappers_of_gymnasium_make_of_single_environments(
    pairs: dict[str, Any], made: str, mode: AutoresetMode
) -> None:
    assert_flat(pairs[made], pairs["one by one"], mode)


@pytest.mark.heavy
def test_flat_copies_in_processes_are_the_same(pairs: dict[str, Any]) -> None:
    flat = pairs["settings"] | {"num_envs": 2, "processes": 2, "autoreset_mode": "SameStep"}
    with closing(make_vec(**flat)) as found:
        assert_flat(found, pairs["one by one"], AutoresetMode.SAME_STEP)


def assert_flat(found: Any, expected: Any, mode: AutoresetMode) -> None:
    """Check that flat copies are those of wrappers, also if the caller uses the array of actions again."""
    assert found.observation_space == expected.observation_space
    assert found.action_space == expected.action_space
    for envs in (found, expected):
        envs.autoreset_mode = mode
    assert_equal(found.reset(seed=5), expected.reset(seed=5))
    draw, ends = np.random.default_rng(0), 0
    for _ in range(12):
        action = draw.uniform((0, -2, 0), (1, 2, 300), (COPIES, 3))
        used = action.copy()
        stepped = found.step(used)
        used[:] = np.nan
        assert_equal(stepped, expected.step(action))
        assert stepped[0].dtype == np.float64
        ends += int((stepped[2] | stepped[3]).sum())
    assert ends


def test_an_image_stays_of_bytes_for_rewards_and_becomes_a_float_beside_rates() -> None:
    kinds = set()

    def reward(_: Any, seen: dict[str, Any]) -> float:
        kinds.add((seen["/husky/camera"].dtype, seen["/husky/camera"].shape))
        return float(seen["/husky/camera"][0, 0, 0])

    settings: dict[str, Any] = {"act": ["source:sensors"], "reward": reward, "steps": 2}
    overrides = ["world.options.image_scale=0.1", "transfer_functions=[]", "criteria=null", "events=null"]
    seen = ["rate:actors", "/husky/camera"]
    wrapped = flattened(make_env("braitenberg_husky", overrides, observe=seen, **settings))
    with closing(SyncVectorEnv([lambda: wrapped])) as expected:
        for observe, theirs in ((seen, expected), (seen[1:], None)):
            flat = {"num_envs": 1, "flat": True, "observe": observe}
            with closing(make_vec("braitenberg_husky", overrides, **settings, **flat)) as found:
                assert found.observation_space.dtype == (np.float64 if theirs else np.uint8)
                rows = found.reset(seed=1)[0], *found.step(np.full((1, 1), 50.0))[:2]
                if theirs:
                    assert found.observation_space == theirs.observation_space
                    assert_equal(rows, (theirs.reset(seed=1)[0], *theirs.step(np.full((1, 1), 50.0))[:2]))
    ((kind, shape),) = kinds
    assert (kind, len(shape)) == (np.uint8, 3)


def test_flat_actions_need_an_action_and_the_shape_of_all(pairs: dict[str, Any], golden: Golden) -> None:
    for make in (make_env, partial(make_vec, num_envs=2)):
        with golden.raises(ExperimentError, match="at least one action"):
            make("slalom_pioneer", observe=["rate:wheels"], flat=True)
    pairs["together"].reset(seed=1)
    for action in (np.zeros(3), {"source:feelers": np.zeros((2, 1))}):
        with golden.raises(ExperimentError, match=r"\(2, 3\)"):
            pairs["together"].step(action)


def test_wrappers_of_gymnasium_do_with_copies_what_they_do_with_single_environments(
    copies: NrpVectorEnv, single: SyncVectorEnv
) -> None:
    def wrapped(envs: Any) -> tuple[Any, ...]:
        recorded = RecordEpisodeStatistics(envs)
        every = NormalizeReward(NormalizeObservation(FlattenObservation(recorded)))
        every.action_space.seed(2)
        steps = [every.reset(seed=5)[0]]
        for _ in range(12):
            steps += every.step(every.action_space.sample())[:4]
        return (*steps, [*recorded.return_queue], [*recorded.length_queue])

    found = wrapped(copies)
    assert found[-1]
    assert_equal(found, wrapped(single))


def test_a_copy_that_fails_is_named_and_can_be_reset_while_the_others_continue(
    single: SyncVectorEnv, copies: NrpVectorEnv, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    action = {"source:feelers": np.full((COPIES, 1), 200.0)}
    for envs in (single, copies):
        envs.autoreset_mode = AutoresetMode.DISABLED
        envs.reset(seed=5)
    monkeypatch.setattr(copies, "first_number", 6)
    copies.runs[1].world.place("pioneer", ModelMotion(Pose((0.0, 0.0, 1.0)), linear=(1e200, 0.0, 0.0)))
    with golden.raises(NrpError):
        copies.step(action)
    with golden.raises(NrpError):
        copies.step(action)
    again = {"reset_mask": np.array([False, True])}
    copies.reset(seed=[0, 9], options=dict(again))
    for _ in range(2):
        single.step(action)
    single.reset(seed=[0, 9], options=dict(again))
    found, expected = copies.step(action)[0], single.step(action)[0]
    assert_equal(found["rate:feelers"], expected["rate:feelers"])  # the function of copy 1 has run less often
    assert_equal(*({name: rows[0] for name, rows in seen.items()} for seen in (found, expected)))


@pytest.mark.parametrize("fails", ["observation", "reward"])
def test_a_copy_whose_observation_or_reward_fails_is_named_when_all_others_are_judged(
    copies: NrpVectorEnv, monkeypatch: pytest.MonkeyPatch, fails: str
) -> None:
    def fail(*_: Any) -> float:
        raise ZeroDivisionError("no clearance")

    action = {"source:feelers": np.zeros((COPIES, 1))}
    copies.autoreset_mode = AutoresetMode.DISABLED
    with pytest.raises(ExperimentError):
        copies.step(action)  # before the first reset
    copies.reset(seed=5)
    for _ in range(4):
        copies.step(action)
    failing = copies._copies[0]  # the other comes after it, and reaches the end in this step
    with monkeypatch.context() as patch:
        if fails == "reward":
            patch.setattr(failing, "rate", fail)
        else:
            patch.setattr(failing.observed["/pioneer/scan"], "read", fail)
        with pytest.raises(SimulationError, match="copy 0: no clearance") as raised:
            copies.step(action)
        assert isinstance(raised.value.__cause__, ZeroDivisionError)
    assert [run.now_s for run in copies.runs] == [0.1, 0.1]
    with pytest.raises(LifecycleError, match="over: 1;"):
        copies.step(action)
    copies.reset(options={"reset_mask": np.ones(COPIES, bool)})
    assert np.array_equal(copies.step(action)[4]["t_s"], [0.02, 0.02])


def test_episodes_are_truncated_after_the_steps_that_gymnasium_passes_on() -> None:
    def steps(mode: str) -> tuple[Any, ...]:
        made = gymnasium.make_vec(
            "nrp/SlalomPioneer-v0", num_envs=2, max_episode_steps=3, vectorization_mode=mode
        )
        with closing(made) as envs:
            envs.action_space.seed(1)
            return (envs.reset(seed=4), *(envs.step(envs.action_space.sample()) for _ in range(6)))

    found, expected = steps("vector_entry_point"), steps("sync")
    assert_equal(found, expected)
    assert [bool(one[3].all()) for one in found[1:]] == [False, False, True, False, False, False]
    make_vec("slalom_pioneer", num_envs=1, observe=["rate:wheels"], max_episode_steps=-1).close()
    with pytest.raises(ExperimentError, match="max_episode_steps is a whole number from 1 on"):
        make_vec("slalom_pioneer", num_envs=2, observe=["rate:wheels"], max_episode_steps=0)


@pytest.mark.parametrize("wrong", ["one seed for all", "shared functions"])
def test_wrong_copies_are_noticed(
    single: SyncVectorEnv, overrides: list[str], wrong: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if wrong == "one seed for all":
        monkeypatch.setattr(NrpVectorEnv, "_draw", lambda self, number: 3)
    else:
        monkeypatch.setattr(Plan, "with_fresh_functions", lambda plan: plan)
    mode = AutoresetMode.NEXT_STEP
    with (
        pytest.raises((AssertionError, NrpError)),
        closing(make_vec("slalom_pioneer", overrides, num_envs=COPIES, **AGENT)) as copies,
    ):
        assert_equal(tuple(episodes(copies, mode)), tuple(episodes(single, mode)))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"num_envs": 0}, "num_envs is a whole number from 1 on, not 0"),
        ({"threads": -1}, "threads is a whole number from 0 on, not -1"),
        ({"autoreset_mode": "SameSteps"}, "not 'SameSteps'; did you mean 'SameStep'?"),
        ({"render_mode": "rgb_array"}, "copies have no render_mode"),
        ({"observe": ["motion:pionier"]}, "no model 'pionier'; did you mean 'pioneer'?"),
    ],
)
def test_a_mistake_is_named(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(NrpError) as raised:
        make_vec("slalom_pioneer", **({"num_envs": 2, "observe": ["rate:wheels"]} | settings))
    assert message in str(raised.value)


def test_wrong_seeds_masks_and_actions_are_refused(copies: NrpVectorEnv, golden: Golden) -> None:
    for given in (
        {"seed": [1]},
        {"options": {"reset_mask": [True, False]}},
        {"options": {"reset_mask": np.zeros(2, bool)}},
    ):
        with golden.raises(NrpError):
            copies.reset(**given)
    copies.reset(seed=1)
    with golden.raises(NrpError, match=r"'source:feelers'.*\(2, 1\).*\(1,\)"):
        copies.step({"source:feelers": np.array([1.0])})
    with golden.raises(NrpError, match="'source:feelers'"):
        copies.step({"source:feeler": np.zeros((2, 1))})


@pytest.fixture(scope="module")
def forgetful(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Short runs whose transfer function keeps nothing, so that tests can come in any order."""
    file = tmp_path_factory.mktemp("functions") / "drive.py"
    file.write_text(FUNCTION.replace("steps += 1", "steps = 1"))
    return ["duration=100 ms", f"transfer_functions=[{file}]"]


@pytest.fixture(scope="module")
def alone(forgetful: list[str]) -> Iterator[SyncVectorEnv]:
    with closing(SyncVectorEnv([lambda: make_env("slalom_pioneer", forgetful, **AGENT)] * COPIES)) as envs:
        yield envs


@pytest.fixture(scope="module")
def spread(forgetful: list[str]) -> Iterator[NrpProcessesEnv]:
    """Each copy in a process of its own."""
    settings = {"num_envs": COPIES, "processes": 9, "autoreset_mode": "SameStep", **AGENT}
    with closing(make_vec("slalom_pioneer", forgetful, **settings)) as envs:
        assert isinstance(envs, NrpProcessesEnv)
        yield envs


@pytest.mark.heavy
def test_copies_in_processes_are_what_gymnasium_makes_of_single_environments(
    alone: SyncVectorEnv, spread: NrpProcessesEnv
) -> None:
    assert spread.observation_space == alone.observation_space
    assert spread.action_space == alone.action_space
    mode = AutoresetMode.SAME_STEP
    found, expected = [*episodes(spread, mode)], [*episodes(alone, mode)]
    assert_equal(tuple(found), tuple(expected))
    assert any("final_obs" in one[4] for one in found if len(one) == 5)


@pytest.mark.parametrize("wrong", ["seeds", "actions"])
def test_wrong_shares_are_noticed(
    alone: SyncVectorEnv, spread: NrpProcessesEnv, wrong: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if wrong == "seeds":
        monkeypatch.setattr("nrp_lab.gym.vector_processes.seeds_of", lambda seed, copies: [5] * copies)
    else:
        right = vector_processes.rows_of
        monkeypatch.setattr(vector_processes, "rows_of", lambda given, space: right(given, space)[::-1])
    mode = AutoresetMode.SAME_STEP
    with pytest.raises(AssertionError):
        assert_equal(tuple(episodes(spread, mode)), tuple(episodes(alone, mode)))


def test_wrong_arguments_and_a_lost_process_are_named(spread: NrpProcessesEnv, golden: Golden) -> None:
    with golden.raises(NrpError):
        make_vec("slalom_pioneer", num_envs=2, observe=["rate:wheels"], processes=0)
    spread.reset(seed=1)
    with golden.raises(NrpError, match=r"'source:feelers'.*\(2, 1\).*\(3, 1\)"):
        spread.step({"source:feelers": np.zeros((3, 1))})
    with golden.raises(NrpError, match="3 seeds"):
        spread._all(
            vector_processes._reset, [([1, 2, 3], np.array([True]))] * COPIES
        )  # an error in a process is an error here
    spread._workers[1].process.kill()
    with golden.raises(NrpError):
        spread.step({"source:feelers": np.zeros((2, 1))})


def test_shipped_experiments_are_made_by_the_number() -> None:
    with closing(gymnasium.make_vec("nrp/SlalomPioneer-v0", num_envs=2, autoreset_mode="SameStep")) as envs:
        assert isinstance(envs.unwrapped, NrpVectorEnv)
        assert envs.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
        seen, _ = envs.reset(seed=1)
        assert seen["/pioneer/scan"].shape == (2, *envs.single_observation_space["/pioneer/scan"].shape)


def test_each_episode_of_each_copy_has_a_body_of_its_own(overrides: list[str]) -> None:
    ranges = (
        "world.randomize={mass: {pioneer/.*: {scale: 0.5..2}}, sensor_noise: {.*/.*/.*: {range: 0.1..1}}}"
    )
    with closing(make_vec("slalom_pioneer", [*overrides, ranges], num_envs=COPIES, **AGENT)) as envs:
        bodies = []
        for seeds in ([3, 4], [5, 3]):
            seen, _ = envs.reset(seed=seeds)
            for _ in range(3):
                seen, *_ = envs.step({"source:feelers": np.full((COPIES, 1), 200.0)})
            bodies.append(
                [(run.world.randomized, seen["/pioneer/scan"][i]) for i, run in enumerate(envs.runs)]
            )
    (one, two), (three, again) = bodies
    assert one[0] == again[0]
    assert np.array_equal(one[1], again[1])
    assert len({str(one[0]), str(two[0]), str(three[0])}) == 3
    masses = [body.links[0].inertial.mass for body in (run.world.scene.model("pioneer") for run in envs.runs)]
    assert masses[0] != masses[1]
    with closing(make_env("slalom_pioneer", [*overrides, ranges], **AGENT)) as env:
        env.reset(seed=3)
        for _ in range(3):
            alone, *_ = env.step({"source:feelers": np.array([200.0])})
        assert np.array_equal(alone["/pioneer/scan"], one[1])
