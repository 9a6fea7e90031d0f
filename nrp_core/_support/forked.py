"""Run a module in a fork of a process that has loaded its libraries, instead of in a new interpreter.

A new interpreter spends most of the time of a short check on imports. A module that is run here has
``main(*arguments)``, which returns its exit code, and ``load()``, which imports what it needs. It is run in
the environment and the folder of its caller, and no two runs share anything but the modules of ``load``.
"""

from __future__ import annotations

import atexit
import gc
import os
import random
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module, invalidate_caches
from pathlib import Path
from threading import Lock
from typing import Any, Final, NoReturn

from nrp_core._support.worker_pool import Worker

PATH_VARIABLE = "PYTHONPATH"
_FIRST_OTHER_FILE, _MOST_FILES = 3, 1024


@dataclass(frozen=True, slots=True)
class Fork:
    """What is to be run.

    Args:
        module: the module.
        arguments: those of its ``main``.
        environment: the environment variables.
        folder: the working directory.
        output: the file for its standard output.
        errors: the file for its standard error.
    """

    module: str
    arguments: list[str]
    environment: dict[str, str]
    folder: str
    output: str
    errors: str


def load_and_fork(fork: Fork) -> int:
    """Load a module, fork this process to run it, and return the number of the new process.

    The new process leads a group of its own, and has a single thread.
    """
    module: Any = import_module(fork.module)
    module.load()
    gc.freeze()  # a collection in a fork would copy all of it
    pid = os.fork()
    if pid == 0:
        _run(module, fork)
    return pid


def wait_for_exit(pid: int) -> int:
    """Wait for a process, end its group, and return its exit code; negative for the signal that ended it."""
    os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT)
    os.killpg(pid, signal.SIGKILL)  # its leftover children; its number is still its own
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])


def _run(module: Any, fork: Fork) -> NoReturn:
    code = 1
    try:
        _leave_parent(fork)
        sys.argv[:] = [str(module.__file__), *fork.arguments]
        code = _code(module.main(*fork.arguments))
    except SystemExit as leaving:
        code = _code(leaving.code)
    except BaseException:  # noqa: BLE001  nothing of the parent may go on in here
        traceback.print_exc()
    finally:
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                stream.flush()
        os._exit(code)


def _leave_parent(fork: Fork) -> None:
    """Take over the files, the folder and the environment of the caller, and drop our own."""
    os.setsid()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a worker ignores it
    for number, path in ((1, fork.output), (2, fork.errors)):
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        os.dup2(file, number)
    os.closerange(_FIRST_OTHER_FILE, _MOST_FILES)
    take_over(fork.folder, fork.environment)


def take_over(folder: str, environment: dict[str, str]) -> None:
    """Go on in a folder and with environment variables as ``python -P -m`` would start there."""
    os.chdir(folder)
    ours = _path_of_environment()
    os.environ.clear()
    os.environ.update(environment)
    sys.path[:] = [*_path_of_environment(), *(place for place in sys.path if place not in ours)]
    invalidate_caches()
    tempfile.tempdir = None
    random.seed()
    if (numpy := sys.modules.get("numpy")) is not None:
        numpy.random.seed()


def _path_of_environment() -> list[str]:
    folders = os.environ.get(PATH_VARIABLE, "")
    return [str(Path(folder).absolute()) for folder in folders.split(os.pathsep) if folder]


def _code(value: object) -> int:
    """Return the exit code of an interpreter for the value with which a program exits."""
    if value is None:
        return 0
    if isinstance(value, int):
        return value & 0xFF
    print(value, file=sys.stderr)
    return 1


_LEAST_S: Final = 0.05


def ends_within(limit_s: float, pid: int, wait: Callable[[float], bool]) -> bool:
    """Return whether a process ends before it has run, slept and read for some time.

    On a machine that is busy with other programs, this is longer than the limit.

    Args:
        limit_s: the time, s.
        pid: the process.
        wait: waits for its end, for a time in s, and returns whether it has come.
    """
    began_s = time.monotonic()
    while (left_s := limit_s + _queued_s(pid) - (time.monotonic() - began_s)) > 0:
        if wait(max(left_s, _LEAST_S)):
            return True
    return False


def _queued_s(pid: int) -> float:
    """Return how long a process and its slowest line of children waited for a processor; 0 if unknown.

    A confined process does its work in a child of a child.
    """
    try:
        _, queued_ns, _ = Path(f"/proc/{pid}/schedstat").read_text("ascii").split()
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text("ascii").split()
    except (OSError, ValueError):
        return 0.0
    return int(queued_ns) / 1e9 + max((_queued_s(int(child)) for child in children), default=0.0)


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
        except (EOFError, OSError):  # the process to fork has died, or the working directory is gone
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
            code = self._exit_code(fork, timeout_s)
            return ForkResult(code, *(file.read_text("utf-8", "replace") for file in (output, errors)))

    def _exit_code(self, fork: Fork, timeout_s: float) -> int | None:
        """Fork, and return the exit code of the fork; None if it took too long."""
        connection = self._worker_ready().connection
        connection.send((load_and_fork, fork))
        pid, error = connection.recv()
        if error is not None:
            raise OSError(f"{fork.module} could not be forked: {error}")
        connection.send((wait_for_exit, pid))
        is_in_time = False
        try:
            is_in_time = ends_within(timeout_s, pid, connection.poll)
        finally:
            if not is_in_time:
                os.killpg(pid, signal.SIGKILL)
        code, _ = connection.recv()
        return code if is_in_time else None

    def _worker_ready(self) -> Worker:
        early = {
            name: value
            for name, value in os.environ.items()
            if name.startswith(_READ_WHEN_LOADED) and name != PATH_VARIABLE  # a fork takes it over
        }
        key = (sys.executable, os.getpid(), early)
        if self._worker is None or key != self._key:
            self.end()
            self._worker, self._key, self._owner = Worker(has_our_path=False), key, os.getpid()
        return self._worker

    def end(self) -> None:
        """End the process to fork, unless it is that of the program that this one is a fork of."""
        if self._worker is not None and self._owner == os.getpid():
            self._worker.end()
        self._worker = None
