"""A check executes a brain script without network, and lets it write only temporary files."""

from __future__ import annotations

import contextlib
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from nrp_core.checks.validate import validate_file
from nrp_core.cli.app import run_app


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="confinement needs Linux")
@pytest.mark.parametrize(
    "line",
    [
        "open(__file__ + '.side', 'w')",
        "import urllib.request; urllib.request.urlopen('http://example.org')",
    ],
)
def test_a_script_without_a_right_in_a_check_gets_that_reason(
    husky: Path, line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "scratch").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "scratch"))  # pytest's own folders are temporary files too
    (husky / "brain.py").write_text(f"{line}\n")
    (finding,) = validate_file(husky)
    assert "a check executes the script without network access" in finding.message


def test_a_file_with_other_contents_has_nothing_to_do_with_rights(husky: Path) -> None:
    pytest.importorskip("nir")
    (husky / "net.nir").write_text("hello")
    found = [one.message for one in validate_file(husky, [f"brain.model={husky}/net.nir"])]
    (message,) = [one for one in found if "is not a NIR file" in one]
    assert "network access" not in message
    (husky / "brain.py").write_text("open('no/such/file')\n")
    (finding,) = validate_file(husky)
    assert "No such file" in finding.message
    assert "a check executes" not in finding.message


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="confinement needs Linux")
@pytest.mark.parametrize(
    ("statement", "error"),
    [
        ("open('{beside}/written', 'w')", "PermissionError"),
        ("os.remove('{beside}/room.sdf')", "PermissionError"),
        ("os.mkdir('{beside}/made')", "PermissionError"),
        ("subprocess.run(['touch', '{beside}/touched'], check=True)", "CalledProcessError"),
        ("socket.create_connection(('127.0.0.1', {port}), timeout=5)", "OSError"),
        ("bytearray(10**15)", "MemoryError"),
        ("socket.socket(socket.AF_UNIX).connect('{unix}')", "PermissionError"),
        ("socket.socket(socket.AF_UNIX).connect('\\0nrp-test-abstract')", "PermissionError"),
        ("os.kill({victim}, 15)", "PermissionError"),
        ("open(os.path.join('{common}', 'written'), 'w')", "PermissionError"),
        ("open('/dev/shm/written', 'w')", "PermissionError"),
        ("open('/proc/{victim}/mem', 'r+b')", "PermissionError"),
    ],
)
def test_a_check_confines_the_script(
    husky: Path,
    tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    statement: str,
    error: str,
) -> None:
    """The temporary folder of the check is another one, so that the experiment is not in it."""
    brain = husky / "brain.py"
    monkeypatch.setenv("TMPDIR", str(tmp_path_factory.mktemp("temporary")))
    common = tmp_path_factory.mktemp("common")
    unix = str(common / "socket")
    with (
        socket.create_server(("127.0.0.1", 0)) as server,
        socket.create_server(unix, family=socket.AF_UNIX),
        subprocess.Popen(["sleep", "60"]) as victim,
        contextlib.ExitStack() as cleanup,
    ):
        cleanup.callback(victim.kill)
        code = statement.format(
            beside=husky, port=server.getsockname()[1], unix=unix, common=common, victim=victim.pid
        )
        brain.write_text(f"import ctypes, os, socket, subprocess\n{code}\n{brain.read_text()}")
        for command in ("validate", "map") if "beside}/written" in statement else ("validate",):
            capsys.readouterr()
            assert run_app([command, str(husky), "-s", "brain.backend=spinnaker"]) == 3
            assert f"brain.py:2: {error}" in capsys.readouterr().err
        assert victim.poll() is None
    assert (husky / "room.sdf").is_file()
    assert not {"written", "made", "touched"} & {path.name for path in husky.iterdir()}


@pytest.mark.parametrize("command", ["validate", "map"])
def test_the_help_says_that_a_check_executes_the_brain_script(
    command: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run_app([command, "--help"]) == 0
    told = " ".join(capfd.readouterr().out.replace("│", " ").split()).lower()
    assert "brain script" in told
    assert "in a process without network that can write only temporary files" in told
