"""Load, check and try the transfer functions of an experiment in a confined process.

The child process of :mod:`nrp_core.checks.confined_functions`. It trusts its argument, a file with a pickle
that its parent made. Its parent does not trust its answer, JSON on standard output. Imports are inside
functions, because a process is confined while it has a single thread.
"""

from __future__ import annotations

import json
import os
import pickle
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from nrp_core._support import plain
from nrp_core._support.confinement import confine

if TYPE_CHECKING:
    from nrp_core.checks.confined_functions import FileQuestion, Question


def load() -> None:
    """Import the modules that every answer uses."""
    import nrp_core.checks.confined_functions
    import nrp_core.checks.dry_run
    import nrp_core.checks.subjects.functions  # noqa: F401

    counter: Any = ModuleType("nrp_core.dsl.red_pixels")  # Numba takes longer to load than all else
    counter.count_red = lambda pixels: (pixels.size // 12, pixels.size // 12)
    counter.red_colors = lambda colors: colors[:, 0] < 0
    sys.modules.setdefault(counter.__name__, counter)
    _load_as_python("nrp_core.brain.devices.train_kernel", "nrp_core.brain.devices.membrane_kernel")


def _load_as_python(*kernels: str) -> None:
    """Import modules of compiled functions; compiling them takes longer than a few steps in Python."""
    compiler = "nrp_core._support.jit"
    if compiler in sys.modules:
        return
    sys.modules[compiler] = plain
    try:
        for name in kernels:
            import_module(name)
    finally:
        del sys.modules[compiler]


def main(question: str, cpu_s: str, scratch: str) -> int:
    """Answer one question; the output of functions goes to standard error.

    Args:
        question: the file with the pickle.
        cpu_s: the processor time after which this process is ended, s.
        scratch: a folder for temporary files.
    """
    stream = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    lacking = confine(cpu_s=float(cpu_s), writable=[Path(scratch)])
    answer: dict[str, Any] = {"lacking": lacking}
    if not lacking:
        os.environ["NUMBA_CACHE_DIR"] = scratch  # no other place can be written
        load()
        from nrp_core.checks.confined_functions import data_of

        asked: Question | FileQuestion = pickle.loads(Path(question).read_bytes())
        answer |= data_of(asked.answer())
    with stream:
        json.dump(answer, stream)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
