"""Machines that SMACH does not start, found in the objects that a file made.

What a file writes out is found earlier, see :mod:`nrp_legacy.machine_slips`.
"""

from __future__ import annotations

from collections.abc import Iterator
from heapq import heappop, heappush
from typing import Any

from nrp_core.clock import seconds
from nrp_core.errors import did_you_mean
from nrp_core.findings import Code
from nrp_legacy.shims.monitor_states import MonitorState, PollingState
from nrp_legacy.shims.smach import GOES_ON, CBState, Container, State, StateMachine
from nrp_legacy.shims.states import ClockDelayState, WaitToClockState


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
        if not hasattr(state, "_outcomes"):
            kind = type(state).__name__
            yield (
                Code.NRP273,
                f"the state '{label}' has no outcomes: {kind}.__init__ does not call State.__init__",
            )
            continue
        yield from _of_state(label, state, machine)
        yield from _exchanged(label, state, machine)
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


def _exchanged(label: str, state: State, machine: StateMachine) -> Iterator[tuple[Code, str]]:
    """Yield that a wait begins again as soon as it is over, where it should go on."""
    ways = machine._transitions[label]
    is_limited = isinstance(state, MonitorState) and state.is_limited  # then it also ends with 'valid'
    returns = ways.get("invalid") == label and ways.get("valid", label) != label
    if returns and isinstance(state, PollingState) and not is_limited:
        yield (
            Code.NRP327,
            f"the state '{label}' ends with 'invalid', which goes to itself, and never with 'valid', which "
            f"goes to '{ways['valid']}': are they exchanged?",
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


def late_states(machine: Any, duration_ns: int) -> Iterator[str]:
    """Yield a sentence for each wait that ends after the run even on the shortest way to it."""
    if not isinstance(machine, StateMachine):
        return
    begins, pending = dict[str, int](), [(0, str(machine._initial))]
    while pending:
        begin_ns, label = heappop(pending)
        if label in begins or label not in machine._states:
            continue
        begins[label] = begin_ns
        end_ns = _earliest_end_ns(machine._states[label], begin_ns)
        if begin_ns < duration_ns <= end_ns and _is_wait(machine._states[label]):
            end_s = f"{seconds(end_ns):g} s at the earliest, and the run at {seconds(duration_ns):g} s"
            yield f"the wait of the state '{label}' ends at {end_s}"
        for target in machine._transitions[label].values():
            heappush(pending, (end_ns, target))


def _earliest_end_ns(state: State, begin_ns: int) -> int:
    match state:
        case WaitToClockState():
            return max(begin_ns, state.end_ns)
        case ClockDelayState():
            return begin_ns + state.delay_ns
    return begin_ns


def _is_wait(state: State) -> bool:
    return isinstance(state, WaitToClockState | ClockDelayState)
