"""PyBullet's joints are read once after their steps, however often their states are wanted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from chains import chain, command

from nrp_core.scene.model import Scene
from nrp_core.scene.rigid import JointStates
from nrp_core.world.backends import worlds

pytest.importorskip("nrp_world_pybullet")
from nrp_world_pybullet.library import bullet

STEPS = 10  # of 2 ms


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> Callable[[], int]:
    """Return how often PyBullet was asked for the states of joints since the last call."""
    ask, asked = bullet.getJointStates, []
    monkeypatch.setattr(bullet, "getJointStates", lambda *given: asked.append(None) or ask(*given))

    def count() -> int:
        number = len(asked)
        asked.clear()
        return number

    return count


def test_states_and_efforts_of_a_step_are_read_once(read: Callable[[], int]) -> None:
    backend = worlds().load("pybullet")
    with backend.open(Scene((chain(),)), seed=1, options=backend.options()) as world:
        command(world, 0.5)
        world.run_until(20_000_000)
        read()
        before, after = _wanted(world), _stepped(world)
        assert read() == STEPS + 1, "the servo reads before each step, everything else shares one reading"
        assert (before.positions != after.positions).any()
        assert after.efforts.any()
        world.set_joints("chain", {"j0": 0.1})
        assert world.joint_states("chain").positions[0] == pytest.approx(0.1)


def _stepped(world: Any) -> JointStates:
    world.run_until(40_000_000)
    return _wanted(world)


def _wanted(world: Any) -> JointStates:
    return [world.joint_states("chain") for _ in range(3)][-1]
