"""Who may come in, asked over real sockets."""

from __future__ import annotations

import gzip
import socket
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import pytest
from nrp_cockpit.wire.address import EVERY, names_of, opened_in_browser
from nrp_cockpit.wire.files import file_response
from nrp_cockpit.wire.guard import CONTENT_POLICY, Guard
from nrp_cockpit.wire.hub import Hub
from nrp_cockpit.wire.server import WRONG_S, Server
from websockets.datastructures import Headers

from nrp_core.errors import ExperimentError

GUARD = Guard(token="steering", watch_token="watching")
UPGRADE = (
    "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: "
    + "A" * 22
    + "=="
)


class Answer(NamedTuple):
    """What the server said."""

    status: int
    headers: Headers
    body: bytes


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page, and a secret beside it."""
    folder = tmp_path_factory.mktemp("plugin").resolve()
    (folder / "secret.txt").write_text("secret")
    static = folder / "static"
    (static / "assets").mkdir(parents=True)
    (static / "index.html").write_text("<!doctype html>")
    (static / "assets" / "main-1a2b.js").write_text("go()")
    (static / ".hidden").write_text("hidden")
    (static / "way_out").symlink_to(folder / "secret.txt")
    return static


@pytest.fixture(scope="module")
def server(page: Path) -> Iterator[Server]:
    server = Server(Hub(), guard=GUARD, static=page)
    yield server
    server.close()


def ask(server: Server, target: str, *headers: str, host: str = "127.0.0.1:{port}") -> Answer:
    """Send a request as it stands and return the answer; a browser would tidy it up."""
    lines = [
        f"GET {target} HTTP/1.1",
        *([f"Host: {host.format(port=server.port)}"] if host else []),
        *headers,
    ]
    with socket.create_connection(("127.0.0.1", server.port), timeout=60) as connection:
        connection.sendall("\r\n".join([*lines, "", ""]).encode())
        received = b""
        while b"\r\n\r\n" not in received or " 101 " not in received.decode(errors="replace")[:20]:
            part = connection.recv(65536)
            if not part:
                break
            received += part
    head, _, body = received.partition(b"\r\n\r\n")
    status, *fields = head.decode().split("\r\n")
    named = Headers([(name, value) for name, _, value in (field.partition(": ") for field in fields)])
    return Answer(int(status.split()[1]), named, body)


def test_a_page_is_served(server: Server) -> None:
    answer = ask(server, "/")
    assert (answer.status, answer.body) == (200, b"<!doctype html>")
    assert answer.headers["Cache-Control"] == "no-cache"


def test_files_named_after_their_content_are_kept_by_browsers(server: Server) -> None:
    answer = ask(server, "/assets/main-1a2b.js")
    assert answer.headers["Content-Type"] == "text/javascript"
    assert "immutable" in answer.headers["Cache-Control"]


@pytest.mark.parametrize(
    ("accepted", "packed"),
    [
        ("gzip", True),
        ("br, GZIP;q=0.5", True),
        ("gzip;q=0", False),
        ("gzip; q=0.0, br", False),
        ("br", False),
    ],
)
def test_text_is_sent_packed_to_whom_takes_it(server: Server, accepted: str, packed: bool) -> None:
    answer = ask(server, "/assets/main-1a2b.js", f"Accept-Encoding: {accepted}")
    assert (answer.headers.get("Content-Encoding") == "gzip") is packed
    assert (gzip.decompress(answer.body) if packed else answer.body) == b"go()"
    assert answer.headers["Content-Length"] == str(len(answer.body))
    assert answer.headers["Vary"] == "Accept-Encoding"


@pytest.mark.parametrize("target", ["/", "/index.html", "/assets/main-1a2b.js", "/nothing", "/?token=x"])
def test_every_answer_says_where_the_page_may_load_from(server: Server, target: str) -> None:
    headers = ask(server, target).headers
    assert headers["Content-Security-Policy"] == CONTENT_POLICY
    assert headers["X-Content-Type-Options"] == "nosniff"


def test_the_page_runs_no_scripts_but_its_own() -> None:
    rules = dict(rule.strip().split(" ", 1) for rule in CONTENT_POLICY.split(";"))
    assert rules["default-src"] == "'none'"
    assert rules["script-src"] == rules["connect-src"] == "'self'"
    assert rules["frame-ancestors"] == rules["frame-src"] == "'self'"  # two runs stand beside each other


@pytest.mark.parametrize(
    "target",
    [
        "/../secret.txt", "/assets/../../secret.txt", "//secret.txt", "/..%2fsecret.txt",
        "/%2e%2e/secret.txt", "/..\\secret.txt", "/way_out", "/.hidden", "/assets", "/" + "a" * 5000,
        "//[", "/a\x00b",
    ],
)  # fmt: skip
def test_nothing_but_files_of_the_page_is_served(server: Server, target: str) -> None:
    answer = ask(server, target)
    assert answer.status in (400, 404)
    assert b"secret" not in answer.body
    assert b"hidden" not in answer.body


def test_an_absolute_path_stays_in_the_page(server: Server, page: Path) -> None:
    assert ask(server, f"/{page.parent / 'secret.txt'}").status == 404


def test_a_page_that_was_not_built_says_so(tmp_path: Path) -> None:
    answer = file_response("/", tmp_path / "static")
    assert answer.status_code == 404
    assert b"npm run build" in answer.body


@pytest.mark.parametrize("host", ["127.0.0.1:{port}", "localhost:{port}", "[::1]:{port}", "LOCALHOST"])
def test_this_machine_may_be_called_by_its_own_names(server: Server, host: str) -> None:
    assert ask(server, "/", host=host).status == 200


@pytest.mark.parametrize(
    "host", ["evil.example:{port}", "127.0.0.1.evil.example", "localhost.evil:{port}", "evil@localhost", ""]
)
def test_a_name_that_somebody_points_at_this_machine_is_refused(server: Server, host: str) -> None:
    for headers in ([], [UPGRADE]):
        assert ask(server, "/?token=steering", *headers, host=host).status == 403


def test_two_hosts_or_origins_are_refused(server: Server) -> None:
    assert ask(server, "/", "Host: evil.example").status == 403
    own = f"Origin: http://127.0.0.1:{server.port}"
    assert ask(server, "/", own, own).status == 403


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "null", "http://127.0.0.1:1", "http://[", "file://", "http://x@127.0.0.1:{port}"],
)
def test_pages_of_other_sites_are_refused(server: Server, origin: str) -> None:
    header = f"Origin: {origin.format(port=server.port)}"
    for headers in ([header], [header, UPGRADE]):
        answer = ask(server, "/?token=steering", *headers)
        assert answer.status == 403
        assert b"may not use this server" in answer.body


def test_its_own_page_may_connect(server: Server) -> None:
    origin = f"Origin: http://127.0.0.1:{server.port}"
    assert ask(server, "/?token=steering", origin, UPGRADE).status == 101


@pytest.mark.parametrize(
    "target", ["/", "/?token=", "/?token=wrong", "/?token=steerin", "/?token=%ff", "/?tok=steering"]
)
def test_a_connection_without_the_token_is_refused(server: Server, target: str) -> None:
    answer = ask(server, target, UPGRADE)
    assert answer.status == 401
    assert b"token" in answer.body


@pytest.mark.parametrize(("token", "watches", "steers"), [
    ("steering", True, True), ("watching", True, False), ("", False, False), ("Steering", False, False),
    ("é", False, False),
])  # fmt: skip
def test_a_token_lets_its_owner_steer_or_watch(token: str, watches: bool, steers: bool) -> None:
    assert (GUARD.may_watch(token), GUARD.may_steer(token)) == (watches, steers)


def test_every_guard_has_tokens_of_its_own() -> None:
    tokens = {token for guard in (Guard(), Guard()) for token in (guard.token, guard.watch_token)}
    assert len(tokens) == 4
    assert all(len(token) >= 32 for token in tokens)


@pytest.mark.parametrize(
    ("listens", "host", "is_taken"),
    [
        ("0.0.0.0", "192.0.2.7:80", True), ("0.0.0.0", "[2001:db8::7]:80", True),
        ("0.0.0.0", "localhost", True),
        ("0.0.0.0", f"{socket.gethostname()}:80", True), ("0.0.0.0", "evil.example:80", False),
        ("::", "192.0.2.7", True), ("robot.lab", "Robot.lab:80", True), ("robot.lab", "192.0.2.7", False),
        ("robot.lab", "localhost", False), ("192.0.2.7", "192.0.2.7:80", True),
        ("2001:db8::7", "[2001:db8::7]", True),
        ("localhost", "192.0.2.7", False),
    ],
)  # fmt: skip
def test_a_server_answers_to_the_names_of_its_address(listens: str, host: str, is_taken: bool) -> None:
    guard = Guard(names_of(listens), listens in EVERY)
    assert (guard.refusal(Headers({"Host": host})) is None) is is_taken
    assert guard.refusal(Headers({"Host": host, "Origin": "http://evil.example"})) is not None


def test_a_browser_gets_the_token_in_a_file_of_the_user(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[str] = []
    monkeypatch.setattr("webbrowser.open", given.append)
    with opened_in_browser("http://127.0.0.1:1/?token=a&b#/start") as file:
        assert given == [file.as_uri()]
        assert "token" not in given[0]
        assert (file.stat().st_mode & 0o777, file.parent.stat().st_mode & 0o777) == (0o600, 0o700)
        assert 'url=http://127.0.0.1:1/?token=a&amp;b#/start"' in file.read_text()
    assert not file.exists()


def test_wrong_tokens_wait_for_each_other_and_the_right_one_does_not(server: Server) -> None:
    with ThreadPoolExecutor(4) as threads:
        began = time.monotonic()
        wrong = [threads.submit(ask, server, "/?token=wrong", UPGRADE) for _ in range(3)]
        assert ask(server, "/?token=steering", UPGRADE).status == 101
        assert not any(one.done() for one in wrong)
        assert [one.result().status for one in wrong] == [401] * 3
        assert time.monotonic() - began >= 3 * WRONG_S


def test_a_port_that_is_taken_is_an_error_that_names_it(server: Server) -> None:
    with pytest.raises(ExperimentError, match=f"127.0.0.1:{server.port}"):
        Server(Hub(), port=server.port, guard=GUARD)
