"""Transitions of state machines that lead nowhere are found before a run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from nrp_legacy.shims.smach import State, StateMachine
from nrp_legacy.state_machines import check_machine, check_machine_file

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
        ('["FINISHED", "ERROR"])', '[A, B]); A, B = "A", "B"', 10,
         "the state 'red' goes to 'FINISHED', which is neither"),
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
    found = list(check_machine_file(path))
    assert bool(found) == (words is not None)
    if words is not None:
        assert found[0].code is Code.NRP272
        assert found[0].line == line
        assert any(words in one.message for one in found)


def _state(*outcomes: str) -> State:
    return State(outcomes)


@pytest.mark.parametrize(
    ("states", "outcomes", "initial", "code", "words"),
    [
        ({"a": (_state("done"), {"done": "END"})}, ["END"], None, None, ""),
        ({"a": (_state("valid", "invalid"), {"succeeded": "END"})}, ["END"], None, None, ""),
        ({}, ["END"], None, Code.NRP272, "does not have any state"),
        ({"a": (_state("done"), {"done": "b"})}, ["END"], None, Code.NRP272, "'a' goes to 'b', which is nei"),
        ({"a": (_state("done"), {"done": "END"})}, ["END"], "b", Code.NRP272, "no initial state 'b'"),
        ({"a": (State, {})}, ["END"], None, Code.NRP272, "which is not a state; call it"),
        ({"a": (_state("done", "bad"), {"done": "END"})}, ["END"], None, Code.NRP248, "can end with 'bad'"),
        ({"a": (_state("done"), {"done": "END", "dome": "a"})}, ["END"], None, Code.NRP248,
         "a transition for 'dome', which is not an outcome of it; did you mean 'done'"),
    ],
)  # fmt: skip
def test_a_machine_that_smach_would_not_start_is_reported(
    states: dict[str, Any], outcomes: list[str], initial: str | None, code: Code | None, words: str
) -> None:
    machine, outer = StateMachine(outcomes), StateMachine(outcomes)
    with machine:
        for label, (state, transitions) in states.items():
            StateMachine.add(label, state, transitions)
    if initial is not None:
        machine.set_initial_state([initial])
    with outer:
        StateMachine.add("inner", machine)
    found = list(check_machine(outer))
    assert [one for one, _ in found] == ([] if code is None else [code])
    assert all(words in sentence for _, sentence in found)


def test_outcomes_that_are_a_text_are_reported() -> None:
    machine = StateMachine(["END"])
    with machine:
        StateMachine.add("a", State("done"), {"done": "END"})
    ((code, sentence),) = check_machine(machine)
    assert code is Code.NRP248
    assert "the outcomes of the state 'a' are the text 'done'" in sentence


def test_the_machines_of_the_corpus_have_no_slip() -> None:
    machines = list((Path(__file__).parent / "corpus").rglob("*.exd"))
    assert len(machines) > 3
    assert [str(one) for path in machines for one in check_machine_file(path)] == []
