"""Commands on topics in many copies: bit for bit those of single environments, and without a message each."""

from collections.abc import Callable, Iterator
from contextlib import closing
from cProfile import Profile
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from golden import Golden
from nrp_lab.gym import NrpEnv, NrpVectorEnv, make_env, make_vec

from nrp_core.errors import TopicError
from nrp_core.messages.geometry_msgs import Twist, Vector3

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
MOST_CALLS = 228
"""Calls of functions, built-in ones included, in a step of one more copy; with a message for each: 239."""
MOST_CALLS_MORE = 65
"""In a step of an environment than in a step of the run; with a message that is built and checked: 78."""
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


def test_commands_beyond_their_bounds_are_clipped_in_copies(copies: NrpVectorEnv, single: NrpEnv) -> None:
    beyond = COMMANDS * 100.0
    copies.reset(seed=4)
    with pytest.warns(UserWarning, match=r"'linear\.x' of the action '/husky/cmd_vel' is 50; it is clipped"):
        together = driven(copies, beyond)
    for number in range(COPIES):
        single.reset(seed=4 + number)
        alone = driven(single, np.clip(beyond[:, number], [-1, -2], [1, 2]))
        assert np.array([rows[number] for rows in together]).tobytes() == np.array(alone).tobytes()


@pytest.mark.parametrize(("forward", "turn"), [(0.5, float("nan")), (float("inf"), 0.0)])
def test_a_command_that_is_not_a_number_is_refused_in_copies(
    copies: NrpVectorEnv, forward: float, turn: float, golden: Golden
) -> None:
    copies.reset(seed=4)
    with golden.raises(TopicError):
        driven(copies, np.array([[[0.1, 0.0], [0.1, 0.0], [forward, turn]]]))


def calls_in(call: Callable[[], object]) -> int:
    """Return the number of calls of functions, those of built-in ones included.

    A hook in Python would be given the frames that Numba makes up for compiled functions, and would read and
    write their variables; the profiler in C, which Numba supports, does neither.
    """
    profile = Profile()
    profile.runcall(call)
    return sum(entry.callcount for entry in profile.getstats())


@pytest.mark.parametrize("others", [False, True])
def test_a_command_by_its_numbers_moves_the_robot_as_a_message_does(single: NrpEnv, others: bool) -> None:
    """Whether others see the messages, as in a recording, or not."""
    seen: list[Any] = []

    def note(topic: str, stamped: Any) -> None:
        seen.append((topic, stamped.message.linear.x))

    single.reset(seed=4)
    if others:
        single.run.world.add_observer(note)
    by_numbers = driven(single, COMMANDS[:, 2])
    if others:
        single.run.world.remove_observer(note)
        assert seen == [("/husky/cmd_vel", forward) for forward in COMMANDS[:, 2, 0].tolist()]
    single.reset(seed=4)
    publication = single.run.world.advertise("/husky/cmd_vel")
    for (forward, turn), row in zip(COMMANDS[:, 2].tolist(), by_numbers, strict=True):
        publication.publish(Twist(Vector3(forward), Vector3(z=turn)))
        single.run.step()
        by_message = np.empty(13)
        single.run.world.engine.read_motion("husky", by_message)
        assert by_message.tobytes() == row.tobytes()


def test_a_step_makes_few_calls_more_than_a_step_of_the_run(single: NrpEnv) -> None:
    single.reset(seed=4)
    actions = [{"/husky/cmd_vel": command} for command in COMMANDS[:, 0]]
    single.step(actions[0])
    # the fewest of several: not every step has an image, and some do what is done once
    alone = min(calls_in(single.run.step) for _ in range(4))
    together = min(calls_in(lambda: single.step(actions[1])) for _ in range(4))
    assert together - alone < MOST_CALLS_MORE, together - alone


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


