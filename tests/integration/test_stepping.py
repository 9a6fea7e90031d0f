"""Legs with muscles walk in a rhythm of their spinal cord, whose phase their afferents reset."""

from __future__ import annotations

import pytest

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run


def outcome(name: str, *overrides: str) -> tuple[bool, float, float]:
    """Return whether a run passed, the way that the legs went (m), and the shift of the phase (periods)."""
    with Run(load_experiment(name, overrides)) as run:
        advance = run.world.subscribe("/rhythm/advance")
        run.run()
        result = run.result()
        shift = advance.latest.message.data if advance.latest else float("nan")
        return result.passed is True, run.world.joint_states("legs").positions[0], shift


@pytest.mark.parametrize(
    ("brain", "world"),
    [
        ("event", "mujoco"),
        pytest.param("event", "pybullet", marks=pytest.mark.heavy),
        pytest.param("spinnaker", "mujoco", marks=pytest.mark.heavy),
    ],
)
def test_a_pull_at_the_hip_resets_the_rhythm_of_walking_legs(brain: str, world: str) -> None:
    passed, way, shift = outcome("stepping_legs", f"brain.backend={brain}", f"world.backend={world}")
    assert passed
    assert way > 3.0
    assert shift > 0.04


def test_without_afferents_the_rhythm_keeps_its_phase() -> None:
    passed, _, shift = outcome("stepping_legs/without_afferents")
    assert passed
    assert abs(shift) < 0.03


@pytest.mark.heavy
@pytest.mark.parametrize("brain", ["event", "spinnaker"])
@pytest.mark.parametrize("world", ["mujoco", "pybullet"])
@pytest.mark.parametrize("name", ["stepping_legs", "stepping_legs/without_afferents"])
def test_every_seed_passes_but_one_on_a_grid_of_1_ms(brain: str, world: str, name: str) -> None:
    backends = f"brain.backend={brain}", f"world.backend={world}"
    failed = [n for n in range(1, 21) if not outcome(name, f"seed={n}", *backends)[0]]
    assert len(failed) <= (brain == "spinnaker")
