"""Conditions that the limits of a field, or the walls of a room, decide are reported; others are not."""

from __future__ import annotations

from pathlib import Path

import nrp_experiments.slalom_pioneer
import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Level

_SLALOM = Path(nrp_experiments.slalom_pioneer.__path__[0]) / "experiment.yaml"
_ODOM = "/pioneer/odom, field: pose.pose"


def _said(override: str) -> list[str]:
    found = validate_file(_SLALOM, [override])
    return [str(one) for one in found if one.level is not Level.NOTE]


def _of_criterion(condition: str) -> list[str]:
    return _said(f"criteria.mine={{topic_stays: {{name: {condition}}}}}")


@pytest.mark.parametrize(
    ("condition", "words"),
    [
        (
            "/pioneer/scan, field: range_min, above: 0.05",
            "'range_min' of /pioneer/scan is a setting of the sensor",
        ),
        (f"{_ODOM}.orientation.z, below: 1.57", "from -1 to 1: the condition is always met"),
        (f"{_ODOM}.orientation.z, above: 1.57", "from -1 to 1: the condition is never met"),
        (f"{_ODOM}.position.x, above: 4500", "a scene that is 11.7 m across: the condition is never met"),
    ],
)
def test_a_condition_that_the_field_decides_is_reported(condition: str, words: str) -> None:
    (message,) = _of_criterion(condition)
    assert words in message


@pytest.mark.parametrize(
    "condition",
    [
        "/pioneer/clearance, above: 0.2",
        "/pioneer/clearance, equals: 0.3",  # a function may send just this number
        f"{_ODOM}.orientation.z, below: 0.7",
        f"{_ODOM}.position.x, above: -0.5",
        "/pioneer/odom, field: twist.twist.angular.z, equals: 0",  # it stands still
        "/pioneer/scan, field: header.frame_id, equals: pioneer/laser",
    ],
)
def test_a_condition_that_the_run_decides_is_not_reported(condition: str) -> None:
    assert _of_criterion(condition) == []


@pytest.mark.parametrize(
    ("point", "within", "is_reported"),
    [
        ((4.5, -0.8), "20 cm", True),  # the middle of a pillar with a radius of 25 cm
        ((4.5, -0.8), "60 cm", False),
        ((4.5, -0.4), "20 cm", False),
        ((4.25, 1.65), "4 cm", True),  # the middle of a wall 10 cm thick
        ((4.25, 1.4), "20 cm", False),
    ],
)
def test_a_place_inside_a_wall_is_reported(
    point: tuple[float, float], within: str, is_reported: bool
) -> None:
    said = _said(f"criteria.gets_through.near={{model: pioneer, point: {list(point)}, within: {within}}}")
    assert [("m inside '" in one) for one in said] == [True] * is_reported
