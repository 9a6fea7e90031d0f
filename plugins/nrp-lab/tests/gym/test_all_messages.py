"""An agent that observes all messages of a fast sensor misses nothing between its steps."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nrp_lab.gym import make_env, make_vec

from nrp_core.errors import ExperimentError

BALL = """
<mujoco model="ball"><worldbody><body name="b"><freejoint/><geom type="sphere" size="0.05" mass="0.5"/>
<site name="s" type="sphere" size="0.051"/></body></worldbody>
<sensor><touch name="touch" site="s" interval="0.0005"/></sensor></mujoco>
"""
ROOM = """
<sdf version="1.9"><world name="w"><model name="ground"><static>true</static>
<link name="l"><collision name="c">
<geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model></world></sdf>
"""
BRAIN = "import nrp_core.pynn as sim\nsim.setup()\nsim.Population(1, sim.IF_curr_exp(), label='cells')\n"
EXPERIMENT = """
name: drop
timestep: 20 ms
duration: 0.6 s
brain: {backend: event, model: brain.py}
world:
  backend: mujoco
  scene: room.sdf
  robots: {ball: {model: ball.xml, pose: [0, 0, 0.95, 0, 0, 0]}}
  options: {timestep: 0.5 ms}
topics: {/flag: std_msgs/Float64}
criteria: {untouched: {topic_stays: {name: /ball/touch, below: 0.001}}}
"""


@pytest.fixture
def drop(tmp_path: Path) -> Path:
    files = {"ball.xml": BALL, "room.sdf": ROOM, "brain.py": BRAIN, "drop.yaml": EXPERIMENT}
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    return tmp_path / "drop.yaml"


def episode(env: Any, name: str) -> tuple[float, float, float, bool]:
    """The largest number seen, the time at the end, the last reward, and whether the episode terminated."""
    observation, _ = env.reset(seed=0)
    largest, terminated, truncated, reward = 0.0, False, False, 0.0
    while not (terminated or truncated):
        observation, reward, terminated, truncated, _ = env.step(env.action_space.sample())
        largest = max(largest, float(np.max(observation[name])))
    return largest, env.unwrapped.run.now_s, float(reward), terminated


@pytest.mark.parametrize(("steps", "rows"), [(1, 40), (3, 120)])
def test_a_touch_between_two_steps_is_observed_and_ends_the_episode(
    drop: Path, steps: int, rows: int
) -> None:
    with make_env(drop, observe=["all:/ball/touch"], act={"/flag": {"data": (0.0, 1.0)}}, steps=steps) as env:
        assert env.observation_space["all:/ball/touch"].shape[0] == rows
        largest, end_s, reward, terminated = episode(env, "all:/ball/touch")
    assert largest > 1
    assert (reward, terminated) == (-1, True), "the criterion is missed in this step"
    assert 0 <= end_s - 0.43 < 0.02 * steps + 1e-9


def test_a_copy_without_actions_shows_its_messages_again_when_another_one_is_reset(drop: Path) -> None:
    name = "all:/ball/touch"
    with closing(make_vec(drop, num_envs=2, observe=[name], steps=28)) as copies:
        copies.reset(seed=1)
        seen = copies.step({})[0][name]
        again, _ = copies.reset(options={"reset_mask": np.array([True, False])})
    assert seen.max() > 1
    assert not again[name][0].any()
    assert np.array_equal(again[name][1], seen[1])


def test_a_topic_without_a_rate_has_no_messages_between_steps(drop: Path) -> None:
    with pytest.raises(ExperimentError, match="has no rate"):
        make_env(drop, observe=["all:/gazebo/model_states"], act={"/flag": {"data": (0.0, 1.0)}})
