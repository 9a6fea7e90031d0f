"""Transfer functions run for a few steps between mocks in a confined process: what they raise is found."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden import Golden

from nrp_core._support.probe import ChildResult
from nrp_core.checks import confined_functions
from nrp_core.checks.dry_engine import DryEngine
from nrp_core.checks.validate import validate_file
from nrp_core.dsl.testing import MockWorld
from nrp_core.experiment.making.prepare import make_parts
from nrp_core.experiment.reading.find import load_experiment, shipped
from nrp_core.findings import Code, Finding, Level
from nrp_core.messages.sensor_msgs import Image, JointState, LaserScan
from nrp_core.messages.std_msgs import Float64MultiArray
from nrp_core.scene.model import Scene
from nrp_core.world.sensors.camera import Camera
from nrp_core.world.topics import Direction, TopicInfo

READER = """\
@nrp.MapRobotSubscriber("camera", Topic("/husky/camera", sensor_msgs.msg.Image))
@nrp.MapSpikeSource("eye", nrp.brain.sensors[0], nrp.poisson)
@nrp.Robot2Neuron()
def see(t, camera, eye):
    eye.rate = 0.0
    {body}
"""


def check(experiment: Path, text: str, *, more: str = "") -> list[Finding]:
    """Return what is found in an experiment whose only file of functions has a text."""
    (experiment.parent / "only.py").write_text(text)
    wanted = experiment.read_text().replace("[listing1.py, listing2.py]", "[only.py]")
    experiment.write_text(f"{wanted}{more}")
    return [one for one in validate_file(experiment) if one.path and one.path.name == "only.py"]


def about(body: str) -> str:
    return READER.format(body=body)


def test_an_error_is_reported_with_the_line_that_raises_it(functions: Path, golden: Golden) -> None:
    (found,) = check(functions, about("eye.rate = 1 / (camera.value.width - camera.value.width)"))
    assert (found.code, found.level, found.line) == (Code.NRP240, Level.ERROR, 6)
    golden(found.message)


def test_a_misspelt_name_is_reported_with_the_one_that_was_meant(functions: Path, golden: Golden) -> None:
    (found,) = check(functions, about("eye.rate = camra.value.width"))
    assert (found.code, found.line) == (Code.NRP246, 6)
    assert found.instead is not None
    assert (found.instead.written, found.instead.meant) == ("camra", "camera")
    golden(found.message)


@pytest.mark.parametrize(
    ("body", "code", "level"),
    [
        ("open('trap.txt', 'w').write('x')", Code.NRP239, Level.NOTE),
        ("import urllib.request; urllib.request.urlopen('http://192.0.2.1')", Code.NRP239, Level.NOTE),
        ("input('speed? ')", Code.NRP357, Level.WARNING),
        ("import time; time.sleep(0.001)", Code.NRP357, Level.WARNING),
        ("import os; os._exit(3)", None, None),
        ("exit()", Code.NRP240, Level.ERROR),
        ("import no_such_library", Code.NRP240, Level.ERROR),
        ("open('no such file.txt')", Code.NRP240, Level.ERROR),
    ],
)
def test_faults_of_the_dry_run_and_of_the_function_are_distinguished(
    functions: Path, body: str, code: Code | None, level: Level | None, golden: Golden
) -> None:
    found = check(functions, about(body))
    assert [(one.code, one.level) for one in found] == ([] if code is None else [(code, level)])
    for one in found:
        golden(one.message)
    assert not (functions.parent / "trap.txt").exists()
    assert not Path("trap.txt").exists()


def test_functions_that_detect_red_cause_no_finding(functions: Path) -> None:
    assert not check(functions, about("eye.rate = nrp.tf_lib.detect_red(camera.value).left"))


def test_a_function_that_does_not_return_is_a_warning(functions: Path, golden: Golden) -> None:
    (found,) = check(functions, about("while True: pass"), more="function_time_limit: 0.3 s\n")
    assert (found.code, found.level, found.line) == (Code.NRP357, Level.WARNING, 6)
    golden(found.message)


def test_a_function_that_waits_for_a_message_is_not_checked(functions: Path, golden: Golden) -> None:
    text = about("pass").replace("Robot2Neuron()", 'Robot2Neuron(triggers="camera")')
    text = text.replace("/husky/camera", "/from/outside").replace(
        "sensor_msgs.msg.Image", "std_msgs.msg.Bool"
    )
    (found,) = check(functions, text, more="topics: {/from/outside: std_msgs/Bool}\n")
    assert (found.code, found.level) == (Code.NRP239, Level.NOTE)
    golden(found.message)


def test_functions_that_print_or_are_triggered_by_spikes_cause_no_finding(functions: Path) -> None:
    text = """\
