"""The Braitenberg experiment as a whole in Gazebo, with the images of Gazebo itself."""

import pytest

from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.run import Run

pytestmark = [pytest.mark.heavy, pytest.mark.usefixtures("gazebo")]
SMALL = ("world.backend=gazebo", "world.options.image_scale=0.2", "duration=24 s")


def result_of(*settings, variant=""):
    with Run(load_experiment(f"braitenberg_husky{variant}", [*SMALL, *settings])) as run:
        run.run()
        return run.result()


def failed(result):
    return {name: outcome.reason for name, outcome in result.criteria.items() if not outcome.passed}


@pytest.mark.parametrize("brain", ["event", "spinnaker"])
def test_the_robot_goes_to_each_screen_that_turns_red_as_gazebo_draws_it(brain):
    result = result_of(f"brain.backend={brain}", "world.options.renderer=gazebo")
    assert not failed(result)
    assert list(result.events) == ["left_red", "right_red", "all_blue"]


def test_it_does_not_where_gazebo_draws_no_red():
    result = result_of("events.left_red.publish.value=Gazebo/BlueGlow", "world.options.renderer=gazebo")
    assert "reaches_left" in failed(result)
