"""Places, rates and times that contradict other values of an experiment are reported; others are not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import nrp_experiments.reaching_arm
import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Finding, Level

Slalom = Callable[[str, str, str], list[Finding]]

HALL, PIONEER, FILE = "slalom_pioneer/hall.sdf", "bodies/pioneer.sdf", "slalom_pioneer/experiment.yaml"
SECOND = "<pose>4.5 -0.8 0.5 0 0 0</pose>"
RATE = "<update_rate>10</update_rate>"
ROBOT = "{model: ../bodies/pioneer.sdf}"
EYE = "[{type: event_camera, link: laser, pose: [0.1, 0, 0, 0, 0, 0], event_camera: {threshold: %s}}]"
RETINA = "[{type: retina, link: laser, pose: [0.1, 0, 0, 0, 0, 0], retina: {baseline: %g}}]"
STATE = "<state world_name='hall'><model name='%s'><pose>5 0 0.5 0 0 0</pose></model></state></world>"
TURNS = "<imu><angular_velocity>%s</angular_velocity></imu>"
NOISE = "<noise type='gaussian'><mean>0</mean><stddev>%g</stddev></noise>"
SPOT = "<light name='l' type='spot'><spot><outer_angle>%g</outer_angle></spot></light></world>"
SCANNER = '<sensor name="scanner" type="ray">'


def imu(stddev: float) -> str:
    axes = "".join(f"<{axis}>{NOISE % stddev}</{axis}>" for axis in "xyz")
    return f'<sensor name="imu" type="imu"><update_rate>100</update_rate>{TURNS % axes}</sensor>{SCANNER}'


def robot(more: str) -> str:
    return ROBOT.replace("}", f", add_sensors: {more}}}")


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("file", "old", "new", "words"),
    [
        (HALL, SECOND, "<pose>2.0 0.0 1.5 0 0 0</pose>", ""),  # one on the other
        (FILE, ROBOT, robot(EYE % 0.5), ""),
        (FILE, ROBOT, robot(RETINA % -5), "the <baseline> of a retina is a rate of 0 Hz or more, not -5"),
        (FILE, ROBOT, robot(RETINA % 0), ""),
        (HALL, "</world>", STATE % "first_pilar", "the <state> of 'first_pilar' has no effect"),
        (HALL, "</world>", STATE % "third_pillar", ""),
        (HALL, "</world>", STATE % "robot_of_the_day", ""),  # it was there when the state was saved
        (PIONEER, SCANNER, imu(0.01), ""),
        (HALL, "</world>", SPOT % 80, "the <outer_angle> of a spot is 80 rad, more than a turn"),
        (HALL, "</world>", SPOT % 1.4, ""),
    ],
)  # fmt: skip
def test_mistakes_in_rooms_and_sensors_are_reported(
    slalom: Slalom, file: str, old: str, new: str, words: str
) -> None:
    found = [one.message for one in slalom(file, old, new) if one.level is not Level.NOTE]
    assert [words in one for one in found] == [True] * bool(words), found


@pytest.mark.one_of(2)
@pytest.mark.parametrize(
    ("z_m", "words"),
    [(-5, "'arm' reaches up to z -4.3 m, which is below 'floor/link/floor'"), (-0.5, ""), (2, "")],
)  # fmt: skip
def test_a_held_robot_below_the_ground_is_reported(z_m: float, words: str) -> None:
    file = Path(nrp_experiments.reaching_arm.__path__[0]) / "experiment.yaml"
    found = validate_file(file, [f"world.robots.arm.pose=[0, 0, {z_m}, 0, 0, 0]"])
    messages = [one.message for one in found if one.code.name == "NRP306"]
    assert [words in one for one in messages] == [True] * bool(words)


CRITERION = "criteria.reaches_left.within_of"


@pytest.mark.parametrize(
    ("settings", "words", "level"),
    [
        (["criteria.turns_on_the_spot.stays_within.during={since: 1.001 s, until: 1.019 s}"],
         "no step of 0.02 s ends in this period", Level.WARNING),
        (["criteria.turns_on_the_spot.stays_within.during={since: 1 s, until: 1.019 s}"], "", Level.WARNING),
    ],
)  # fmt: skip
def test_mistakes_in_times_and_names_of_an_experiment_are_reported(
    husky: Path, settings: list[str], words: str, level: Level
) -> None:
    known = {one.message for one in validate_file(husky / "experiment.yaml")}
    found = [one for one in validate_file(husky / "experiment.yaml", settings) if one.message not in known]
    assert [(words in one.message, one.level) for one in found] == [(True, level)] * bool(words), found
