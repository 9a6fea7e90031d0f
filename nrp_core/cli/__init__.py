"""The command line, ``nrp``; scripts may rely on its options, JSON and exit codes.

Exit codes: 0 all is well; 1 the answer is no, or a run failed; 2 the command is used wrongly; 3 an
experiment is not valid; 4 a backend is missing; 130 interrupted by Ctrl-C or SIGTERM.
"""

from __future__ import annotations

import io
import signal
import sys

_INTERRUPTED = 130


def main() -> None:
    """Run the command that the process was started with."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal may not have every character
    if callable(signal.getsignal(signal.SIGINT)):  # a job in the background may have to ignore it
        # what batch systems and containers send ends a run as Ctrl-C does: between two steps
        signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
    try:
        from nrp_core.cli.app import run_app

        code = run_app(sys.argv[1:])
    except KeyboardInterrupt:  # before a command had begun: while the program itself is still being read
        sys.stderr.write("error: interrupted\n")
        code = _INTERRUPTED
    sys.exit(code)
