"""Keep the messages of PyNN's simulators off standard output."""

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
    """Redirect output, also of C code, to standard error; suppress warnings; find programs.

    PyNN searches ``nrnivmodl`` on the path, which lacks that of a virtual environment that is not activated.
    """
    programs = str(Path(sys.executable).parent)
    if programs not in os.environ.get("PATH", "").split(os.pathsep):
        os.environ["PATH"] = os.pathsep.join([programs, os.environ.get("PATH", "")])
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
