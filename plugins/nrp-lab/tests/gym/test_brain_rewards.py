"""The reward of an environment changes the weights of its brain, episode after episode."""

from collections.abc import Iterator
from contextlib import closing
from math import exp
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden
from nrp_lab.gym import NrpEnv, make_env, make_vec

import nrp_core.dsl as nrp
from nrp_core.errors import ExperimentError

TAU_C, TAU_D = 1000.0, 100.0
BRAIN = f"""\
import nrp_core.pynn as sim

sim.setup(timestep=0.1)
eyes = sim.Population(1, sim.SpikeSourceArray(spike_times=[10.0]), label="eyes")
drive = sim.Population(1, sim.SpikeSourceArray(spike_times=[14.0]), label="drive")
critic = sim.Population(1, sim.SpikeSourceArray(spike_times=[]), label="critic")
cells = sim.Population(1, sim.IF_curr_delta(), label="cells")
each = sim.OneToOneConnector()
sim.Projection(drive, cells, each, sim.StaticSynapse(weight=50.0, delay=1.0), label="driving")
rule = sim.STDPMechanism(
    timing_dependence=sim.SpikePairRule(tau_plus=20.0, tau_minus=20.0, A_plus=0.01, A_minus=0.01),
    weight_dependence=sim.AdditiveWeightDependence(w_min=0.0, w_max=1.0),
    weight=1.0,
    delay=1.0,
)
sim.Projection(eyes, cells, each, rule, label="learned")
dopamine = sim.Neuromodulation(weight=0.1, tau_c={TAU_C}, tau_d={TAU_D}, w_max=20.0)
sim.Projection(critic, cells, each, dopamine, receptor_type="reward", label="rewards")
"""
EXPERIMENT = """\
name: rewards
duration: 200 ms
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: floor.sdf}
"""
FLOOR = """\
<sdf version="1.6"><world name="floor"><model name="box"><static>true</static><link name="link">
  <collision name="all"><geometry><box><size>1 1 1</size></box></geometry></collision>
</link></model></world></sdf>
"""
LEARNED = nrp.MapReward("reward", nrp.brain.projection("learned"))


@pytest.fixture
def settings(tmp_path: Path) -> Iterator[dict[str, Any]]:
    """The arguments of an environment whose first step of 40 ms in five is rewarded by 0.5."""
    for name, text in {"brain.py": BRAIN, "experiment.yaml": EXPERIMENT, "floor.sdf": FLOOR}.items():
        (tmp_path / name).write_text(text)
    return {
        "experiment": tmp_path / "experiment.yaml", "observe": ["motion:box"], "steps": 2,
        "reward": lambda run, seen: 0.5 if run.loop.now_ns == 40_000_000 else 0.0, "reward_to": LEARNED,
    }  # fmt: skip


def weight(env: NrpEnv) -> float:
    return float(env.run.brain.read_weights("learned")[0])


def change(reward: float, since_ms: float, until_ms: float) -> float:
    """Return the change of the weight; dopamine acts after 1 ms, the pair is that of 10 and 15 ms."""
    eligibility = 0.01 * exp(-6 / 20) * exp(-(since_ms + 1 - 16) / TAU_C)
    fade = 1 / TAU_C + 1 / TAU_D
    return eligibility * reward * (1 - exp(-(until_ms - since_ms - 1) * fade)) / fade


@pytest.mark.parametrize("same_noise", [False, True])
def test_the_brain_learns_from_the_reward_over_the_episodes(
    settings: dict[str, Any], same_noise: bool
) -> None:
    rest = 5 * TAU_D
    with closing(make_env(**settings, same_noise=same_noise)) as env:
        for episode in range(3):
            env.reset(seed=1)
            began = 1.0 + episode * change(0.5, 40, 200 + rest)
            assert weight(env) == pytest.approx(began, rel=1e-9)
            for step in range(5):
                *_, truncated, _ = env.step({})
                assert weight(env) == pytest.approx(
                    began + change(0.5, 40, 40 + 40 * step) * (step > 0), rel=1e-9
                )
            assert truncated


def test_the_reward_of_the_last_step_acts_before_the_next_episode(settings: dict[str, Any]) -> None:
    settings["reward"] = lambda run, seen: -0.5 * (run.loop.now_ns == 200_000_000)
    with closing(make_env(**settings)) as env:
        env.reset(seed=1)
        for _ in range(5):
            env.step({})
        assert weight(env) == 1.0
        env.reset()
        assert weight(env) == pytest.approx(1.0 + change(-0.5, 200, 200 + 5 * TAU_D), rel=1e-9)


def test_a_baseline_continues_over_the_episodes(settings: dict[str, Any]) -> None:
    """A reward that is always the same teaches less and less."""
    settings["reward_to"] = nrp.MapReward("reward", nrp.brain.projection("learned"), baseline=5)
    settings["reward"] = lambda run, seen: 0.5
    changes = []
    with closing(make_env(**settings)) as env:
        env.reset(seed=1)
        for _ in range(12):
            before = weight(env)
            for _ in range(5):
                env.step({})
            env.reset()
            changes.append(weight(env) - before)
    assert (np.diff(changes) < 0.0).all()
    assert 0.0 < changes[-1] < 1e-4 * changes[0]


@pytest.mark.heavy
@pytest.mark.parametrize("processes", [1, 2])
def test_each_copy_learns_alone(settings: dict[str, Any], processes: int) -> None:
    settings |= {"num_envs": 2, "processes": processes, "autoreset_mode": "Disabled"}
    settings["terminate"] = lambda run, seen: run.brain.read_weights("learned")[0] > 1.3
    first = {"reset_mask": np.array([True, False])}
    with closing(make_vec(**settings)) as envs:
        envs.reset(seed=1)
        for _ in range(5):
            *_, terminated, truncated, _ = envs.step({})
        assert (terminated.tolist(), truncated.tolist()) == ([False, False], [True, True])
        envs.reset(options=first)  # it rests, and has learned enough
        envs.reset(options={"reset_mask": ~first["reset_mask"]}, seed=[None, 5])
        assert envs.step({})[2].tolist() == [True, True]
        if processes == 1:
            for run in envs.runs:
                learned = run.brain.read_weights("learned")[0]
                assert learned == pytest.approx(1.0 + change(0.5, 40, 200 + 5 * TAU_D), rel=1e-9)


@pytest.mark.parametrize(
    ("reward_to", "message"),
    [
        (nrp.MapReward("reward", nrp.brain.projection("learnt")), "no projection 'learnt'"),
        (nrp.MapReward("reward", nrp.brain.projection("driving")), "'driving'.*STDP"),
        ("learned", "reward_to.*'learned'.*MapReward"),
    ],
)
def test_a_brain_that_cannot_learn_from_it_is_refused(
    settings: dict[str, Any], reward_to: Any, message: str, golden: Golden
) -> None:
    with golden.raises(ExperimentError, match=message):
        make_env(**settings | {"reward_to": reward_to})
