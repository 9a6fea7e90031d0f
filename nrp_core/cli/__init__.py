"""The command line, ``nrp``; scripts may rely on its options, JSON and exit codes.

Exit codes: 0 success; 1 the answer is no, or a run failed; 2 wrong usage; 3 an experiment is not valid;
4 a backend is missing; 130 interrupted by Ctrl-C or SIGTERM.
"""

from __future__ import annotations

import io
import signal
import sys

_INTERRUPTED = 130


def main() -> None:
    """Run the command line of this process."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal may not support every character
    if callable(signal.getsignal(signal.SIGINT)):  # a job in the background may have to ignore it
        # batch systems and containers send SIGTERM: it ends a run like Ctrl-C, between two steps
        signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
    try:
        from nrp_core.cli.app import run_app

        code = run_app(sys.argv[1:])
    except KeyboardInterrupt:  # before the command began, while the program itself was being imported
        sys.stderr.write("error: interrupted\n")
        code = _INTERRUPTED
    sys.exit(code)
