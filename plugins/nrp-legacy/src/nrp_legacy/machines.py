"""State machines beside the loop: after every step each runs until it waits."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from nrp_core.cle.engine import ClosedLoop
from nrp_core.dsl.parameters.source_line import line_in
from nrp_core.errors import ExperimentError
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code
from nrp_legacy.code import Source
from nrp_legacy.machine_consistency import check_machine
from nrp_legacy.machine_slips import check_machine_file, is_scxml, scxml_message
from nrp_legacy.namespace import Namespace
from nrp_legacy.shims.steps import Task

_MACHINES = ("sm", "state_machine")
"""The variables in which a file may have its machine."""


def machine_in(module: ModuleType) -> Any:
    """Return the machine of a file that has run, None if it has none."""
    return next((vars(module)[name] for name in _MACHINES if name in vars(module)), None)


class StateMachines:
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
                self._names.graph.warn(Code.NRP273, scxml_message(new), subject=new.name)
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
                Code.NRP273, f"state machine left out: {scope.located(error, ExperimentError, path)}"
            )
            return None
        machine = machine_in(module)
        if machine is None:
            named = "' or '".join(_MACHINES)
            self._names.graph.warn(Code.NRP273, f"state machine left out: {path} has no variable '{named}'")
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
            self._names.graph.warn(Code.NRP273, message)

    def _restart(self, loop: ClosedLoop) -> None:
        self.close()
        self._begin()

    def close(self) -> None:
        """End all machines."""
        for task in self._tasks.values():
            task.stop()
        self._tasks.clear()
