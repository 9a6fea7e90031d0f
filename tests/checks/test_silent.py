"""Mistakes that a run passes over in silence are reported with their places, and correct variants are not."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.findings import Finding, Level

FILES = """\
import csv
import json
from pathlib import Path

import numpy as np

LOG = Path("log.txt")


@nrp.MapVariable("rows", initial_value=[])
@nrp.Robot2Neuron()
def keep(t, rows):
    {}
"""
WRITING = [
    "open('log.txt', 'w').write(str(t))",
    "open('log.txt', mode='a').close()",
    "csv.writer(open('log.csv', 'w')).writerow([t])",
    "LOG.open('wb').close()",
    "LOG.write_text(str(t))",
    "np.save('rows.npy', rows.value)",
    "json.dump(rows.value, LOG.open('w'))",
    "rows.value.to_csv('rows.csv')",
]
READING = [
    "print(open('log.txt').read(), open('log.txt', 'rb').read(), LOG.open().read())",
    "print(np.load('rows.npy'), LOG.read_text(), json.dumps(rows.value))",
    "print(rows.value.to_csv())",
    "open = print; open('log.txt', 'w')",
]


def messages(husky: Path, *overrides: str) -> list[str]:
    """Return the warnings about an experiment, each with its place."""
    found = validate_file(husky / "experiment.yaml", overrides)
    return [str(finding) for finding in found if finding.level is not Level.NOTE]


def about_files(husky: Path, body: str) -> list[Finding]:
    (husky / "keep.py").write_text(FILES.format(body))
    found = validate_file(husky / "experiment.yaml", [f"transfer_functions=[{husky}/keep.py]"])
    return [finding for finding in found if finding.code.name == "NRP378"]


@pytest.mark.parametrize("body", WRITING)
def test_a_function_that_writes_a_file_is_told_of_the_recorder(husky: Path, body: str) -> None:
    (finding,) = about_files(husky, body)
    assert finding.line == 13
    assert finding.level is Level.WARNING
    assert "MapCSVRecorder" in finding.message


@pytest.mark.parametrize("body", READING)
def test_a_function_that_only_reads_files_is_not_reported(husky: Path, body: str) -> None:
    assert about_files(husky, body) == []


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
