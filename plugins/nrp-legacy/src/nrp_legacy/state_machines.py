"""State machines beside the loop: after every step each runs until it waits.

SMACH compares the states of a machine when it begins, and does not start one whose transitions lead nowhere
(``check_consistency``). Such machines are found in the text of a file, and in the objects that it makes.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from copy import deepcopy
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any, Final

from nrp_core.cle.engine import ClosedLoop
from nrp_core.dsl import line_in
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import Run, RunObserver
from nrp_core.findings import Code, Finding, Level
from nrp_core.scripts import last_name
from nrp_legacy.code import Source, ignore_note
from nrp_legacy.namespace import Namespace
from nrp_legacy.shims.smach import GOES_ON, CBState, Container, State, StateMachine
from nrp_legacy.shims.steps import Task


def check_machine(machine: Any) -> Iterator[tuple[Code, str]]:
    """Yield a code and a sentence for each thing in a machine, and in those within it, that leads nowhere."""
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


_IS_IMPORT: Final = (ast.Import, ast.ImportFrom)


def with_constants(tree: ast.Module) -> ast.Module:
    """Return a copy of a tree with texts and numbers in the place of the names that are given them once."""
    given = Counter(_names(tree))
    known: dict[str, ast.Constant] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                known |= {name: value for name, value in _pairs(target, node.value) if given[name] == 1}
    copied: ast.Module = _Constants(known).visit(deepcopy(tree))
    return copied


def _names(tree: ast.Module) -> list[str]:
    """Return each name as often as something gives it a value."""
    nodes = list(ast.walk(tree))
    return [
        *(node.id for node in nodes if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load)),
        *(node.arg for node in nodes if isinstance(node, ast.arg)),
        *(
            alias.asname or alias.name
            for node in nodes
            if isinstance(node, _IS_IMPORT)
            for alias in node.names
        ),
    ]


def _pairs(target: ast.expr, value: ast.expr) -> list[tuple[str, ast.Constant]]:
    match target, value:
        case ast.Tuple(names), ast.Tuple(values):
            return [pair for one, its in zip(names, values, strict=False) for pair in _pairs(one, its)]
        case ast.Name(name), ast.Constant(str() | int() | float()):
            return [(name, value)]
    return []


class _Constants(ast.NodeTransformer):
    def __init__(self, known: dict[str, ast.Constant]) -> None:
        self._known = known

    def visit_Name(self, node: ast.Name) -> ast.expr:
        known = self._known.get(node.id) if isinstance(node.ctx, ast.Load) else None
        return node if known is None else ast.copy_location(ast.Constant(known.value), node)


_BEGINNING: Final = 4096  # bytes to search for the first element
_CONTAINERS: Final = ("StateMachine", "Sequence", "Concurrence", "Iterator")


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
    """Yield a finding for each transition that leads nowhere, and for each state that is added twice."""
    if is_scxml(path):
        yield Finding(Code.NRP272, scxml_message(path), Level.WARNING, path, subject=path.name)
        return
    try:
        tree = Source.of_file(path).tree(ignore_note)
    except ExperimentError as error:
        message = f"state machine left out: {error.message}"
        yield Finding(Code.NRP272, message, Level.WARNING, error.path, error.line)
        return
    tree = with_constants(tree)
    yield from _repeated_states(tree, path)
    adds = [node for node in ast.walk(tree) if isinstance(node, ast.Call) and _adds(node)]
    labels = [_text(call.args[0]) if call.args else None for call in adds]
    outcomes = _outcomes(tree)
    if outcomes is None or None in labels:
        return  # some are computed
    known = {*outcomes, *(label for label in labels if label)}
    for call, label in zip(adds, labels, strict=True):
        for target in _targets(call):
            name = _text(target)
            if name is not None and name not in known:
                hint = did_you_mean(name, known)
                message = (
                    f"the state '{label}' goes to '{name}', which is neither a state nor an outcome{hint}"
                )
                yield Finding(Code.NRP272, message, Level.WARNING, path, target.lineno, subject=name)


def _repeated_states(tree: ast.Module, path: Path) -> Iterator[Finding]:
    """Yield the states that one block adds again: the later one replaces the first."""
    for block in (node for node in ast.walk(tree) if isinstance(node, ast.With)):
        first: dict[str, int] = {}
        for statement in block.body:
            call = statement.value if isinstance(statement, ast.Expr) else None
            label = _text(call.args[0]) if isinstance(call, ast.Call) and _adds(call) and call.args else None
            if label is not None and first.setdefault(label, statement.lineno) != statement.lineno:
                message = f"the state '{label}' already exists, at line {first[label]}; rename one"
                yield Finding(Code.NRP272, message, Level.WARNING, path, statement.lineno, subject=label)


def _adds(call: ast.Call) -> bool:
    match call.func:
        case ast.Attribute(ast.Name(owner) | ast.Attribute(attr=owner), "add"):
            return owner in _CONTAINERS
    return False


def _outcomes(tree: ast.Module) -> set[str] | None:
    """Return the outcomes of all machines of a file; None if some are computed."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and last_name(node.func) in _CONTAINERS:
            given = [*node.args[:1], *(one.value for one in node.keywords if "outcome" in str(one.arg))]
            for value in given:
                items = getattr(value, "elts", [value])
                texts = [_text(item) for item in items]
                if None in texts:
                    return None
                found |= {text for text in texts if text is not None}
    return found


def _targets(call: ast.Call) -> list[ast.expr]:
    given = [*call.args[2:3], *(one.value for one in call.keywords if one.arg == "transitions")]
    return [value for one in given if isinstance(one, ast.Dict) for value in one.values]


def _text(node: ast.expr) -> str | None:
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else None


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
        if next(check_machine_file(path), None) is None:  # those were reported before
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
