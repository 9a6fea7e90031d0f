"""The process of a brain: starts it, sends requests to it, detects that it is stuck, and ends it.

The process of a closed brain is reused for the next brain, because starting one takes seconds.
"""

from __future__ import annotations

import atexit
import os
import shutil
import signal
import socket
import struct
import subprocess
import threading
from collections.abc import Callable
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final, NamedTuple, Self
from weakref import WeakValueDictionary

from nrp_core.brain.remote import far_end
from nrp_core.brain.remote.messages import Channel, Numbers, SharedColumns
from nrp_core.errors import BackendLoadError, LifecycleError, NrpError, SimulationError

_STATE: Final = 0
"""Indices of the fields after the program's name in ``/proc/PID/stat``, see proc(5)."""
_TIMES: Final = slice(11, 15)
"""CPU time in user and system mode, of the process and of its finished children."""
_CHECKS: Final = 4


class Watchdog:
    """Detects that a process has been inactive for so long that it will not answer any more.

    It counts checks instead of reading a clock, so time for which this program or the machine was suspended
    does not count.

    Args:
        pid: the process id.
        limit_s: how long it may be inactive, s.
        error: the error to raise then.
    """

    def __init__(self, pid: int, limit_s: float, error: Callable[[], Exception]) -> None:
        self.between_checks_s = limit_s / _CHECKS
        self._pid, self._error = pid, error
        self._spent, self._idle = -1, 0

    def begin(self) -> None:
        """Restart the count: the process has received a request."""
        self._spent, self._idle = -1, 0

    def check(self) -> None:
        """Check whether the process has been active since the last check.

        Raises:
            Exception: it has been inactive for too long.
        """
        spent, busy = activity(self._pid)
        self._idle = self._idle + 1 if spent == self._spent and not busy else 0
        self._spent = spent
        if self._idle >= _CHECKS - 1:
            raise self._error()


def activity(pid: int) -> tuple[int, bool]:
    """Return the activity of a process and all its descendants.

    Returns:
        The CPU time used, in clock ticks, and whether one of them is runnable or waits for a disk.
    """
    spent, busy = 0, False
    with suppress(OSError):  # one of them has just ended
        process = Path(f"/proc/{pid}")
        spent = sum(map(int, _fields(process)[_TIMES]))
        for task in process.glob("task/*"):
            busy |= _fields(task)[_STATE] in "RD"
            for child in (task / "children").read_text().split():
                more, also = activity(int(child))
                spent, busy = spent + more, busy or also
    return spent, busy


def _fields(process: Path) -> list[str]:
    return (process / "stat").read_text().rpartition(")")[2].split()


_PATIENCE_S: Final = 5.0
"""Time for a process to end by itself, s."""
_STANDARD_ERROR: Final = 2
_MICROSECONDS: Final = 1_000_000


class ProcessSettings(NamedTuple):
    """What a process cannot change once it has started.

    Args:
        python: the interpreter: a path, or a name on the search path.
        program: path of the interpreter.
        module: the module of the backend.
        time_limit_s: how long the process may neither answer nor compute, s.
        folder: its working directory.
    """

    python: str
    program: str
    module: str
    time_limit_s: float
    folder: Path

    @classmethod
    def of(cls, python: str, module: str, time_limit_s: float) -> Self:
        """Return the kind of a process that is started in the current working directory.

        Raises:
            BackendLoadError: the interpreter is not a program that can be run.
        """
        program = shutil.which(os.path.expanduser(python))  # noqa: PTH111  a Path would lose the ./ of a path
        if program is None:
            raise BackendLoadError(f"python: '{python}' is not a program that can be run")
        return cls(python, program, module, time_limit_s, Path.cwd())


