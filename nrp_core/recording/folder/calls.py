"""Record and repeat calls from outside the run between its steps, other than messages.

Transfer functions are kept as the text of their files, all else as Python pickles.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy.typing as npt

from nrp_core._support.closing import Closing
from nrp_core.cle import ClosedLoop
from nrp_core.dsl.functions import TransferFunction
from nrp_core.errors import ExperimentError
from nrp_core.experiment.running.observers import RunObserver
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code, Finding, Findings, Level
from nrp_core.messages.nrp_msgs import Called
from nrp_core.recording import old_names

CHANGE, ACTIVATE, RESET, LOST = "change", "activate", "reset", "lost"
PARAMETERS, WEIGHTS = "set_parameters", "set_weights"
"""Calls to the run itself, and those that cannot be repeated; all others are calls to its world."""

Note = Callable[[str, bytes], None]


class CallNoter(RunObserver[Run], Closing):
    """Records the calls to a run, until it is closed.

    Args:
        run: the run.
        note: called with the name and the pickled arguments of each call.
        warnings: collects a finding about each call that cannot be recorded.
    """

    def __init__(self, run: Run, note: Note, warnings: Findings) -> None:
        self._run, self._note, self._warnings = run, note, warnings
        run.observers.append(self)
        run.loop.hooks.before_step.append(self._note_devices)
        self.after_step(run)
        run.world.watchers.append(self._note_world)

    def close(self) -> None:
        """Stop recording."""
        self._run.observers.remove(self)
        self._run.loop.hooks.before_step.remove(self._note_devices)
        self._run.world.watchers.remove(self._note_world)

    def functions_changed(
        self, run: Run, added: Sequence[TransferFunction | Path], removed: Sequence[str]
    ) -> None:
        """Record it, with the text of files."""
        files = [(one.name, one.read_bytes()) for one in added if isinstance(one, Path)]
        unnamed = [one.name for one in added if isinstance(one, TransferFunction)]
        if unnamed:
            self._note_lost(f"{', '.join(unnamed)}: only transfer functions from files are recorded")
        self._note_call(CHANGE, (files, removed))
        self.after_step(run)  # devices of functions are added and removed with them

    def function_activated(self, run: Run, name: str, active: bool) -> None:
        """Record it."""
        self._note_call(ACTIVATE, (name, active))

    def part_reset(self, run: Run, part: str) -> None:
        """Record a reset of the brain."""
        if part == "brain":  # the others are calls to the world
            self._note_call(RESET, (part,))

    def parameters_changed(
        self, run: Run, population: str, values: Mapping[str, float], cells: Sequence[int] | None
    ) -> None:
        """Record it."""
        self._note_call(PARAMETERS, (population, dict(values), cells))

    def weights_changed(self, run: Run, projection: str, weights: npt.ArrayLike, relative: bool) -> None:
        """Record it."""
        self._note_call(WEIGHTS, (projection, weights, relative))

    def _note_world(self, name: str, arguments: Sequence[object], named: Mapping[str, object]) -> None:
        if not self._run.loop.is_stepping:  # calls within a step are repeated by the step
            self._note_call(old_names.WORLD_RESET if name == RESET else name, (arguments, named))

    def after_step(self, run: Run) -> None:
        """Note the devices of the brain after a step, to find those that are added outside of it."""
        self._devices = run.brain.devices

    def _note_devices(self, loop: ClosedLoop) -> None:
        """Warn of devices that were added or removed since the last step from outside."""
        devices, before = loop.brain.devices, self._devices
        if devices != before:
            self._devices = devices
            names = {port.name for port in {*devices} ^ {*before} if not getattr(port, "passing", False)}
            if names:
                self._note_lost(f"changes of devices of the brain from Python: {', '.join(sorted(names))}")

    def _note_lost(self, what: str) -> None:
        self._warnings.append(lost_call(what))
        self._note(LOST, what.encode())

    def _note_call(self, name: str, arguments: Any) -> None:
        try:
            data = pickle.dumps(arguments)
        except (pickle.PicklingError, TypeError, AttributeError) as error:
            self._note_lost(f"a call of '{name}', which cannot be recorded: {error}")
        else:
            self._note(name, data)


def lost_call(what: str) -> Finding:
    """Return the finding about a change that a replay cannot repeat.

    Args:
        what: the change, as recorded under the name ``lost``.
    """
    return Finding(Code.NRP284, f"a replay cannot repeat {what}", Level.WARNING)


def changes_functions(called: Called) -> bool:
    """Return whether it was a call to the transfer functions, which are not in snapshots."""
    return called.name in (CHANGE, ACTIVATE)


def repeat(run: Run, called: Called, folder: Path) -> None:
    """Repeat a call; calls to functions that an edited file no longer has are skipped.

    Args:
        run: the run, before the same step.
        called: the call.
        folder: the folder for files of transfer functions; errors refer to them.

    Raises:
        ExperimentError: the call is not possible.
    """
    try:
        arguments = old_names.loads(bytes(called.data))
        if called.name == CHANGE:
            files, remove = arguments
            removed = [name for name in remove if _has(run, name)]
            run.change([_write_file(folder, name, text) for name, text in files], removed)
        elif called.name == ACTIVATE:
            if _has(run, arguments[0]):
                run.activate(*arguments)
        elif called.name == RESET:
            run.reset(*arguments)
        elif called.name == PARAMETERS:
            run.set_parameters(*arguments)
        elif called.name == WEIGHTS:
            projection, weights, relative = arguments
            run.set_weights(projection, weights, relative=relative)
        else:
            values, named = arguments
            name, first = old_names.RESETS.get(called.name, (called.name, ()))
            getattr(run.world, name)(*first, *values, **named)
    except (pickle.UnpicklingError, AttributeError, EOFError, ImportError, TypeError, ValueError) as error:
        raise ExperimentError(f"the recorded call of '{called.name}' cannot be repeated: {error}") from error


def _has(run: Run, function: str) -> bool:
    return any(one.name == function for one in run.loop.functions)


def _write_file(folder: Path, name: str, text: bytes) -> Path:
    """Write a file into a new folder, because the same file may come again with changes."""
    own = folder / f"change-{len(list(folder.iterdir())) + 1}"
    own.mkdir()
    path = own / name
    path.write_bytes(text)
    return path
