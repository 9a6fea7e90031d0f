"""State machines that only wait for times and change colours, as events."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError
from nrp_legacy.code import Source
from nrp_legacy.machines import machine_in
from nrp_legacy.namespace import Namespace
from nrp_legacy.notes import unnoted
from nrp_legacy.shims.monitor_states import PollingState
from nrp_legacy.shims.service_states import SetMaterialColorServiceState
from nrp_legacy.shims.smach import StateMachine
from nrp_legacy.shims.states import (
    ClientLogState,
    ClockDelayState,
    WaitToClockState,
)


def events_of(path: Path, names: Namespace) -> dict[str, Any] | None:
    """Return a machine as events by name; None if events cannot express it.

    Args:
        path: its file.
        names: its initial names and imports.
    """
    module = names.fresh()
    try:
        names.scope.run(path, module, Source.of_file(path).compiled(unnoted))
    except (Exception, SystemExit) as error:  # noqa: BLE001 - users' files raise anything
        raise names.scope.located(error, ExperimentError, path) from None
    machine = machine_in(module)
    return _events(machine, path.stem) if isinstance(machine, StateMachine) else None


def _events(machine: StateMachine, stem: str) -> dict[str, Any] | None:
    states: Mapping[str, Any] = machine._states
    label, now_ns, seen = machine._initial, 0, set[str]()
    events: dict[str, Any] = {}
    while label in states and label is not None:
        state, ways = states[label], machine._transitions[label]
        if label in seen:
            return None
        seen.add(label)
        if isinstance(state, WaitToClockState):
            now_ns, outcome = max(now_ns, state.end_ns), "invalid"
        elif isinstance(state, ClockDelayState):
            now_ns, outcome = now_ns + state.delay_ns, "invalid"
        elif isinstance(state, SetMaterialColorServiceState):
            model, link, visual, _, color = state.values
            topic = f"/{model}/{link}/{visual}/color"
            name = f"{stem}_{label}".replace("-", "_").replace(" ", "_")
            events[name] = {"at": f"{seconds(now_ns):g} s", "publish": {"topic": topic, "value": color}}
            outcome = "succeeded"
        elif isinstance(state, ClientLogState):
            outcome = "succeeded"
        else:
            return events if _only_look(machine, label) else None
        label = ways.get(outcome)
    return events


def _only_look(machine: StateMachine, label: str) -> bool:
    """Return whether all states that can follow a state have no effect."""
    waiting, seen = [label], set[str]()
    while waiting:
        one = waiting.pop()
        if one in machine._states and one not in seen:
            seen.add(one)
            waiting += machine._transitions[one].values()
    return all(isinstance(machine._states[one], (PollingState, ClientLogState)) for one in seen)
