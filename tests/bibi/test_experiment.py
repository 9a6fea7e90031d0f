"""The paper's experiment from models instead of Python, on real engines."""

from __future__ import annotations

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.result import Result
from nrp_core.experiment.running.run import Run

NAME = "braitenberg_husky"
PAIR = ["brain.backend=spinnaker", "world.backend=mujoco", "world.options.image_scale=0.2"]


def result_of(variant: str, *overrides: str) -> Result:
    with Run(load_experiment(f"{NAME}{variant}", [*PAIR, *overrides])) as run:
        run.run()
        return run.result()


@pytest.fixture(scope="module")
def printed() -> Result:
    return result_of("", "duration=16 s")


def test_models_and_printed_listings_give_the_identical_run(printed: Result) -> None:
    models = result_of("/bibi", "duration=16 s")
    assert models.trajectory_digest == printed.trajectory_digest
    assert models.spikes == printed.spikes
    assert all(outcome.passed for outcome in models.criteria.values())


def test_both_levels_in_one_experiment_give_the_identical_run(printed: Result) -> None:
    mixed = result_of("/mixed_levels", "duration=16 s")
    assert mixed.trajectory_digest == printed.trajectory_digest


@pytest.mark.one_of(2)
@pytest.mark.parametrize("variant", ["/bibi", "/mixed_levels"])
def test_the_loop_sees_no_difference_before_the_run_either(variant: str) -> None:
    findings = validate_file(f"{NAME}{variant}")
    assert [finding.code.name for finding in findings] == ["NRP238"]
