"""The programs ``python`` and ``nrp`` in forks of a process that has loaded what they import.

A new interpreter spends about two seconds on what a run imports, a fork a tenth of one. ``programs(folder)``
makes the two commands in a folder; a command hands over its arguments, environment, folder and open files,
and ends as the fork does. A program that is started in another way, as by ``sys.executable``, is not forked.
"""

from __future__ import annotations

import gc
import json
import os
import runpy
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from multiprocessing.connection import wait
from pathlib import Path
from types import ModuleType
from typing import Any

from nrp_core._support.forked import take_over

LOADED = (
    "cv2", "h5py", "matplotlib.pyplot", "nrp_brain_event.brain", "nrp_brain_spinnaker.brain",
    "nrp_core.checks.validate", "nrp_core.cli.app", "nrp_lab.gym", "nrp_spynnaker.live",
    "nrp_core.running", "nrp_world_mujoco.engine", "nrp_world_pybullet.engine", "rich.live", "scipy.linalg",
)  # fmt: skip
COMMAND = """\
#!{python} -SE
import json, os, socket, sys
with socket.socket(socket.AF_UNIX) as server:
    server.connect({address!r})
    socket.send_fds(server, [b"?"], [0, 1, 2])
    question = json.dumps([{before!r} + sys.argv[1:], os.getcwd(), dict(os.environ)])
    server.sendall(question.encode() + b"\\n")
    code = int(server.makefile().readline() or 1)
    sys.exit(code if code >= 0 else 128 - code)
"""
END = 0
"""The descriptor of the standard input."""
PROGRAMS: dict[str, list[str]] = {"python": [], "nrp": ["-m", "nrp_core"]}


@contextmanager
def programs(folder: Path) -> Iterator[Path]:
    """Make the commands in a folder, and serve them until the end of the block; elsewhere than on Linux, the
    folder of the interpreter has them.
    """
    if not sys.platform.startswith("linux"):
        yield Path(sys.executable).parent
        return
    address = str(folder / "server")
    for name, before in PROGRAMS.items():
        text = COMMAND.format(python=sys.executable, address=address, before=before)
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    command, pipe = [sys.executable, __file__, address], subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe) as server:  # it ends with its standard input
        assert server.stdout is not None
        assert server.stdout.readline() == b"ready\n"
        yield folder


@dataclass
class Question:
    """What a command asks for; ``files`` are those of its standard input, output and errors."""

    connection: socket.socket
    arguments: list[str]
    folder: str
    environment: dict[str, str]
    files: list[int]

    @classmethod
    def read(cls, listener: socket.socket) -> Question:
        connection, _ = listener.accept()
        _, files, _, _ = socket.recv_fds(connection, 1, 3)
        with connection.makefile() as lines:
            return cls(connection, *json.loads(lines.readline()), files)


def serve(address: str) -> Question | None:
    """Fork this process for each command; the forks return what is to be run, at the end this one None."""
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(address)
        listener.listen()
        print("ready", flush=True)
        running: dict[int, tuple[int, socket.socket]] = {}  # descriptors of processes
        while END not in (ready := set(wait([END, listener, *running]))):
            if listener in ready:
                question = Question.read(listener)
                if (pid := os.fork()) == 0:
                    return question
                for file in question.files:
                    os.close(file)
                running[os.pidfd_open(pid)] = pid, question.connection
            for process in ready & running.keys():
                pid, connection = running.pop(process)
                os.close(process)
                code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
                with connection:
                    connection.sendall(b"%d\n" % code)
        for pid, _ in running.values():  # nobody waits for them any more
            os.kill(pid, signal.SIGKILL)
        return None


def run(question: Question) -> None:
    """Do what a new interpreter does with the arguments; its exit ends this process."""
    question.connection.close()
    for number, file in enumerate(question.files):
        os.dup2(file, number)
        os.close(file)
    # those of the parent know positions in its own files
    sys.stdin, sys.stdout = os.fdopen(0, closefd=False), os.fdopen(1, "w", closefd=False)
    sys.stderr = os.fdopen(2, "w", buffering=1, closefd=False)
    del sys.path[0]  # the folder of this file
    take_over(question.folder, question.environment)
    sys.path.insert(0, question.folder)
    given = question.arguments or ["-"]
    sys.modules["__main__"] = main = ModuleType("__main__")
    if given[0] == "-m":
        sys.argv[:] = given[1:]
        runpy.run_module(given[1], run_name="__main__", alter_sys=True)
    elif given[0] in ("-", "-c"):
        sys.argv[:] = given
        text = sys.stdin.read() if given[0] == "-" else given.pop(1)
        exec(compile(text, "<stdin>", "exec"), vars(main))
    else:
        sys.argv[:] = given
        sys.path[0] = str(Path(given[0]).absolute().parent)
        runpy.run_path(given[0], run_name="__main__")


def load() -> None:
    """Import what programs import, and load the compiled kernels of small networks."""
    for name in LOADED:
        if "pybullet" not in name or find_spec("pybullet"):
            import_module(name)
    sim: Any = import_module("nrp_core.pynn")
    for backend in ("event", "spinnaker"):
        sim.setup(backend=backend)
        cells = sim.Population(2, sim.IF_curr_exp())
        cells.record("spikes")
        sim.run(5.0)
        cells.get_data()
        sim.end()


if __name__ == "__main__":
    load()
    gc.freeze()  # a collection in a fork would copy all of it
    if (asked := serve(sys.argv[1])) is not None:
        run(asked)
