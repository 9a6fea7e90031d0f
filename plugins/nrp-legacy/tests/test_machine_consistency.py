"""State machines that SMACH would not start are reported."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from golden import Golden
from nrp_legacy.shims.smach import InvalidStateError, State, StateMachine
from nrp_legacy.state_machines import check_machine, check_machine_file

from nrp_core.findings import Code


def test_a_file_that_is_not_python_is_reported_before_a_run(tmp_path: Path) -> None:
    path = tmp_path / "machine.exd"
    path.write_text("import smach\nsm = smach.StateMachine(['END'])\nwith sm\n    pass\n")
    (found,) = check_machine_file(path)
    assert (found.code, found.line) == (Code.NRP272, 3)


def test_a_state_that_is_added_twice_is_refused(golden: Golden) -> None:
    machine = StateMachine(["END"])
    with machine:
        StateMachine.add("wait", State(["done"]), {"done": "END"})
        with golden.raises(InvalidStateError, match="'wait'"):
            StateMachine.add("wait", State(["done"]), {"done": "END"})


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
