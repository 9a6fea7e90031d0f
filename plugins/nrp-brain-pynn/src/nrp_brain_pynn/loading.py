"""PyNN's simulators talk while they load and build; standard output is not theirs."""

from __future__ import annotations

import logging
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

_OUT: Final = 1
_ERR: Final = 2


@contextmanager
def quietly() -> Iterator[None]:
    """Send what is printed, by C code as well, to standard error; drop warnings; find programs.

    PyNN looks for ``nrnivmodl`` and ``nest-config`` on the search path, where a virtual environment that is
    not activated has none.
    """
    programs = str(Path(sys.executable).parent)
    if programs not in os.environ.get("PATH", "").split(os.pathsep):
        os.environ["PATH"] = os.pathsep.join([programs, os.environ.get("PATH", "")])
    os.environ.setdefault("PYNEST_QUIET", "1")
    logging.getLogger("PyNN").setLevel(logging.ERROR)
    sys.stdout.flush()
    out = os.dup(_OUT)
    os.dup2(_ERR, _OUT)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        sys.stdout.flush()
        os.dup2(out, _OUT)
        os.close(out)
