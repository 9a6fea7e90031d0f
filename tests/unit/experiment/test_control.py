"""Talking to a run through a Unix socket."""

import json
import socket
import socketserver
import stat
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from golden import Golden

from nrp_core.errors import ExperimentError, TopicError
from nrp_core.experiment.running.control import ControlServer, send_command


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "run.sock"


@pytest.fixture
def published(path: Path) -> Iterator[list[Any]]:
    """What the server was told to publish; it refuses the topic ``/nobody``."""
    told: list[Any] = []

    def publish(topic: str, value: Any) -> None:
        if topic == "/nobody":
            raise TopicError("no topic '/nobody'")
        told.append((topic, value))

    with ControlServer(path, {"publish": publish}):
        yield told


def ask(path: Path, *lines: bytes) -> list[dict[str, Any]]:
    with socket.socket(socket.AF_UNIX) as connection:
        connection.settimeout(60)
        connection.connect(str(path))
        connection.sendall(b"".join(line + b"\n" for line in lines))
        answers = connection.makefile("rb")
        return [json.loads(answers.readline()) for _ in lines]


def test_a_message_reaches_the_run(path: Path, published: list[Any]) -> None:
    send_command(path, "publish", topic="/screens/left/color", value="red")
    send_command(path, "publish", topic="/husky/cmd_vel", value={"linear": {"x": 1}})
    assert published == [("/screens/left/color", "red"), ("/husky/cmd_vel", {"linear": {"x": 1}})]


def test_the_runs_refusal_comes_back_in_its_own_words(
    path: Path, published: list[Any], golden: Golden
) -> None:
    with golden.raises(ExperimentError, match="'/nobody'"):
        send_command(path, "publish", topic="/nobody", value=1)
    assert published == []


@pytest.mark.parametrize(
    ("line", "error"),
    [
        (b"nonsense", "a request is a JSON object with"),
        (b"[1, 2]", "a request is a JSON object with"),
        (b'{"command": "publish"}', "'publish' takes topic, value: missing a required argument: 'topic'"),
        (b"\xff\xfe", "a request is a JSON object with"),
        (b'{"command": "publsh", "topic": "/a", "value": 1}', "no command 'publsh'; did you mean 'publish'?"),
    ],
)
def test_a_wrong_request_is_refused_and_the_connection_goes_on(
    path: Path, published: list[Any], line: bytes, error: str
) -> None:
    refused, accepted = ask(path, line, b'{"command": "publish", "topic": "/a", "value": 1}')
    assert refused["ok"] is False
    assert error in refused["error"]
    assert accepted == {"ok": True, "result": None}
    assert published == [("/a", 1)]


def test_only_its_user_may_open_the_socket(path: Path, published: list[Any]) -> None:
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_the_socket_is_gone_afterwards_and_closing_twice_does_nothing(path: Path) -> None:
    server = ControlServer(path, {})
    server.close()
    server.close()
    assert not path.exists()


def test_the_socket_of_a_dead_run_is_replaced(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as dead:
        dead.bind(str(path))
    assert path.exists()
    told: list[str] = []
    with ControlServer(path, {"publish": lambda topic, value: told.append(topic)}):
        send_command(path, "publish", topic="/a", value=1)
    assert told == ["/a"]


def test_a_second_run_on_one_socket_is_refused_and_the_first_goes_on(
    path: Path, published: list[Any], golden: Golden
) -> None:
    with golden.raises(ExperimentError):
        ControlServer(path, {})
    send_command(path, "publish", topic="/a", value=1)
    assert published == [("/a", 1)]


def test_a_file_that_is_not_a_socket_is_not_touched(path: Path, golden: Golden) -> None:
    path.write_text("precious")
    with golden.raises(ExperimentError):
        ControlServer(path, {})
    assert path.read_text() == "precious"


@pytest.mark.parametrize("name", ["missing/run.sock", "x" * 200])
def test_a_socket_that_cannot_be_made_is_one_error(tmp_path: Path, name: str, golden: Golden) -> None:
    with golden.raises(ExperimentError):
        ControlServer(tmp_path / name, {})


def test_a_command_without_a_listening_run_is_reported(path: Path, golden: Golden) -> None:
    with golden.raises(ExperimentError):
        send_command(path, "publish", topic="/a", value=1)


@pytest.mark.parametrize("answer", [b"hello\n", b"[]\n", b"{}\n", b""])
def test_a_listener_that_is_not_a_run_is_recognised(path: Path, answer: bytes, golden: Golden) -> None:
    with socket.socket(socket.AF_UNIX) as other:
        other.bind(str(path))
        other.listen()

        def reply() -> None:
            connection, _ = other.accept()
            with connection:
                connection.recv(4096)
                connection.sendall(answer)

        stranger = threading.Thread(target=reply)
        stranger.start()
        with golden.raises(ExperimentError):
            send_command(path, "publish", topic="/a", value=1)
        stranger.join()


def test_a_listener_that_never_answers_is_given_up_on(path: Path, golden: Golden) -> None:
    with socket.socket(socket.AF_UNIX) as other:
        other.bind(str(path))
        other.listen()
        with golden.raises(ExperimentError):
            send_command(path, "publish", topic="/a", value=1, timeout_s=0.05)


def test_a_socket_that_exists_is_listened_to(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen, listen = [], socketserver.TCPServer.server_activate

    def look(server: socketserver.TCPServer) -> None:
        seen.append(path.exists())
        listen(server)

    monkeypatch.setattr(socketserver.TCPServer, "server_activate", look)
    with ControlServer(path, {}, waits=True):
        assert path.is_socket()
    assert seen == [False]
    assert list(path.parent.iterdir()) == []
