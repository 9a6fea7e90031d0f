"""Observables: the same numbers in criteria, events, recordings, and after a replay."""

from pathlib import Path
from typing import Any

import pytest

import nrp_core
from nrp_core.errors import ExperimentError
from nrp_core.experiment import Run, load_experiment
from nrp_core.experiment.reading.reader import experiment_schema
from nrp_core.observables.condition import Condition, value_in
from nrp_core.recording import FilesRead, Recording, Replay, ReplayRequest

EXPERIMENT = """
name: rolling
timestep: 20 ms
duration: 2 s
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: room.sdf}
observables:
  moved: {displacement: ball}
  bump: {contact: {of: ball, with: wall}}
  firing: {rate: {of: cells, window: 500 ms}}
  high: {height: ball}
  own: {function: {file: measures.py, name: speed}}
events:
  hit: {when: {observable: bump, above: 0.1 N}}
criteria:
  moves: {observable: moved, above: 50 cm, by: 2 s}
  moves_soon: {observable: moved, above: 50 cm, by: 500 ms}
  untouched: {observable: bump, below: 1 mN}
  stays_up: {observable: high, above: 5 cm}
  falls: {observable: high, below: 5 cm, by: hit}
  fires: {observable: firing, between: [20 Hz, 0.4 kHz], for: 500 ms}
  is_slow: {observable: {speed: ball}, below: 1.6 m/s, during: {until: 1 s}}
  is_at_home: {observable: {distance: {of: ball, to: [0, 0]}}, below: 10 cm, by: 1 s}
"""
FILES = {
    "experiment.yaml": EXPERIMENT,
    "measures.py": "def speed(around):\n    return around.world.engine.model_motion('ball').linear[0]\n",
    "brain.py": """
import pyNN.nest as sim
sim.setup(timestep=0.1)
cells = sim.Population(8, sim.IF_curr_exp(i_offset=1.5), label="cells")
""",
    "room.sdf": """<sdf version="1.9"><world name="room"><gravity>1.5 0 -9.8</gravity>
<include><uri>model://ground_plane</uri></include>
<model name="ball"><pose>0 0 0.1 0 0 0</pose><link name="l">
<inertial><mass>1</mass><inertia><ixx>.004</ixx><iyy>.004</iyy><izz>.004</izz></inertia></inertial>
<collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link></model>
<model name="wall"><static>true</static><pose>1 0 0.5 0 0 0</pose><link name="l">
<collision name="c"><geometry><box><size>0.1 2 1</size></box></geometry></collision></link></model>
</world></sdf>""",
}


