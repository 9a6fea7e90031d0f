"""Mistakes that a run passes over in silence are reported with their places, and correct variants are not."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Level


def messages(husky: Path, *overrides: str) -> list[str]:
    """Return the warnings about an experiment, each with its place."""
    found = validate_file(husky / "experiment.yaml", overrides)
    return [str(finding) for finding in found if finding.level is not Level.NOTE]


@pytest.mark.parametrize(("z_m", "found"), [(20, 1), (4, 1), (2, 0), (0.2, 0)])
def test_a_robot_that_starts_in_the_air_is_reported(husky: Path, z_m: float, found: int) -> None:
    said = messages(husky, f"world.robots.husky.pose=[0, 0, {z_m}, 0, 0, 0]")
    expected = f"the robot 'husky' starts at z {z_m} m and falls"
    assert ["NRP306" in message and expected in message for message in said] == [True] * found


def test_an_alias_with_the_name_of_a_topic_is_refused(husky: Path) -> None:
    path = husky / "experiment.yaml"
    path.write_text(path.read_text().replace("aliases:\n", "aliases:\n  /husky/camera: /husky/cmd_vel\n"))
    assert any("experiment.yaml:25:" in message and "/husky/camera" in message for message in messages(husky))


@pytest.mark.parametrize(("after_s", "found"), [(38, 1), (34, 0)])
def test_an_event_that_follows_another_too_late_is_reported(husky: Path, after_s: int, found: int) -> None:
    said = messages(husky, f"events.late={{when: {{event: left_red, after: {after_s} s}}}}")
    expected = f"'late' comes at {5 + after_s} s at the earliest, after 'left_red', and the run ends at 40 s"
    assert [expected in message for message in said] == [True] * found


def test_events_that_wait_in_a_circle_are_reported(husky: Path) -> None:
    said = messages(husky, "events.a={when: {event: b}}", "events.b={when: {event: a}}")
    assert "'a' waits for itself: a -> b -> a" in "\n".join(said)


def test_a_run_that_ends_before_its_first_event_is_reported(husky: Path) -> None:
    assert "'left_red' is at 5 s, and the run ends at 2 s" in "\n".join(messages(husky, "duration=2 s"))


def test_a_slice_that_forgets_the_last_cell_is_reported_at_the_brain(husky: Path) -> None:
    path = husky / "brain.py"
    path.write_text(f"{path.read_text()}\nlast = circuit[6:9]\n")
    (found,) = messages(husky)
    assert "experiment.yaml:12:10:" in found
    assert "NRP308" in found
