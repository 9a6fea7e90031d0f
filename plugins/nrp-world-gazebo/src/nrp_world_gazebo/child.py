"""A program that does not outlive this one, even if this one is killed and the program hangs."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

_GUARD = """
exec 3<&0
"$@" 3<&- </dev/null &
program=$!
{ cat <&3 >/dev/null; kill -s KILL -- "-$$"; } &
exec 3<&-
wait "$program"
"""
"""Runs a program in a group of its own, and kills the group when standard input is closed."""
_BY_SIGNAL = range(129, 193)
"""Exit codes of a shell whose program was ended by signal 1 to 64."""


class Child:
    """A running program.

    Args:
        line: the program and its arguments.
        environment: its environment.
        log: the file that it writes to.
    """

    def __init__(self, line: Sequence[str], environment: Mapping[str, str], log: Path) -> None:
        with log.open("wb") as output:
            self._process = subprocess.Popen(
                ["sh", "-c", _GUARD, "sh", *line],
                stdin=subprocess.PIPE,
                stdout=output,
                stderr=output,
                env=environment,
                start_new_session=True,
            )

    @property
    def ended(self) -> bool:
        """Whether it has exited on its own."""
        return self._process.poll() is not None

    def how(self, timeout: float = 0.0) -> str:
        """Return how it ended, as the end of a sentence; empty if it is still running after a time (s)."""
        try:
            code = self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            return ""
        return f" by signal {code - 128}" if code in _BY_SIGNAL else f" with exit code {code}"

    def kill(self) -> None:
        """End it and all that it has started."""
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()
