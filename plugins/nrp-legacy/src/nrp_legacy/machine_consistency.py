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

_FAILURES = ("error", "aborted", "failed", "failure")
"""Names of outcomes for what went wrong."""


def inconsistencies(machine: Any, *, is_within: bool = False) -> Iterator[tuple[Code, str]]:
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
        yield from _of_state(label, state, machine)
        yield from _exchanged(label, state, machine)
        yield from inconsistencies(state, is_within=True)
    yield from _unreached(machine)
    if not is_within:
        yield from _of_keys(machine)
    outcomes = machine.get_registered_outcomes()
    for twice in sorted({one for one in outcomes if outcomes.count(one) > 1}):
        yield Code.NRP327, f"the machine has the outcome '{twice}' twice; is one of them another?"


def _of_keys(machine: StateMachine) -> Iterator[tuple[Code, str]]:
    """Yield the keys of states that are nearly those that the machine has."""
    known = {*vars(machine.userdata), *_written(machine)}
    for label, state in machine._states.items():
        if not isinstance(state, State) or not hasattr(state, "_outcomes"):
            continue
        names, own = machine._remappings.get(label, {}), {*state.reads, *state.writes}
        for key in names.keys() - own if own else ():
            hint = did_you_mean(key, sorted(own))
            yield (
                Code.NRP327,
                f"the state '{label}' does not have the key '{key}', which gets another name{hint}",
            )
        for name in {names.get(key, key) for key in state.reads} - known:
            hint = did_you_mean(name, sorted(known))
            if hint.instead is not None:  # others may come from a line that runs later
                yield Code.NRP327, f"the state '{label}' reads the key '{name}', which nothing writes{hint}"


def _written(machine: StateMachine) -> set[str]:
    """Return the keys that the states of a machine, and of those within it, write."""
    keys = set[str]()
    for label, state in machine._states.items():
        names = machine._remappings.get(label, {})
        keys |= {names.get(key, key) for key in getattr(state, "writes", ())}
        keys |= _written(state) if isinstance(state, StateMachine) else set()
    return keys


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
    success, failure = ways.get("succeeded", ""), ways.get("aborted", "error")
    if success.lower() in _FAILURES and failure.lower() not in _FAILURES:
        yield (
            Code.NRP327,
            f"the state '{label}' goes to '{success}' if it has succeeded, and to '{failure}' if it was "
            "aborted: are they exchanged?",
        )
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
