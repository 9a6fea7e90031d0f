"""The other process: started, asked, ended."""

from __future__ import annotations

import shutil
import signal
import subprocess
from contextlib import suppress
from multiprocessing.connection import Pipe
from typing import Any, Final

from nrp_core.brain.remote.messages import receive, send
from nrp_core.errors import BackendLoadError, SimulationError

_PATIENCE_S: Final = 5.0
"""How long a process may take to end by itself."""
_STANDARD_ERROR: Final = 2


class BrainProcess:
    """A Python process that runs :mod:`nrp_core.brain.remote`.

    What it prints goes to standard error: standard output is for what a command is asked for.

    Args:
        python: the interpreter, a path or a name on the search path.

    Raises:
        BackendLoadError: there is no such program.
    """

    def __init__(self, python: str) -> None:
        program = shutil.which(python)
        if program is None:
            raise BackendLoadError(f"python: '{python}' is not a program that can be run")
        self._python = python
        self._connection, theirs = Pipe()
        command = [program, "-m", "nrp_core.brain.remote", str(theirs.fileno())]
        with theirs:
            self._process = subprocess.Popen(
                command, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL, stdout=_STANDARD_ERROR
            )
        self._opened = False

    @property
    def pid(self) -> int:
        """The operating system's number of the process."""
        return self._process.pid

    def call(self, request: str, *arguments: Any) -> Any:
        """Return the answer to a request.

        Raises:
            BackendLoadError: the process ended before it had opened a brain.
            SimulationError: it ended later.
            NrpError: what was raised there.
        """
        try:
            send(self._connection, (request, arguments))
            answer, error = receive(self._connection)
        except (EOFError, OSError):
            raise self._ended() from None
        if error is not None:
            raise error
        self._opened = True
        return answer

    def close(self) -> None:
        """End the process."""
        with suppress(OSError):
            self._connection.close()  # the other side reads the end of the stream and leaves
        try:
            self._process.wait(_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _ended(self) -> BackendLoadError | SimulationError:
        self.close()
        code = self._process.returncode
        how = f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
        if self._opened:
            return SimulationError(f"the process of the brain ({self._python}) {how}")
        return BackendLoadError(
            f"the process of the brain ({self._python}) {how} before it was ready; "
            "that Python needs nrp-core and the backend installed"
        )
