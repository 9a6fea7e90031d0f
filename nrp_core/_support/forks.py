"""Fork this process, to run a module: the other end of :mod:`nrp_core._support.forked`."""

from __future__ import annotations

import gc
import os
import random
import signal
import sys
import tempfile
import traceback
from dataclasses import dataclass
from importlib import import_module, invalidate_caches
from pathlib import Path
from typing import Any, NoReturn

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


def forked(fork: Fork) -> int:
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


def ended(pid: int) -> int:
    """Wait for a process, and return its exit code; negative for the signal that ended it."""
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
    """Take over the files, the folder and the environment of the caller, and forget our own."""
    os.setsid()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a worker ignores it
    for number, path in ((1, fork.output), (2, fork.errors)):
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        os.dup2(file, number)
    os.closerange(_FIRST_OTHER_FILE, _MOST_FILES)
    take_over(fork.folder, fork.environment)


def take_over(folder: str, environment: dict[str, str]) -> None:
    """Go on in a folder and with environment variables as ``python -m`` would start there."""
    os.chdir(folder)
    ours = _path_of_environment()
    os.environ.clear()
    os.environ.update(environment)
    own_folder = [] if sys.flags.safe_path else [folder]  # as python -m does
    rest = [place for place in sys.path[len(own_folder) :] if place not in ours]
    sys.path[:] = [*own_folder, *_path_of_environment(), *rest]
    invalidate_caches()
    tempfile.tempdir = None
    random.seed()
    if (numpy := sys.modules.get("numpy")) is not None:
        numpy.random.seed()


def _path_of_environment() -> list[str]:
    folders = os.environ.get(PATH_VARIABLE, "")
    return [str(Path(folder).absolute()) for folder in folders.split(os.pathsep) if folder]


def _code(value: object) -> int:
    """Return the exit code that an interpreter ends with for what a program leaves with."""
    if value is None:
        return 0
    if isinstance(value, int):
        return value & 0xFF
    print(value, file=sys.stderr)
    return 1
