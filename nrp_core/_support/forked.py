"""Run a module in a fork of a process that has loaded its libraries, instead of in a new interpreter.

A new interpreter spends most of the time of a short check on imports. A module that is run here has
``main(*arguments)``, which returns its exit code, and ``load()``, which imports what it needs. It is run in
the environment and the folder of its caller, and no two runs share anything but the modules of ``load``.
"""

from __future__ import annotations

import atexit
import os
import signal
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

from nrp_core._support.forks import PATH_VARIABLE, Fork, ended, forked
from nrp_core._support.patience import ends_within
from nrp_core._support.worker_pool import Worker

_READ_WHEN_LOADED = ("PYTHON", "LD_", "OMP_", "OPENBLAS_", "MKL_", "NUMBA_")
"""Variables that an interpreter or a library reads once; another value takes another process."""


@dataclass(frozen=True, slots=True)
class ForkResult:
    """How a fork ended: as :class:`nrp_core._support.probe.ChildResult`, with all of its standard error."""

    exit_code: int | None
    output: str
    errors: str


class Forker:
    """Forks one process at a time; it starts the process to fork when a module is run for the second time.

    Most programs run a module once, and need no process that waits for the next.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._known: set[str] = set()
        self._worker: Worker | None = None
        self._key: object = None
        self._owner = 0
        atexit.register(self.end)

    def run(self, module: str, arguments: list[str], timeout_s: float) -> ForkResult | None:
        """Run a module; None if it has to be run in a new interpreter."""
        if not sys.platform.startswith("linux") or not self._lock.acquire(blocking=False):
            return None
        try:
            if module not in self._known:
                self._known.add(module)
                return None
            return self._run(module, arguments, timeout_s)
        except (EOFError, OSError):  # the process to fork has died, or there is no working directory
            self.end()
            return None
        except BaseException:  # an answer may be outstanding
            self.end()
            raise
        finally:
            self._lock.release()

    def _run(self, module: str, arguments: list[str], timeout_s: float) -> ForkResult:
        with tempfile.TemporaryDirectory() as folder:
            output, errors = Path(folder, "output"), Path(folder, "errors")
            fork = Fork(module, arguments, dict(os.environ), str(Path.cwd()), str(output), str(errors))
            code = self._ended(fork, timeout_s)
            return ForkResult(code, *(file.read_text("utf-8", "replace") for file in (output, errors)))

    def _ended(self, fork: Fork, timeout_s: float) -> int | None:
        """Fork, and return the exit code of the fork; None if it took too long."""
        connection = self._worker_for(fork.module).connection
        connection.send((forked, fork))
        pid, error = connection.recv()
        if error is not None:
            raise OSError(f"{fork.module} could not be forked: {error}")
        connection.send((ended, pid))
        is_in_time = False
        try:
            is_in_time = ends_within(timeout_s, pid, connection.poll)
        finally:
            if not is_in_time:
                os.killpg(pid, signal.SIGKILL)
        code, _ = connection.recv()
        return code if is_in_time else None

    def _worker_for(self, module: str) -> Worker:
        early = {
            name: value
            for name, value in os.environ.items()
            if name.startswith(_READ_WHEN_LOADED) and name != PATH_VARIABLE  # a fork takes it over
        }
        key = (module, sys.executable, os.getpid(), early)
        if self._worker is None or key != self._key:
            self.end()
            self._worker, self._key, self._owner = Worker(has_our_path=False), key, os.getpid()
        return self._worker

    def end(self) -> None:
        """End the process to fork, unless it is that of the program that this one is a fork of."""
        if self._worker is not None and self._owner == os.getpid():
            self._worker.end()
        self._worker = None
