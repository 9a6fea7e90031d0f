"""Transitions of state machines that lead nowhere are found before a run."""

from __future__ import annotations

from pathlib import Path

import pytest
from nrp_legacy.machine_slips import slips_of

from nrp_core.findings import Code

_MACHINE = """import smach
from hbp_nrp_excontrol.nrp_states import WaitToClockState

sm = smach.StateMachine(outcomes=["FINISHED", "ERROR"])
with sm:
    smach.StateMachine.add("wait", WaitToClockState(1), transitions={"valid": "wait", "invalid": "red"})
    inner = smach.StateMachine(["done"])
    with inner:
        smach.StateMachine.add("wait", WaitToClockState(2), {"succeeded": "done"})
    smach.StateMachine.add("red", inner, transitions={"done": "FINISHED"})
"""


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ("", "", 0, None),
        ('"red", inner', 'f"{1}red", inner', 0, None),  # computed, so not judged
        ('"invalid": "red"', '"invalid": "rad"', 6, "goes to 'rad', which is neither a state nor an outcome"),
        ('sm = smach', 'END = "DONE"\nsm = smach', 0, None),
        ('["FINISHED", "ERROR"]', "[DONE, ERROR]", 0, None),  # names from elsewhere
        ('sm = smach.StateMachine(outcomes=["FINISHED", "ERROR"])',
         'OK, NO = "OK", "NO"; sm = smach.StateMachine(outcomes=[OK, NO])', 10, "the state 'red' goes to 'FINISHED', which is neither"),
        ('["FINISHED", "ERROR"]', '["DONE"]', 10, "the state 'red' goes to 'FINISHED', which is neither"),
        ('"red", inner', '"wait", inner', 10, "the state 'wait' already exists, at line 6; rename one"),
        ("with inner:", "with inner", 8, "state machine left out: "),
    ],
)  # fmt: skip
def test_a_transition_that_leads_nowhere_is_reported(
    tmp_path: Path, old: str, new: str, line: int, words: str | None
) -> None:
    path = tmp_path / "machine.exd"
    path.write_text(_MACHINE.replace(old, new, 1))
    found = list(slips_of(path))
    assert bool(found) == (words is not None)
    if words is not None:
        assert found[0].code is Code.NRP273
        assert found[0].line == line
        assert any(words in one.message for one in found)


def test_the_machines_of_the_corpus_have_no_slip() -> None:
    machines = list((Path(__file__).parent / "corpus").rglob("*.exd"))
    assert len(machines) > 3
    assert [str(one) for path in machines for one in slips_of(path)] == []
