"""The command line, ``nrp``; scripts may rely on its options, JSON and exit codes.

Exit codes: 0 success; 1 a negative result or a failed run; 2 wrong usage; 3 an experiment is not valid;
4 a backend is missing; 130 interrupted by Ctrl-C, SIGTERM or SIGHUP.
"""

from __future__ import annotations

import io
import signal
import sys

from nrp_core._support.collector import CollectorPaused
from nrp_core._support.signals import INTERRUPTS, interrupt

_INTERRUPTED = 130


def main() -> None:
    """Run the command line of this process."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal may not support every character
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, interrupt)
    for number in INTERRUPTS:
        # Batch systems and terminals that close send them: they end a run like Ctrl-C, between two steps,
        # also in a shell's background, where Ctrl-C is ignored. Under nohup SIGHUP remains ignored.
        if number != signal.SIGINT and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, interrupt)
    try:
        with CollectorPaused():
            from nrp_core.cli.app import run_app

        code = run_app(sys.argv[1:])
    except KeyboardInterrupt:  # before the command began, while the program itself was being imported
        sys.stderr.write("error: interrupted\n")
        code = _INTERRUPTED
    sys.exit(code)
