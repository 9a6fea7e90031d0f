"""The evolved slalom passes from places and with noise that its search did not have, on two engines."""

from pathlib import Path

import pytest
from nrp_lab.sweep import sweep

SEARCHED = range(1, 17)
FRESH = range(101, 121)
LEAST = 19


def passed(world: str, seeds: list[int], folder: Path) -> int:
    table = sweep(
        {
            "experiment": "slalom_pioneer/evolved",
            "settings": {"world.backend": world},
            "vary": {"world.robots.pioneer.pose.1": "-0.3..0.3", "seed": seeds},
        },
        folder,
        workers=1,
    )
    assert list(table["state"]) == ["finished"] * len(seeds)
    return int(table["passed"].sum())


@pytest.mark.heavy
@pytest.mark.slow
@pytest.mark.parametrize("world", ["mujoco", "pybullet"])
def test_it_turns_in_time_just_right_of_the_middle_of_a_pillar(world: str, tmp_path: Path) -> None:
    """With this seed it starts at -0.108 m, where it is hard to decide for a side."""
    assert passed(world, [109], tmp_path) == 1


@pytest.mark.heavy
@pytest.mark.parametrize("world", ["mujoco", "pybullet"])
def test_it_passes_with_fresh_seeds(world: str, tmp_path: Path) -> None:
    assert not set(FRESH) & set(SEARCHED)
    assert passed(world, list(FRESH), tmp_path) >= LEAST