CRAWLER = """<mujoco><option timestep="0.005"/>
  <worldbody><geom name="floor" type="plane" size="9 9 0.1"/>
    <body name="trunk" pos="0 0 0.3"><freejoint/><geom size="0.2" mass="2"/>
      <body name="left" pos="0 0.2 0">
        <joint name="left_hip" axis="0 1 0" range="-90 90" limited="true" damping="0.1"/>
        <geom type="capsule" size="0.05" fromto="0 0 0 0.4 0.1 -0.2"/></body>
      <body name="right" pos="0 -0.2 0"><joint name="right_hip" axis="0 1 0" damping="0.1"/>
        <geom type="capsule" size="0.05" fromto="0 0 0 0.4 -0.1 -0.2"/></body>
    </body></worldbody>
  <actuator><motor joint="left_hip" gear="5" ctrllimited="true" ctrlrange="-1 1"/>
    <motor joint="right_hip" gear="5"/></actuator></mujoco>"""
BRAIN = """
from nrp_core import pynn as sim
sim.setup(timestep=0.5)
circuit = sim.Population(1, sim.IF_curr_exp())
"""
EXPERIMENT = """
name: crawler
duration: 1 s
timestep: 20 ms
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: crawler.xml, options: {timestep: 5 ms}}
"""
MOTORS: dict[str, Any] = {
    "observe": ["motion:trunk", "joints:trunk"],
    "act": {f"/trunk/{joint}/cmd_effort": {"data": (-8.0, 8.0)} for joint in ("left_hip", "right_hip")},
}


@pytest.fixture
def crawler(tmp_path: Path) -> Path:
    files = {"crawler.xml": CRAWLER, "brain.py": BRAIN, "experiment.yaml": EXPERIMENT}
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    return tmp_path / "experiment.yaml"


def efforts_of(rows: Any) -> dict[str, Any]:
    return {name: rows[..., [place]] for place, name in enumerate(MOTORS["act"])}


@pytest.mark.filterwarnings("ignore:.*is clipped to its bounds", "ignore:.*beyond the limit")
def test_motors_of_copies_move_as_alone_and_as_in_mujoco_itself(crawler: Path) -> None:
    draw = np.random.default_rng(2)
    efforts = draw.uniform(-4, 4, (12, COPIES, 2))
    efforts[3, 1], efforts[7, 2] = (7.0, -7.0), (0.0, 30.0)  # beyond the limit of a motor, and the bounds
    with closing(make_vec(crawler, num_envs=COPIES, threads=1, **MOTORS)) as envs:
        envs.reset(seed=1)
        together = [envs.step(efforts_of(rows))[0] for rows in efforts]
        ends = [run.snapshot() for run in envs.runs]
    with closing(make_env(crawler, **MOTORS)) as env:
        for number in range(COPIES):
            env.reset(seed=1 + number)
            alone = [env.step(efforts_of(rows[number]))[0] for rows in efforts]
            for name in MOTORS["observe"]:
                found = np.array([seen[name][number] for seen in together])
                assert found.tobytes() == np.array([seen[name] for seen in alone]).tobytes()
            env.run.step()
            continued = env.run.world.joint_states("trunk").positions.copy()
            env.run.restore(ends[number])  # with the commands that hold
            env.run.step()
            assert env.run.world.joint_states("trunk").positions.tobytes() == continued.tobytes()
    model = mujoco.MjModel.from_xml_string(CRAWLER)
    for number in range(COPIES):
        data = mujoco.MjData(model)
        for rows in efforts:
            data.ctrl[:] = np.clip(rows[number], -8.0, 8.0) / 5.0  # MuJoCo clips the first one again
            mujoco.mj_step(model, data, 4)
        assert together[-1]["joints:trunk"][number] == pytest.approx(
            np.r_[data.qpos[7:], data.qvel[6:]], abs=1e-9
        )
        assert together[-1]["motion:trunk"][number, :3] == pytest.approx(data.qpos[:3], abs=1e-9)


def test_steps_of_more_copies_are_not_calls_of_the_engine(
    crawler: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One copy has data of its own; all others take their steps, and obey, by one call."""
    with closing(make_vec(crawler, num_envs=8, threads=1, **MOTORS)) as envs:
        envs.reset(seed=1)
        rows = efforts_of(np.ones((8, 2)))
        envs.step(rows)
        calls: list[int] = []
        step = mujoco.mj_step
        monkeypatch.setattr(mujoco, "mj_step", lambda *given: (calls.append(1), step(*given)))
        envs.step(rows)
        assert len(calls) == 1
