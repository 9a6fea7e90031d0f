"""State machines wait, serve and change the world as on the platform, on every pair of engines."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from recorded import rows

from nrp_core.checks.validate import validate_file
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code
from nrp_core.scene.model import Box

Played = Callable[..., Run]


def test_a_machine_of_2017_waits_for_poses_and_calls_the_service_of_a_function(played: Played) -> None:
    run = played("poses_2017/poses.exc")
    problems = "\n".join(map(str, run.problems))
    assert "state machine" not in problems
    assert not run.result().failures
    opened = [float(time) for time, is_open in rows(run, "drive", "recorder") if is_open == "True"]
    # at 0.5 m/s, 0.2 m takes 0.4 s; the robot accelerates, and its function runs after the next step
    assert opened[0] == pytest.approx(0.2 / 0.5, abs=0.1)


def test_a_model_is_posed_by_a_function_turned_and_scaled_from_its_own_size(played: Played) -> None:
    run = played("poses_2017/poses.exc")
    pose = run.world.model_motion("box").pose
    assert pose.position == pytest.approx((0.0, 2.0, 0.5))
    assert pose.rpy == pytest.approx((0.0, 0.0, 1.5))
    (collision,) = run.world.scene.model("box").links[0].collisions
    assert isinstance(collision.geometry, Box)
    # first (2, 3, 4), then 2: factors of the size that it began with, 0.1 m
    assert collision.geometry.size == pytest.approx((0.2, 0.2, 0.2))


@pytest.mark.one_of(8)
@pytest.mark.parametrize(
    ("name", "right", "wrong", "told"),
    [
        ("gate.exd", "'robot::base_link'", "'robot::no_link'", "waits for 'robot::no_link', which is not in"),
        ("gate.exd", "(lambda ud, p: not (", "('a', 'b', lambda ud, p: not (", "takes a callback and at"),
        ("gate.exd", "gravity_factor=0", "gravty_factor=0", "adds an object has no argument 'gravty_factor'"),
        ("gate.exd", "Point(0, -2, 0.5)", "Point(float('nan'), -2, 0)", "the pose of 'box' must be finite"),
        ("drive.py", "return SetBoolResponse", "SetBoolResponse", "handler returned None instead"),
        ("drive.py", "SetBoolResponse(True,", "SetBoolResponse(True, 1,", "service /gate: "),
        ("drive.py", "request.data\n", "request.date\n", "its handler raised AttributeError"),
        ("drive.py", "SetBool, open", "Unknown, open", "the fields of UnknownRequest are not known here"),
    ],
)  # fmt: skip
def test_states_and_services_that_cannot_work_are_reported(
    opened: Played, corpus: Path, name: str, right: str, wrong: str, told: str
) -> None:
    file = corpus / "poses_2017" / name
    assert right in file.read_text()
    text = (
        file.read_text().replace(right, wrong).replace("import SetBool, Set", "import SetBool, Unknown, Set")
    )
    file.write_text(text)
    if "Unknown" in wrong:  # the caller names the same type
        machine = corpus / "poses_2017" / "gate.exd"
        machine.write_text(machine.read_text().replace("SetBool", "Unknown"))
    run = opened("poses_2017/poses.exc")
    run.run()
    assert told in "\n".join(map(str, run.problems))
    assert not run.result().failures


def test_an_answer_may_be_a_value_a_list_or_a_dictionary(opened: Played, corpus: Path) -> None:
    file = corpus / "poses_2017" / "drive.py"
    for answer in ("True", "[True, 'open']", "{'success': True, 'message': 'open'}"):
        lines = file.read_text().split("\n")
        at = next(i for i, line in enumerate(lines) if line.startswith("    return ") and "Twist" not in line)
        file.write_text("\n".join([*lines[:at], f"    return {answer}", *lines[at + 1 :]]))
        run = opened("poses_2017/poses.exc")
        run.run_until(0.8)
        assert "state machine" not in "\n".join(map(str, run.problems))


SCXML = """<?xml version="1.0" encoding="utf-8"?>
<!-- Evaluating State Machine -->
<sc:scxml xmlns:sc="http://schemas.humanbrainproject.eu/SP10/2015/ExDConfig/scxml" version="1.0"
          datamodel="python-smach" initial="waiting">
  <sc:state id="waiting"><sc:transition event="timer" target="success"/></sc:state>
  <sc:final id="success" outcome="FINISHED"/>
</sc:scxml>
"""


@pytest.mark.one_of(3)
@pytest.mark.parametrize("kind", ["SMACHStateMachine", "SCXMLStateMachine"])
def test_a_machine_in_scxml_is_ignored_and_reported_before_and_after_a_run(
    opened: Played, corpus: Path, kind: str
) -> None:
    """The platform's documentation: such machines "are not integrated ... and will not be executed"."""
    exc = corpus / "poses_2017" / "poses.exc"
    (corpus / "poses_2017" / "gate.scxml").write_text(SCXML)
    exc.write_text(exc.read_text().replace("SMACHStateMachine", kind).replace("gate.exd", "gate.scxml"))
    assert kind in exc.read_text()
    assert "gate.scxml" in exc.read_text()
    words = "gate.scxml is in SCXML, which the Neurorobotics Platform did not execute either"
    assert [words in one.message for one in validate_file(exc) if one.code is Code.NRP272] == [True]
    run = opened("poses_2017/poses.exc")
    run.run_until(0.1)
    (told,) = [one for one in run.problems if one.code is Code.NRP272]
    assert words in told.message
    assert not run.result().complete
