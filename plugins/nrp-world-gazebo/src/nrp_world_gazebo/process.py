"""A running Gazebo: its process, its connection, and its state after each answer."""

from __future__ import annotations

import json
import mmap
import re
import socket
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import NoReturn

import numpy as np

from nrp_core.errors import BackendLoadError, SimulationError
from nrp_core.world import FloatArray
from nrp_world_gazebo.child import Child
from nrp_world_gazebo.launch import REMEDY, command_line, environment
from nrp_world_gazebo.options import GazeboOptions
from nrp_world_gazebo.wire import JOINT_ROW, LINK_ROW, VERSION, Channel, EndedError, RefusedError, operation

_POLL_S = 0.05
_LAST_LINES = 6
_HARMLESS = (
    *("RenderEngine.cc", "OpenAL.cc", "ALSA lib", "AL lib", "Audio will be disabled", "unshare:"),
    *("[Msg]", "multi-robot simulator", "Copyright (C)", "Released under", "http://gazebosim.org"),
)
"""Parts of lines about displays and loudspeakers, which Gazebo does without, our kill, and greetings."""
_NO_PLUGIN = re.compile(rb"\[Plugin\.hh:.*libnrp_gazebo\.so")
"""How Gazebo reports that it cannot load our plugin; those of a user's file may be missing."""
_PORT_TAKEN = b"Address already in use"
"""What it reports if a program took the port after it was found to be free."""
_STARTS = 3
_LONGEST = 107
"""The longest name of a socket, bytes."""


class _PortTakenError(Exception):
    """The port of Gazebo's master is taken."""


class Run:
    """The folder of one Gazebo: its world, models, socket and log.

    Raises:
        BackendLoadError: the name of its socket would be too long.
    """

    def __init__(self) -> None:
        self.folder = Path(mkdtemp(prefix="nrp-gazebo-"))
        self.world = self.folder / "scene.world"
        self.models = self.folder / "models"
        self.socket = self.folder / "lockstep"
        self.log = self.folder / "log"
        self.images = self.folder / "images"
        if len(bytes(self.socket)) > _LONGEST:
            self.remove()
            raise BackendLoadError(
                f"the folder for temporary files, {self.folder.parent}, has too long a name for a socket",
                remedy="export TMPDIR=/tmp",
            )

    def last_lines(self) -> str:
        """Return what Gazebo has reported as errors, else its last lines."""
        lines = self.log.read_text(errors="replace").splitlines() if self.log.exists() else []
        told = [line for line in map(_plain, lines) if line and not any(part in line for part in _HARMLESS)]
        errors = [line for line in told if "[Err]" in line]
        return "\n  ".join((errors or told)[-_LAST_LINES:]) or "(it reported nothing)"

    def remove(self) -> None:
        """Remove the folder."""
        rmtree(self.folder, ignore_errors=True)


