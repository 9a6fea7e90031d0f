"""Control a run from outside: a Unix socket, with one JSON object in a line each way.

``{"command": "publish", "topic": "/screens/left/color", "value": "red"}`` is answered by ``{"ok": true,
"result": []}`` once the message is accepted (it is sent before the next step), with the names of the active
functions that publish on the topic too, or by ``{"ok": false, "error": "..."}``.
"""

from __future__ import annotations

import inspect
import json
import os
import socket
import socketserver
import stat
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, cast

from nrp_core._support.closing import Closing
from nrp_core.errors import ExperimentError, NrpError, did_you_mean

MAX_LINE = 1 << 20
"""A request longer than this many bytes is refused."""

Commands = Mapping[str, Callable[..., Any]]
"""Commands to a run, by name; the other keys of a request are the arguments."""


class ControlServer(Closing):
    """Listens on a Unix socket that only this user can open; removes it in the end.

    Args:
        path: the path of the socket; one left behind by a dead run is replaced.
        commands: called in a thread of the server; their results must be valid in JSON.
        waits: whether requests wait until :meth:`answer` is called.

    Raises:
        ExperimentError: another run listens there, or the socket cannot be made.
    """

    def __init__(self, path: Path, commands: Commands, *, waits: bool = False) -> None:
        _make_way(path)
        try:
            self._server = _Server(path, commands)
        except OSError as error:
            raise ExperimentError(f"cannot listen here: {error.strerror or error}", path=path) from error
        self._path = path
        self._thread: threading.Thread | None = None
        self._closed = False
        if not waits:
            self.answer()

    def answer(self) -> None:
        """Answer the waiting requests, and all later ones at once."""
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.05,), daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop listening and remove the socket; calling it again does nothing."""
        if self._closed:
            return
        self._closed = True
        if self._thread is not None:
            self._server.shutdown()
            self._thread.join()
        self._server.server_close()
        self._path.unlink(missing_ok=True)


def send_command(path: Path, command: str, *, timeout_s: float = 5.0, **arguments: Any) -> Any:
    """Give a command to the run that listens on a socket, and return its answer.

    Args:
        path: the path of the socket.
        command: e.g. ``publish``.
        timeout_s: maximum time to wait for the answer, s.
        arguments: arguments of the command, valid in JSON.

    Raises:
        ExperimentError: no run listens there, or it refuses the command, with its message.
    """
    request = {"command": command, **arguments}
    try:
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(timeout_s)
            connection.connect(str(path))
            connection.sendall(json.dumps(request).encode() + b"\n")
            answer = json.loads(connection.makefile("rb").readline(MAX_LINE))
            refusal = None if answer["ok"] else str(answer["error"])
    except OSError as error:
        raise ExperimentError(f"no run listens here: {error.strerror or error}", path=path) from error
    except (ValueError, TypeError, KeyError) as error:
        raise ExperimentError("the program that listens here is not a run", path=path) from error
    if refusal is not None:
        raise ExperimentError(refusal)
    return answer.get("result")


def _make_way(path: Path) -> None:
    """Remove the socket of a run that is dead."""
    try:
        if not stat.S_ISSOCK(path.lstat().st_mode):
            raise ExperimentError("there is a file that is not a socket", path=path)
        with socket.socket(socket.AF_UNIX) as probe:
            probe.connect(str(path))
    except FileNotFoundError:
        return
    except ConnectionRefusedError:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise ExperimentError(f"cannot listen here: {error.strerror or error}", path=path) from error
    else:
        raise ExperimentError("another run listens here", path=path)


class _Server(socketserver.ThreadingTCPServer):
    address_family = getattr(socket, "AF_UNIX", socket.AF_INET)  # Windows lacks it; AF_INET refuses a path
    daemon_threads = True

    def __init__(self, path: Path, commands: Commands) -> None:
        self.commands = commands
        deaf = path.with_name(f"{path.name}~")  # named when it listens, so that no client is refused
        deaf.unlink(missing_ok=True)
        super().__init__(cast(Any, str(deaf)), _Handler)
        try:
            path.hardlink_to(deaf)
        except OSError:
            self.server_close()
            raise
        finally:
            deaf.unlink(missing_ok=True)

    def server_bind(self) -> None:
        os.fchmod(self.socket.fileno(), 0o600)  # before other users could open it by its name
        super().server_bind()


class _Handler(socketserver.StreamRequestHandler):
    server: _Server

    def handle(self) -> None:
        while line := self.rfile.readline(MAX_LINE):
            try:
                answer: dict[str, Any] = {"ok": True, "result": self._obey(line)}
            except NrpError as error:
                answer = {"ok": False, "error": str(error)}
            self.wfile.write(json.dumps(answer).encode() + b"\n")

    def _obey(self, line: bytes) -> Any:
        try:
            arguments = json.loads(line)
            name = str(arguments.pop("command"))
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise ExperimentError("a request is a JSON object with a 'command' and its arguments") from error
        commands = self.server.commands
        if name not in commands:
            raise ExperimentError(f"no command '{name}'{did_you_mean(name, commands)}")
        takes = inspect.signature(commands[name])
        try:
            takes.bind(**arguments)
        except TypeError as error:
            raise ExperimentError(f"'{name}' takes {', '.join(takes.parameters)}: {error}") from error
        return commands[name](**arguments)
