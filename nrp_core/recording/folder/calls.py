"""What is done to a run from outside, between its steps, besides messages: noted, and done again.

Transfer functions are kept as the text of their files, all else as Python pickles.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from nrp_core._support.closing import Closing
from nrp_core.cle import ClosedLoop
from nrp_core.dsl.functions.function import TransferFunction
from nrp_core.errors import ExperimentError
from nrp_core.experiment.running.run import Run
from nrp_core.world.messages.nrp_msgs import Called

CHANGE, ACTIVATE, LOST = "change", "activate", "lost"
"""What is done to a run itself, and what cannot be done again; all else is done to its world."""

Note = Callable[[str, bytes], None]


class CallNoter(Closing):
    """Notes what is done to a run, until it is closed.

    Args:
        run: which one.
        note: takes the name and the pickled arguments of each call.
        warn: told what cannot be noted.
    """

    def __init__(self, run: Run, note: Note, warn: Callable[[str], None]) -> None:
        self._run, self._note, self._warn = run, note, warn
        run.on_change.append(self._note_functions)
        run.on_activate.append(self._note_activation)
        run.on_step.append(self._see_devices)
        run.loop.hooks.before_step.append(self._note_devices)
        self._see_devices(run)
        run.world.add_watcher(self._note_world)

    def close(self) -> None:
        """Note nothing more."""
        self._run.on_change.remove(self._note_functions)
        self._run.on_activate.remove(self._note_activation)
        self._run.on_step.remove(self._see_devices)
        self._run.loop.hooks.before_step.remove(self._note_devices)
        self._run.world.remove_watcher(self._note_world)

    def _note_functions(self, add: Iterable[TransferFunction | Path], remove: Sequence[str]) -> None:
        files = [(one.name, one.read_bytes()) for one in add if isinstance(one, Path)]
        unnamed = [one.name for one in add if isinstance(one, TransferFunction)]
        if unnamed:
            self._lose(f"{', '.join(unnamed)}: only transfer functions from files are recorded")
        self._keep(CHANGE, (files, remove))
        self._see_devices(self._run)  # those of functions come and go with them

    def _note_activation(self, name: str, active: bool) -> None:
        self._keep(ACTIVATE, (name, active))

    def _note_world(self, name: str, arguments: Sequence[object], named: Mapping[str, object]) -> None:
        if not self._run.loop.is_stepping:  # what a step does, it does again by itself
            self._keep(name, (arguments, named))

    def _see_devices(self, run: Run) -> None:
        self._devices = run.brain.devices

    def _note_devices(self, loop: ClosedLoop) -> None:
        """Tell of devices that came or went since the last step; a step itself does it again."""
        devices, before = loop.brain.devices, self._devices
        if devices != before:
            self._devices = devices
            names = {port.name for port in {*devices} ^ {*before} if not getattr(port, "passing", False)}
            if names:
                self._lose(f"what was done from Python to devices of the brain: {', '.join(sorted(names))}")

    def _lose(self, what: str) -> None:
        self._warn(f"a replay does without {what}")
        self._note(LOST, what.encode())

    def _keep(self, name: str, arguments: Any) -> None:
        try:
            data = pickle.dumps(arguments)
        except (pickle.PicklingError, TypeError, AttributeError) as error:
            self._lose(f"a call of '{name}', which cannot be recorded: {error}")
        else:
            self._note(name, data)


def changes_functions(called: Called) -> bool:
    """Return whether it was done to the transfer functions, which are in no snapshot."""
    return called.name in (CHANGE, ACTIVATE)


def repeat(run: Run, called: Called, folder: Path) -> None:
    """Do again what was done; of functions that an edited file has no more, nothing.

    Args:
        run: to which run; its next step is the one that came next then.
        called: what was done.
        folder: takes the files of transfer functions, which are read now and shown by errors later.

    Raises:
        ExperimentError: it is nothing that can be done.
    """
    try:
        arguments = pickle.loads(bytes(called.data))
        if called.name == CHANGE:
            files, remove = arguments
            removed = [name for name in remove if _has(run, name)]
            run.change([_written(folder, name, text) for name, text in files], removed)
        elif called.name == ACTIVATE:
            if _has(run, arguments[0]):
                run.activate(*arguments)
        else:
            values, named = arguments
            getattr(run.world, called.name)(*values, **named)
    except (pickle.UnpicklingError, AttributeError, EOFError, ImportError, TypeError, ValueError) as error:
        raise ExperimentError(f"what was done by '{called.name}' cannot be done again: {error}") from error


def _has(run: Run, function: str) -> bool:
    return any(one.name == function for one in run.loop.functions)


def _written(folder: Path, name: str, text: bytes) -> Path:
    """Write a file; each time into a folder of its own, for the same may come again, changed."""
    own = folder / f"change-{len(list(folder.iterdir())) + 1}"
    own.mkdir()
    path = own / name
    path.write_bytes(text)
    return path
