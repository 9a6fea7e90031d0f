"""The experiments with other bodies than the Husky, on real engines: each does what it is for."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import nir
import numpy as np
import pytest
from nrp_experiments import slalom_pioneer

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

PAIRS = [("event", "mujoco"), ("spinnaker", "mujoco"), ("event", "pybullet")]
QUICK = {"slalom_pioneer", "following_head"}
"""The experiments that every pair runs each time, and the first pair the others."""
SHORT = {
    "slalom_pioneer": ("duration=26 s",),
    "slalom_pioneer/trained": (),
    "walking_hexapod": ("duration=9 s",),
    "hovering_quadrotor": ("duration=6 s",),
    "following_head": ("duration=6 s", "world.options.image_scale=0.2"),
}


def opened(name: str, *overrides: str) -> Run:
    return Run(load_experiment(name, [*SHORT[name], *overrides]))


@pytest.fixture(params=["mujoco", "pybullet"])
def engine(request: pytest.FixtureRequest) -> str:
    if importlib.util.find_spec(request.param) is None:
        pytest.skip(f"{request.param} is not installed")
    return str(request.param)


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("brain", "world", "name"),
    [
        pytest.param(*pair, name, marks=() if name in QUICK or pair == PAIRS[0] else pytest.mark.heavy)
        for pair in PAIRS
        for name in SHORT
    ],
)
def test_each_body_does_what_it_is_for_with_every_brain(brain: str, world: str, name: str) -> None:
    pytest.importorskip(world)
    with opened(name, f"brain.backend={brain}", f"world.backend={world}") as run:
        run.run()
        result = run.result()
    assert {key: outcome.reason for key, outcome in result.criteria.items() if not outcome.passed} == {}
    assert result.problems == []


def test_a_two_wheeler_that_feels_nothing_does_not_get_through() -> None:
    with opened("slalom_pioneer", "world.sensors={/pioneer/scan: {drop_out: 1}}") as run:
        run.run()
        result = run.result()
    assert not result.criteria["gets_through"].passed
    assert result.final_pose["pioneer"]["x"] < 2.0  # at the first pillar


def test_a_trained_network_with_crossed_wheels_touches_a_pillar(tmp_path: Path) -> None:
    (shipped,) = Path(slalom_pioneer.__file__).parent.glob("*.nir")
    graph = nir.read(shipped)
    wheels = graph.nodes["to wheels"]
    crossed = np.roll(np.arange(len(wheels.bias)), len(wheels.bias) // 2)
    graph.nodes["to wheels"] = nir.Affine(wheels.weight[crossed], wheels.bias[crossed])
    nir.write(tmp_path / "crossed.nir", graph)
    with opened("slalom_pioneer/trained", f"brain.model={tmp_path / 'crossed.nir'}", "duration=8 s") as run:
        run.run()
        assert not run.result().criteria["touches_nothing"].passed


@pytest.mark.one_of(3)
def test_legs_that_are_neighbours_take_turns(engine: str) -> None:
    """In the order left front, middle, rear, right front, middle, rear; the gait has settled by 4 s."""
    with opened("walking_hexapod", f"world.backend={engine}") as run:
        run.run_until(4.0)
        lifted = []
        for _ in range(200):
            run.step()
            states = run.world.joint_states("hexapod")
            lifted.append(
                [q for name, q in zip(states.names, states.positions, strict=True) if "beta" in name]
            )
    together = np.corrcoef(np.array(lifted), rowvar=False)
    tripod = np.array([1, -1, 1, -1, 1, -1])
    assert (np.sign(together) == np.outer(tripod, tripod)).all()
    assert abs(together).min() > 0.4


def test_the_head_turns_to_and_fro_with_the_ball(engine: str) -> None:
    with opened("following_head", f"world.backend={engine}") as run:
        angles = []
        for _ in range(200):
            run.step()
            states = run.world.joint_states("pan_tilt")
            angles.append(dict(zip(states.names, states.positions, strict=True))["pan"])
    assert max(angles) > 0.15
    assert min(angles) < -0.15
