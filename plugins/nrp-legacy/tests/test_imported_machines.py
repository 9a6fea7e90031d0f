"""State machines of experiments in our own format are checked as those of the platform's are."""

from __future__ import annotations

from pathlib import Path

import pytest

from nrp_core import validate

_EXPERIMENT = """name: waiting
duration: 2 s
brain: {backend: event, model: brain.py}
world: {backend: mujoco, scene: room.sdf}
compatibility: {platform: hbp_nrp, options: {state_machines: [machine.exd]}}
"""
_ROOM = (
    '<sdf version="1.9"><world name="room"><include><uri>model://ground_plane</uri></include></world></sdf>'
)
_MACHINE = """import smach
from hbp_nrp_excontrol.nrp_states import WaitToClockState

sm = smach.StateMachine(outcomes=["FINISHED"])
with sm:
    smach.StateMachine.add("wait", WaitToClockState(1), transitions={"valid": "wait", "invalid": "again"})
    smach.StateMachine.add("again", WaitToClockState(1.5), {"valid": "again", "invalid": "FINISHED"})
"""


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ("", "", ""),
        ("with sm:", "with sm", "state machine left out: "),
    ],
)
def test_a_machine_of_our_own_format_is_checked(tmp_path: Path, right: str, wrong: str, message: str) -> None:
    (tmp_path / "experiment.yaml").write_text(_EXPERIMENT)
    (tmp_path / "room.sdf").write_text(_ROOM)
    (tmp_path / "brain.py").write_text(
        "import nrp_core.pynn as sim\ncells = sim.Population(1, sim.IF_curr_exp(i_offset=1), label='a')\n"
    )
    (tmp_path / "machine.exd").write_text(_MACHINE.replace(right, wrong, 1))
    found = [one for one in validate(tmp_path / "experiment.yaml") if one.path == tmp_path / "machine.exd"]
    assert any(message in one.message for one in found) == bool(message), found
    assert message or not found