class BrainProcess:
    """A Python process that runs :mod:`nrp_core.brain.remote.server`.

    Its output goes to standard error, since standard output is for the results of commands.

    Args:
        kind: its interpreter, backend and limit; another process of this kind can be used in its place.

    Attributes:
        columns: memory shared with the process.
        kind: as given.
    """

    def __init__(self, kind: ProcessSettings) -> None:
        self.kind = kind
        self.columns = SharedColumns()
        ours, theirs = socket.socketpair()
        descriptors = [theirs.fileno(), self.columns.descriptor]
        command = [kind.program, far_end.__file__, *map(str, descriptors), version("nrp-core"), kind.module]
        with theirs:
            self._process = subprocess.Popen(
                command, pass_fds=descriptors, stdin=subprocess.DEVNULL, stdout=_STANDARD_ERROR
            )
        self._watch = Watchdog(self._process.pid, kind.time_limit_s, self._hangs)
        _time_out(ours, self._watch.between_checks_s)
        self._channel = Channel(ours, self.columns, self._watch.check)
        self._greeted = self._opened = self._waiting = self._failed = False

    @property
    def pid(self) -> int:
        """The operating system's number of the process."""
        return self._process.pid

    @property
    def lives(self) -> bool:
        """Whether the process has not ended."""
        return self._process.poll() is None

    def call(self, request: str, *arguments: Any) -> Any:
        """Return the answer to a request.

        Raises:
            BackendLoadError: the process ended before it had opened a brain, or cannot open one.
            SimulationError: the process ended later, or hangs.
            NrpError: an error that was raised there.
        """
        try:
            self._begin()
            self._channel.send((request, arguments))
            return self._answer()[0]
        except (EOFError, OSError):
            raise self._exit_error() from None

    def begin_step(self, *numbers: int) -> None:
        """Send the numbers of a step; the columns are in shared memory.

        Raises:
            SimulationError, NrpError: see :meth:`call`.
        """
        try:
            self._begin()
            self._channel.send_step(*numbers)
        except (EOFError, OSError):
            raise self._exit_error() from None

    def end_step(self) -> Numbers:
        """Return the numbers of the reply to a step.

        Raises:
            SimulationError, NrpError: see :meth:`call`.
        """
        try:
            return self._answer()[1]
        except (EOFError, OSError):
            raise self._exit_error() from None

    def close_brain(self) -> bool:
        """Close the brain; return whether the process can open another one."""
        if self._waiting or self._failed or not self._opened:
            return False
        try:
            self.call("close")
        except NrpError:
            return False
        self._opened = False
        return True

    def close(self) -> None:
        """End the process."""
        self._channel.close()  # the other side reads the end of the stream and leaves
        try:
            self._process.wait(_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._kill()

    def _begin(self) -> None:
        self._watch.begin()
        if not self._greeted:
            self._greet()
        if self._waiting:  # an earlier call was interrupted, and its reply is still pending
            self._channel.receive()
        self._waiting = True

    def _greet(self) -> None:
        """Wait until the process is ready."""
        problem = self._channel.receive_line()
        self._greeted = True
        if problem:
            raise self._error(f"does not start: {problem}; {_needs()}")

    def _answer(self) -> tuple[Any, Numbers]:
        message, numbers = self._channel.receive()
        self._waiting = False
        if message is None:
            return None, numbers
        answer, error = message
        self._failed |= error is not None
        if isinstance(error, BackendLoadError):
            raise self._error(f"does not open a brain: {error}")
        if error is not None:
            raise error
        self._opened = True
        return answer, numbers

    def _kill(self) -> None:
        self._process.kill()
        self._process.wait()

    def _hangs(self) -> BackendLoadError | SimulationError:
        self._kill()
        self._channel.close()
        return self._error(
            f"hangs: for {self.kind.time_limit_s:g} s it has neither answered nor computed; "
            "the option time_limit sets how long it may"
        )

    def _exit_error(self) -> BackendLoadError | SimulationError:
        self.close()
        code = self._process.returncode
        how = f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        if self._opened:
            return self._error(how)
        return self._error(f"{how} before it was ready; {_needs()}")

    def _error(self, how: str) -> BackendLoadError | SimulationError:
        kind = SimulationError if self._opened else BackendLoadError
        return kind(f"the process of the brain ({self.kind.python}) {how}")


def _needs() -> str:
    return f"that Python needs nrp-core {version('nrp-core')}, as here, and the backend installed"


def _time_out(connection: socket.socket, after_s: float) -> None:
    """Make sending and receiving raise ``BlockingIOError`` after a time, without extra system calls."""
    value = struct.pack("ll", *divmod(max(1, round(after_s * _MICROSECONDS)), _MICROSECONDS))
    for option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
        connection.setsockopt(socket.SOL_SOCKET, option, value)


_KEPT: Final = 2
"""Maximum number of idle processes."""

_idle: Final[list[BrainProcess]] = []
_taking: Final = threading.Lock()


def borrow(python: str, module: str, time_limit_s: float) -> BrainProcess:
    """Return a process without a brain, a new one if none of this kind is idle.

    Args:
        python: the interpreter: a path, or a name on the search path.
        module: the module of the backend.
        time_limit_s: how long it may neither answer nor compute, s.

    Raises:
        BackendLoadError: the interpreter is not a program that can be run.
    """
    kind = ProcessSettings.of(python, module, time_limit_s)
    while (process := _take(kind)) is not None:
        if process.lives:
            return process
        process.close()
    return BrainProcess(kind)


def _take(kind: ProcessSettings) -> BrainProcess | None:
    """Take an idle process of a kind from the pool, or None; several threads may call it at once."""
    with _taking:
        found = next((process for process in _idle if process.kind == kind), None)
        if found is not None:
            _idle.remove(found)
        return found


def give_back(process: BrainProcess) -> None:
    """Close the brain of a process, and keep the process unless it has failed; end the longest idle one."""
    if process.close_brain():
        _idle.append(process)
    else:
        process.close()
    if len(_idle) > _KEPT:
        _idle.pop(0).close()


@atexit.register
def end_idle() -> None:
    """End the idle processes; called at the end of this process."""
    while _idle:
        _idle.pop().close()


os.register_at_fork(after_in_child=_idle.clear)  # they are the parent's


class ProcessLock:
    """Exclusive use of a simulator in this process, until it is released or garbage-collected.

    Args:
        simulator: its name, the same for every backend that drives it, e.g. ``NEST``.

    Raises:
        LifecycleError: another brain uses the simulator.
    """

    def __init__(self, simulator: str) -> None:
        if is_locked(simulator):
            raise LifecycleError(
                f"{simulator} is one to a process and another brain is using it; close that brain first, "
                "or give this one a process of its own with the option python, e.g. python: python3"
            )
        self._simulator = simulator
        _holders[simulator] = self

    def release(self) -> None:
        """Release the simulator; further calls do nothing."""
        if _holders.get(self._simulator) is self:
            del _holders[self._simulator]


_holders: Final[WeakValueDictionary[str, ProcessLock]] = WeakValueDictionary()


def is_locked(simulator: str) -> bool:
    """Return whether a brain of this process is using a simulator."""
    return simulator in _holders
