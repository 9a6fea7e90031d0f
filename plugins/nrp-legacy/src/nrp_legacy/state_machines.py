"""State machines beside the loop: after every step each runs until it waits.

SMACH compares the states of a machine when it begins, and does not start one whose transitions lead nowhere
(``check_consistency``). Such machines are reported at the same moment.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from nrp_core.cle.loop import ClosedLoop
from nrp_core.dsl import line_in
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import Run, RunObserver
from nrp_core.findings import Code, Finding, Level
from nrp_legacy.code import Source, ignore_note
from nrp_legacy.namespace import Namespace
from nrp_legacy.shims.smach import GOES_ON, CBState, Container, State, StateMachine
from nrp_legacy.shims.steps import Task


def check_machine(machine: Any) -> Iterator[tuple[Code, str]]:
    """Yield a code and a sentence for each dead end in a machine and in the machines within it."""
    if not isinstance(machine, StateMachine):
        return
    states = machine._states
    if not states:
        yield Code.NRP272, "the machine does not have any state"
    elif machine._initial not in states:
        hint = did_you_mean(str(machine._initial), states)
        yield Code.NRP272, f"there is no initial state '{machine._initial}'{hint}"
    for label, state in states.items():
        if not isinstance(state, State):
            hint = "; call it" if isinstance(state, type) and issubclass(state, State) else ""
            yield Code.NRP272, f"the state '{label}' is {state!r:.80}, which is not a state{hint}"
            continue
        if not hasattr(state, "_outcomes"):
            kind = type(state).__name__
            yield (
                Code.NRP272,
                f"the state '{label}' has no outcomes: {kind}.__init__ does not call State.__init__",
            )
            continue
        if state.is_text:
            text = "".join(state.get_registered_outcomes())
            yield Code.NRP248, f"the outcomes of the state '{label}' are the text '{text}'; write ['{text}']"
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
                Code.NRP272,
                f"the state '{label}' goes to '{target}', which is neither a state nor an outcome"
                f"{did_you_mean(str(target), known)}",
            )
    if not outcomes:
        if not isinstance(state, Container):
            hint = "; @smach.cb_interface(outcomes=[...]) names those of a function" * isinstance(
                state, CBState
            )
            yield (
                Code.NRP248,
                f"the state '{label}' does not name its outcomes, and SMACH accepts no other{hint}",
            )
        return
    for outcome in ways:
        if outcome not in outcomes and outcome not in GOES_ON:
            yield (
                Code.NRP248,
                f"the state '{label}' has a transition for '{outcome}', which is not an outcome of it"
                f"{did_you_mean(str(outcome), outcomes)}",
            )
    for outcome in outcomes:
        goes_on = outcome in GOES_ON and any(other in ways for other in GOES_ON)
        if outcome not in ways and outcome not in ends and not goes_on:
            yield (
                Code.NRP248,
                f"the state '{label}' can end with '{outcome}', which does not have a transition",
            )


_BEGINNING: Final = 4096  # bytes to search for the first element


def is_scxml(path: Path) -> bool:
    """Return whether a file holds a state machine in SCXML, whatever its name ends in."""
    with path.open("rb") as file:
        return re.search(rb"<(\w+:)?scxml\b", file.read(_BEGINNING)) is not None


def scxml_message(path: Path) -> str:
    """Return the report of a state machine in SCXML. The platform never executed one."""
    return (
        f"state machine left out: {path.name} is in SCXML, which the Neurorobotics Platform did not execute "
        "either; only Python (SMACH) is run"
    )


def check_machine_file(path: Path) -> Iterator[Finding]:
    """Yield a finding if a file holds no state machine that can be executed."""
    if is_scxml(path):
        yield Finding(Code.NRP272, scxml_message(path), Level.WARNING, path, subject=path.name)
        return
    try:
        Source.of_file(path).tree(ignore_note)
    except ExperimentError as error:
        message = f"state machine left out: {error.message}"
        yield Finding(Code.NRP272, message, Level.WARNING, error.path, error.line)


_VARIABLES = ("sm", "state_machine")
"""The variables in which a file may have its machine."""


def machine_in(module: ModuleType) -> Any:
    """Return the machine of a file that has run, None if it has none."""
    return next((vars(module)[name] for name in _VARIABLES if name in vars(module)), None)


class StateMachines(RunObserver[Run]):
    """The state machines of one run; an error in one is reported and the others continue.

    Args:
        paths: their files.
        names: their initial names and imports.
        run: the run.
    """

    def __init__(self, paths: list[Path], names: Namespace, run: Run) -> None:
        self._paths, self._names, self._run = paths, names, run
        self._tasks: dict[Path, Task] = {}
        self._begin()
        run.loop.hooks.after_step.append(self._advance)
        run.loop.hooks.after_reset.append(self._restart)
        run.observers.append(self)

    def _begin(self) -> None:
        for path in self._paths:
            self._start(path)

    def _start(self, path: Path) -> None:
        loop = self._run.loop
        self._tasks[path] = Task(partial(self._play, path), lambda: loop.now_ns, loop.time_limit.limit_s)
        self._tasks[path].advance()
        self._report(path)

    def exchange(self, old: Path | None, new: Path | None) -> None:
        """End a machine, start another one, or both, between two steps."""
        if old is not None:
            self._paths.remove(old)
            task = self._tasks.pop(old, None)
            if task is not None:
                task.stop()
        if new is not None:
            if is_scxml(new):
                self._names.graph.warn(Code.NRP272, scxml_message(new), subject=new.name)
            self._paths.append(new)
            self._start(new)

    def _play(self, path: Path) -> None:
        """Run a file, and its machine unless the file has done that."""
        machine = self._machine(path)
        for code, problem in check_machine(machine):
            self._names.graph.warn(code, f"state machine {path.name}: {problem}")
        if machine is not None and not getattr(machine, "has_run", False):
            machine.execute(getattr(machine, "userdata", None))

    def _machine(self, path: Path) -> Any:
        """Run a file and return its machine; None if it has none."""
        scope, module = self._names.scope, self._names.fresh()
        if is_scxml(path):
            return None  # reported when the experiment was read
        try:
            scope.run(path, module, Source.of_file(path).compiled(self._names.graph.warn))
        except (Exception, SystemExit) as error:  # noqa: BLE001 - users' files raise anything
            self._names.graph.warn(
                Code.NRP272, f"state machine left out: {scope.located(error, ExperimentError, path)}"
            )
            return None
        machine = machine_in(module)
        if machine is None:
            named = "' or '".join(_VARIABLES)
            self._names.graph.warn(Code.NRP272, f"state machine left out: {path} has no variable '{named}'")
        return machine

    def _advance(self, loop: ClosedLoop) -> None:
        for path, task in list(self._tasks.items()):
            task.advance()
            self._report(path)

    def _report(self, path: Path) -> None:
        error = self._tasks[path].error
        if self._tasks[path].is_over:
            del self._tasks[path]
        if error is not None:
            line = line_in(error.__traceback__, str(path))
            where = path.name if line is None else f"{path.name}:{line}"
            message = f"state machine {where} stopped by {type(error).__name__}: {error}"
            self._names.graph.warn(Code.NRP272, message)

    def _restart(self, loop: ClosedLoop) -> None:
        self.close()
        self._begin()

    def closing(self, run: Run) -> None:
        """End all machines before the engines are released."""
        self.close()

    def close(self) -> None:
        """End all machines."""
        for task in self._tasks.values():
            task.stop()
        self._tasks.clear()
