"""The shipped experiment on real engines: it behaves, it repeats itself, and it can be steered."""

import pytest

from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.result import Result
from nrp_core.experiment.running.run import Run

NAME = "braitenberg_husky"
SMALL_IMAGE = "world.options.image_scale=0.2"
PAIRS = [("event", "mujoco"), ("spinnaker", "pybullet")]  # each backend once
OTHER_PAIRS = [("event", "pybullet"), ("spinnaker", "mujoco")]


def experiment(variant: str = "", *overrides: str) -> Experiment:
    """The experiment with a small image, which costs little and changes nothing in kind."""
    return load_experiment(f"{NAME}{variant}", [SMALL_IMAGE, *overrides])


def result_of(variant: str = "", *overrides: str) -> Result:
    with Run(experiment(variant, *overrides)) as run:
        run.run()
        return run.result()


def failed(result: Result) -> dict[str, str]:
    return {name: outcome.reason for name, outcome in result.criteria.items() if not outcome.passed}


@pytest.mark.parametrize(
    ("brain", "world"), [*PAIRS, *(pytest.param(*pair, marks=pytest.mark.heavy) for pair in OTHER_PAIRS)]
)
def test_the_robot_goes_to_each_screen_that_turns_red_on_every_pair_and_repeats_it_bit_for_bit(
    brain: str, world: str
) -> None:
    overrides = f"brain.backend={brain}", f"world.backend={world}"
    first, second = (result_of("", *overrides, "duration=20 s") for _ in range(2))
    assert not failed(first)
    assert list(first.events) == ["left_red", "right_red", "all_blue"]
    assert first.trajectory_digest == second.trajectory_digest
    assert first.spikes == second.spikes
    assert first.events == second.events


VARIANTS = ["/right_first", "/nrp_gains", "/nrp_gains_right_first"]


@pytest.mark.one_of(6)
@pytest.mark.parametrize("variant", VARIANTS)
def test_every_variant_passes(variant: str) -> None:
    assert not failed(result_of(variant, "duration=20 s"))


@pytest.mark.heavy
@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize(("brain", "world"), [*PAIRS[1:], *OTHER_PAIRS])
def test_every_variant_passes_on_every_other_pair(variant: str, brain: str, world: str) -> None:
    overrides = f"brain.backend={brain}", f"world.backend={world}", "duration=20 s"
    assert not failed(result_of(variant, *overrides))


@pytest.mark.parametrize("variant", ["/no_red", pytest.param("/nrp_gains_no_red", marks=pytest.mark.heavy)])
def test_without_red_it_turns_on_the_spot_for_a_minute(variant: str) -> None:
    result = result_of(variant)
    assert result.sim_time_s == 60.0
    assert not failed(result)


def test_another_seed_gives_another_run_that_passes_too() -> None:
    assert not failed(result_of("", "seed=2", "duration=20 s"))
    one, other = (result_of("", f"seed={seed}", "duration=1 s") for seed in (1, 2))
    assert one.trajectory_digest != other.trajectory_digest


def test_a_screen_turned_red_by_hand_draws_the_robot() -> None:
    with Run(experiment("/no_red")) as run:
        run.run_until(2.0)
        run.publish("/screens/right/color", "red")
        run.run_until(8.0)
        y = run.result().final_pose["husky"]["y"]
    assert y > 2.46 - 1.2  # the right glass stands at y = 2.46 m


def test_how_a_run_is_split_and_paced_makes_no_difference() -> None:
    whole = result_of("", "duration=2 s", "pace=50")
    with Run(experiment("", "duration=2 s")) as run:
        for _ in range(10):
            run.step()
        run.run()
        assert run.result().trajectory_digest == whole.trajectory_digest
