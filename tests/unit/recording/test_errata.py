"""A recording of a version with a known fault says whether it may be touched."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from nrp_core._support.packages import fingerprint
from nrp_core.recording.reading.errata import errata_of

RUN: dict[str, Any] = {
    "distributions": {"nrp-core": "0.3.0"},
    "code": {"nrp_core": "0"},
    "settings": {"transfer_functions": ["a.py"], "events": {}, "criteria": {}},
    "world": {"backend": "mujoco"},
    "result": {"problems": []},
}
TOPICS = {"/gazebo/model_states": 51, "/robot/joint_states": 51}


def numbers(folder: Path, topics: dict[str, int] | None = None, **changed: Any) -> list[str]:
    found = errata_of({**RUN, **changed}, folder, topics or TOPICS, 50)
    return [text.partition("(errata ")[2][0] for text in found]


def test_a_recording_that_no_fault_touches_has_no_errata(tmp_path: Path) -> None:
    assert numbers(tmp_path) == []


@pytest.mark.parametrize(
    "changed", [{"distributions": {"nrp-core": "0.4.0"}}, {"code": {"nrp_core": fingerprint("nrp_core")}}]
)
def test_a_recording_of_the_present_code_has_none(tmp_path: Path, changed: dict[str, Any]) -> None:
    two = {"transfer_functions": ["a.py", "b.py"]}
    assert numbers(tmp_path, settings=two) == ["2"]
    assert numbers(tmp_path, settings=two, **changed) == []


def test_a_source_of_current_in_the_brain_is_named(tmp_path: Path) -> None:
    (tmp_path / "experiment").mkdir()
    (tmp_path / "experiment" / "brain.py").write_text("cells.inject(sim.StepCurrentSource(times=[0.5]))")
    (text,) = errata_of(RUN, tmp_path, TOPICS, 50)
    assert "StepCurrentSource" in text
    assert numbers(tmp_path) == ["1"]


def test_a_topic_with_more_messages_than_steps_and_a_criterion_are_named(tmp_path: Path) -> None:
    assert numbers(tmp_path, {**TOPICS, "/imu": 1500}) == ["3"]
    near = {"transfer_functions": [], "criteria": {"arrives": {"near": {"model": "husky"}}}}
    assert numbers(tmp_path, settings=near) == ["3"]


def test_idle_parts_of_a_brain_and_muscles_in_pybullet_are_named(tmp_path: Path) -> None:
    problems = [{"message": "NEST's synapse model 'x' is not supported: replaced by static_synapse"}]
    assert numbers(tmp_path, result={"problems": problems}) == ["5"]
    world = {"backend": "pybullet"}
    assert numbers(tmp_path, {**TOPICS, "/arm/muscles": 51}, world=world) == ["6"]
