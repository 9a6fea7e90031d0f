"""Machines that SMACH does not start, found in the objects that a file made.

What a file writes out is found earlier, see :mod:`nrp_legacy.machine_slips`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_legacy.shims.smach import GOES_ON, State, StateMachine


def inconsistencies(machine: Any) -> Iterator[tuple[Code, str]]:
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
        yield from _of_state(label, state, machine)
        yield from inconsistencies(state)
    yield from _unreached(machine)


def _of_state(label: str, state: State, machine: StateMachine) -> Iterator[tuple[Code, str]]:
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
        return  # its outcomes are not known before it runs
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


def _unreached(machine: StateMachine) -> Iterator[tuple[Code, str]]:
    """Yield the states to which no transition leads."""
    reached, pending = set[str](), [machine._initial]
    while pending:
        label = pending.pop()
        if label in machine._states and label is not None and label not in reached:
            reached.add(label)
            pending += machine._transitions[label].values()
    for label in machine._states:
        if reached and label not in reached:
            yield Code.NRP327, f"no transition leads to the state '{label}'"