@nrp.MapSpikeSink("spikes", nrp.brain.actors[0], nrp.spike_recorder)
@nrp.Neuron2Robot(Topic("/husky/cmd_vel", geometry_msgs.msg.Twist), triggers="spikes")
def drive(t, spikes):
    print("woken by", spikes.times[-1])
    return geometry_msgs.msg.Twist()
"""
    assert check(functions, text) == []


def test_a_message_without_a_topic_is_a_warning(functions: Path, golden: Golden) -> None:
    (found,) = check(functions, about("return geometry_msgs.msg.Twist()"))
    assert (found.code, found.level) == (Code.NRP237, Level.WARNING)
    golden(found.message)


def test_functions_are_not_executed_where_a_process_cannot_be_confined(
    functions: Path, monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    answer = ChildResult(0, json.dumps({"lacking": ["Landlock"]}))
    monkeypatch.setattr(confined_functions, "run_module", lambda *_given, **_named: answer)
    found = [one for one in validate_file(functions) if one.code is not Code.NRP239]
    assert found == []
    (note,) = [one for one in validate_file(functions) if one.code is Code.NRP239]
    assert note.level is Level.WARNING
    golden(note.message)


def test_a_file_that_cannot_be_loaded_is_refused_with_its_line(functions: Path) -> None:
    (found,) = check(functions, "import os\n" + about("pass").replace("nrp.poisson", "nrp.poison"))
    assert (found.code, found.level) == (Code.NRP210, Level.ERROR)
    assert found.line in (3, 5)


def test_a_file_alone_is_loaded_in_the_confined_process(functions: Path) -> None:
    file, trap = functions.parent / "alone.py", functions.parent / "trap.txt"
    file.write_text(
        f"import os\ntry:\n    open({str(trap)!r}, 'w')\nexcept OSError:\n    pass\n" + about("pass")
    )
    assert validate_file(file) == []
    assert not trap.exists()
    file.write_text(about("pass").replace("(t, camera", "(camera"))
    assert [one.code for one in validate_file(file)] == [Code.NRP210]


@pytest.mark.one_of(6)
@pytest.mark.parametrize("name", [name for name in shipped() if "/" not in name])
def test_mock_sensors_have_the_sizes_names_and_ranges_of_the_scene(name: str) -> None:
    parts = make_parts(load_experiment(name))
    assert parts.scene is not None
    assert parts.world is not None
    engine = DryEngine(parts.scene, step_ns=parts.world.capabilities.step_ns)
    with MockWorld(engine=engine) as world:
        outgoing = [one.name for one in world.topics.values() if one.direction & Direction.OUT]
        subscriptions = {topic: world.subscribe(topic) for topic in outgoing}
        world.run_until(2 * engine.step_ns)
        assert engine.unknown == set()
        messages: dict[str, Any] = {
            topic: one.latest.message for topic, one in subscriptions.items() if one.latest is not None
        }
    assert messages
    joints = {model.name: [n for j in model.joints for n in j.coordinates] for model in parts.scene.models}
    sizes = {
        one.topic: (one.height, one.width)
        for _, link in parts.scene.links()
        for one in link.sensors
        if isinstance(one, Camera)
    }
    for topic, message in messages.items():
        if isinstance(message, Image) and topic in sizes:
            assert (message.height, message.width) == sizes[topic]
        elif isinstance(message, JointState):
            assert list(message.name) in joints.values()
        elif isinstance(message, LaserScan):
            ranges = np.asarray(message.ranges)
            assert np.all((ranges >= message.range_min) & (ranges <= message.range_max))


def test_a_topic_of_which_only_the_type_is_known_is_noted() -> None:
    topics = [
        TopicInfo("/observation", Float64MultiArray, Direction.OUT, 50.0),
        TopicInfo("/named", Float64MultiArray, Direction.OUT, 50.0, elements=("x", "y")),
    ]
    engine = DryEngine(Scene(()), step_ns=1_000_000, topics=topics)
    with MockWorld(engine=engine) as world:
        named = world.subscribe("/named")
        world.subscribe("/observation")
        world.run_until(1_000_000)
        assert engine.unknown == {"/observation"}
        assert named.latest is not None
        assert len(named.latest.message.data) == 2


def test_the_child_does_not_see_the_folder_of_its_caller_first(functions: Path, monkeypatch: Any) -> None:
    (functions.parent / "json.py").write_text("raise SystemExit('planted')\n")
    monkeypatch.chdir(functions.parent)
    assert check(functions, about("pass")) == []
