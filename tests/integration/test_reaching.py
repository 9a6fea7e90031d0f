"""The arm whose motors are too weak: its cerebellum learns to reach, by its parallel fibres."""

from __future__ import annotations

import pytest

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

REACH_STEPS, TARGETS = 100, 4


def misses_m(*overrides: str) -> tuple[list[float], float]:
    """Return the miss of each reach but the last, and the degree to which the criterion was met."""
    with Run(load_experiment("reaching_arm", overrides)) as run:
        heard, misses = run.world.subscribe("/arm/miss"), []
        for step in range(1, run.experiment.duration // run.experiment.timestep + 1):
            run.step()
            if step % REACH_STEPS == REACH_STEPS // 2 and heard.latest is not None:
                misses.append(heard.latest.message.data)
        degree = run.result().criteria["reaches_the_targets"].degree
    assert degree is not None
    return misses, degree


def test_the_hand_misses_at_first_and_reaches_the_targets_after_learning() -> None:
    misses, degree = misses_m()
    assert max(misses[:TARGETS]) > 0.08
    assert max(misses[-TARGETS:]) < 0.05
    assert degree > 0.8


@pytest.mark.heavy
def test_without_parallel_fibres_it_does_not_learn() -> None:
    misses, degree = misses_m("brain.interventions=[{silence: granules}]")
    assert max(misses[-TARGETS:]) > 0.08
    assert degree < 0.5