@pytest.fixture
def experiment(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    return tmp_path / "experiment.yaml"


def test_a_touch_between_two_steps_has_the_same_time_at_every_step_of_the_loop(experiment: Path) -> None:
    found = []
    for step in ("20 ms", "10 ms", "2 ms"):
        result = nrp_core.run(experiment, [f"timestep={step}"])
        met = {name: one.passed for name, one in result.criteria.items()}
        found.append((result.events["hit"], result.criteria["untouched"].decided_s, met))
    assert found[0] == found[1] == found[2]
    hit_s, failed_s, met = found[0]
    assert hit_s == failed_s == pytest.approx(1.262, abs=0.01)
    assert met == {
        "moves": True, "moves_soon": False, "untouched": False, "stays_up": True, "falls": False,
        "fires": True, "is_slow": True, "is_at_home": True,
    }  # fmt: skip


def test_a_recording_has_the_observables_and_a_replay_the_same(experiment: Path, tmp_path: Path) -> None:
    result = nrp_core.run(experiment, record=tmp_path / "r", snapshots_s=0.5)
    assert result.criteria["is_at_home"].reason.endswith("it holds at the start, so it proves nothing")
    recording = Recording(tmp_path / "r")
    moved = [one.message.data for one in recording.messages({"/observables/moved"})]
    assert (len(moved), moved[0]) == (101, 0.0)
    assert 0.8 < max(moved) < 0.86
    assert {topic for topic in recording.topics if topic.startswith("/observables/")} == {
        f"/observables/{name}" for name in ("moved", "bump", "firing", "high", "own")
    }
    for from_ns in (None, 1_000_000_000):
        request = ReplayRequest(from_ns=from_ns)
        with FilesRead() as files, Replay(recording, request, files=files) as again:
            assert again.go().difference is None


@pytest.mark.parametrize(
    ("written", "instead", "message"),
    [
        ("observable: moved, above: 50 cm, by: 2 s", "observable: movd, above: 1", "did you mean 'moved'"),
        ("above: 50 cm, by: 2 s", "above: 3 Hz", "'3 Hz' is not in m"),
        ("{displacement: ball}", "{displacment: ball}", "no observable of kind 'displacment'"),
        ("{displacement: ball}", "{displacement: bal}", "'bal'"),
        ("{displacement: ball}", "{displacement: [ball, [0, 0], 1]}", "3 arguments for of, from"),
        ("{displacement: ball}", "{displacement: {of: ball, from: [1 kg, 0]}}", "'kg' is not a unit"),
        ("{displacement: ball}", "{joint: {name: ball/a, of: sped}}", "'position', 'velocity' or 'effort'"),
        ("window: 500 ms", "window: 500", "a time needs a unit"),
        ("above: 50 cm, by: 2 s", "above: [1]", r"not a number: \[1\]"),
        ("with: wall", "wth: wall", "no argument 'wth'; did you mean 'with'"),
        ("name: speed", "name: sped", "no function 'sped'"),
        (
            "above: 50 cm, by: 2 s",
            "above: 1, within_of: {event: hit, time: 1 s}",
            "'within_of' goes with 'near'",
        ),
        ("above: 50 cm, by: 2 s", "by: 2 s", "needs 'above', 'below', 'between' or 'equals'"),
        ("above: 50 cm, by: 2 s", "above: 1, by: hti", "no event 'hti'; did you mean 'hit'"),
    ],
)
def test_a_mistake_is_refused_with_its_name(
    experiment: Path, written: str, instead: str, message: str
) -> None:
    experiment.write_text(experiment.read_text().replace(written, instead, 1))
    with pytest.raises(ExperimentError, match=message), Run(load_experiment(experiment)):
        pass


@pytest.mark.parametrize(
    ("condition", "value", "holds", "gap"),
    [
        (Condition(above=1.0), 1.0, False, 0.0),
        (Condition(above=1.0, below=3.0), 2.5, True, -0.5),
        (Condition(1.0, 3.0, reaches=True), 3.0, True, 0.0),
        (Condition(below=3.0), float("nan"), False, None),
        (Condition(equals="on"), "off", False, float("inf")),
        (Condition(equals=True), True, True, float("-inf")),
        (Condition(above=0.0), None, False, None),
    ],
)
def test_a_condition_holds_in_its_range(
    condition: Condition, value: Any, holds: bool, gap: float | None
) -> None:
    assert condition.holds(value) is holds
    if gap is not None:
        assert condition.gap(value) == gap


def test_a_bound_may_have_another_unit_of_the_same_kind() -> None:
    assert (value_in("20 cm", "m"), value_in("0.4 kHz", "Hz"), value_in(3, "N")) == (0.2, 400.0, 3.0)
    with pytest.raises(ExperimentError, match="cannot be converted"):
        value_in("20 cm", "N")


def test_the_schema_has_each_kind_with_its_arguments() -> None:
    named = experiment_schema()["properties"]["observables"]["patternProperties"]
    ((observables, _null),) = (each["anyOf"] for each in named.values())
    forms = {kind: form["anyOf"][0] for kind, form in observables["properties"].items()}
    assert not observables["additionalProperties"]
    assert set(forms) >= {"contact", "displacement", "distance", "function", "height", "joint", "rate"}
    assert list(forms["contact"]["properties"]) == ["of", "with"]
    assert forms["joint"]["properties"]["of"]["enum"] == ["position", "velocity", "effort"]


@pytest.mark.one_of(2)
@pytest.mark.parametrize("world", ["mujoco", "pybullet"])
def test_a_loop_at_60_hz_says_what_was_rounded_and_is_replayed(
    experiment: Path, tmp_path: Path, world: str
) -> None:
    changes = ["timestep=1/60 s", f"world.backend={world}"]
    with Run(load_experiment(experiment, changes)) as run:
        assert run.world.capabilities.step_ns == 1_670_000
        (note,) = [one for one in run.problems if one.code.name == "NRP372"]
    assert note.message.endswith(
        "timestep: '1/60 s' is rounded to 16.7 ms, and the duration to 2.004 s, 120 steps; the physics step "
        "is 1.67 ms, not 2 ms"
    )
    result = nrp_core.run(experiment, changes, record=tmp_path / "r")
    assert (result.sim_time_s, result.steps) == (2.004, 120)
    with FilesRead() as files, Replay(Recording(tmp_path / "r"), ReplayRequest(), files=files) as again:
        assert again.go().difference is None