class Gazebo:
    """A process of Gazebo with a world in it.

    Args:
        run: the folder with the world.
        options: the options of the backend.
        needs: more folders of this system that Gazebo reads.

    Attributes:
        links: pose (position, orientation as x, y, z, w) and linear and angular velocity of each movable
            link, shape ``(n, 13)``.
        joints: position, velocity and effort of each joint, shape ``(m, 3)``.
        images: the memory that Gazebo draws into; empty if it does not draw.

    Raises:
        BackendLoadError: Gazebo does not start, or its plugin has another version.
    """

    def __init__(self, run: Run, options: GazeboOptions, needs: list[Path]) -> None:
        self._run, self._options = run, options
        line = command_line(options, run.world, [run.folder, *needs], draws=run.images.exists())
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(str(run.socket))
            listener.listen(1)
            try:
                self._channel = Channel(self._connect(line, listener))
            except BaseException:
                self._end()
                raise
        try:
            self._greet()
        except BaseException:
            self.close()
            raise
        self.links: FloatArray = np.zeros((self._movable, LINK_ROW))
        self.joints: FloatArray = np.zeros((len(self._joint_numbers), JOINT_ROW))
        self.images = _shared(run.images)
        self._pending: list[bytes] = []
        self._stale = True

    def link(self, model: str, link: str) -> int:
        """Return the number of a link."""
        return self._link_numbers[f"{model}::{link}"]

    def joint(self, model: str, joint: str) -> int:
        """Return the number of a joint."""
        return self._joint_numbers[f"{model}::{joint}"]

    def do(self, operations: bytes) -> None:
        """Do something before the next step or the next look at the state."""
        self._pending.append(operations)
        self._stale = True

    def step(self, steps: int) -> None:
        """Take physics steps."""
        self.do(operation("s", steps))
        self.refresh()

    def refresh(self) -> None:
        """Send pending operations and read the state."""
        if self._stale:
            self.ask(b"")

    def ask(self, query: bytes) -> memoryview:
        """Send pending operations, read the state, and return the answer to a query.

        Raises:
            SimulationError: Gazebo has ended, does not answer or refuses.
        """
        answer = self._exchange(b"".join([*self._pending, operation("x"), query]))
        self._pending.clear()
        self._stale = False
        middle = self.links.nbytes
        end = middle + self.joints.nbytes
        self.links.ravel()[:] = np.frombuffer(answer[:middle])
        self.joints.ravel()[:] = np.frombuffer(answer[middle:end])
        return answer[end:]

    def close(self) -> None:
        """End Gazebo and remove its folder."""
        self._channel.close()
        self._end()

    def _exchange(self, content: bytes) -> memoryview:
        try:
            return self._channel.ask(content)
        except RefusedError as error:
            raise SimulationError(f"Gazebo refuses: {error}") from None
        except EndedError:
            raise SimulationError(f"Gazebo ended{self._child.how(1.0)}: {self._run.last_lines()}") from None
        except TimeoutError:
            message = f"Gazebo did not answer for {self._options.step_timeout:g} s"
            raise SimulationError(f"{message} (option step_timeout): {self._run.last_lines()}") from None

    def _connect(self, line: Sequence[str], listener: socket.socket) -> socket.socket:
        """Start Gazebo and wait for its plugin; try again if another program took the port meanwhile."""
        for _ in range(_STARTS - 1):
            self._start(line)
            with suppress(_PortTakenError):
                return self._accept(listener)
            self._child.kill()
        self._start(line)
        try:
            return self._accept(listener)
        except _PortTakenError:
            self._fail(f"met a port that was taken, {_STARTS} times")

    def _start(self, line: Sequence[str]) -> None:
        self._child = Child(line, environment(self._options, [self._run.models]), self._run.log)

    def _accept(self, listener: socket.socket) -> socket.socket:
        """Wait for the plugin in Gazebo.

        Raises:
            _PortTakenError: another program has the port of its master.
        """
        listener.settimeout(_POLL_S)
        until = time.monotonic() + self._options.start_timeout
        while True:
            try:
                connected, _ = listener.accept()
            except TimeoutError:
                ended, log = self._child.ended, self._run.log.read_bytes()
                if _PORT_TAKEN in log:
                    raise _PortTakenError from None
                if ended:
                    self._fail(f"ended at its start{self._child.how()}")
                if _NO_PLUGIN.search(log):
                    self._fail("cannot load the plugin libnrp_gazebo.so")
                if time.monotonic() > until:
                    self._fail(f"did not start within {self._options.start_timeout:g} s")
                continue
            connected.settimeout(self._options.step_timeout)
            return connected

    def _fail(self, how: str) -> NoReturn:
        command = " ".join(self._options.command)
        raise BackendLoadError(f"Gazebo ('{command}') {how}:\n  {self._run.last_lines()}", remedy=REMEDY)

    def _greet(self) -> None:
        try:
            answer = self._channel.ask(operation("h", VERSION))
        except RefusedError as error:
            raise BackendLoadError(str(error), remedy=REMEDY) from None
        except (EndedError, TimeoutError):
            self._fail("ended while it was greeted")
        told = json.loads(bytes(answer))
        self.version: str = told["gazebo"]
        self._movable: int = told["movable"]
        self._link_numbers = {name: number for number, name in enumerate(told["links"])}
        self._joint_numbers = {name: number for number, name in enumerate(told["joints"])}
        self.link_names: list[str] = told["links"]

    def _end(self) -> None:
        self._child.kill()  # unshare takes what runs in the root with it
        self._run.remove()


def _shared(file: Path) -> mmap.mmap | bytes:
    """Return the memory of a file."""
    if not file.exists():
        return b""
    with file.open("r+b") as opened:
        return mmap.mmap(opened.fileno(), 0)


def _plain(line: str) -> str:
    """Return a line without the colours of a terminal."""
    while "\x1b[" in line:
        before, _, after = line.partition("\x1b[")
        line = before + after.partition("m")[2]
    return line.strip()
