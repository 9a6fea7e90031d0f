"""Machines that SMACH does not start: what its ``check_consistency`` finds in the objects of a file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_legacy.shims.smach import GOES_ON, CBState, Container, State, StateMachine


def check_machine(machine: Any) -> Iterator[tuple[Code, str]]:
    """Yield a code and a sentence for each thing in a machine, and in those within it, that leads nowhere."""
    if not isinstance(machine, StateMachine):
        return
    states = machine._states
    if not states:
        yield Code.NRP273, "the machine does not have any state"
    elif machine._initial not in states:
        hint = did_you_mean(str(machine._initial), states)
        yield Code.NRP273, f"there is no initial state '{machine._initial}'{hint}"
    for label, state in states.items():
        if not isinstance(state, State):
            hint = "; call it" if isinstance(state, type) and issubclass(state, State) else ""
            yield Code.NRP273, f"the state '{label}' is {state!r:.80}, which is not a state{hint}"
            continue
        if not hasattr(state, "_outcomes"):
            kind = type(state).__name__
            yield (
                Code.NRP273,
                f"the state '{label}' has no outcomes: {kind}.__init__ does not call State.__init__",
            )
            continue
        if state.is_text:
            text = "".join(state.get_registered_outcomes())
            yield Code.NRP327, f"the outcomes of the state '{label}' are the text '{text}'; write ['{text}']"
            continue
        yield from _check_state(label, state, machine)
        yield from check_machine(state)


def _check_state(label: str, state: State, machine: StateMachine) -> Iterator[tuple[Code, str]]:
    ways, ends = machine._transitions[label], machine.get_registered_outcomes()
    outcomes = state.get_registered_outcomes()
    for target in ways.values():
        if target not in machine._states and target not in ends:
            known = [*machine._states, *ends]
            yield (
                Code.NRP273,
                f"the state '{label}' goes to '{target}', which is neither a state nor an outcome"
                f"{did_you_mean(str(target), known)}",
            )
    if not outcomes:
        if not isinstance(state, Container):
            hint = "; @smach.cb_interface(outcomes=[...]) names those of a function" * isinstance(
                state, CBState
            )
            yield (
                Code.NRP327,
                f"the state '{label}' does not name its outcomes, and SMACH accepts no other{hint}",
            )
        return
    for outcome in ways:
        if outcome not in outcomes and outcome not in GOES_ON:
            yield (
                Code.NRP327,
                f"the state '{label}' has a transition for '{outcome}', which is not an outcome of it"
                f"{did_you_mean(str(outcome), outcomes)}",
            )
    for outcome in outcomes:
        goes_on = outcome in GOES_ON and any(other in ways for other in GOES_ON)
        if outcome not in ways and outcome not in ends and not goes_on:
            yield (
                Code.NRP327,
                f"the state '{label}' can end with '{outcome}', which does not have a transition",
            )
