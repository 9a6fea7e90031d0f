"""A check executes a brain script without network, and lets it write only temporary files."""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from nrp_core._support import probe
from nrp_core._support.forked import Forker
from nrp_core.checks.validate import validate_file
from nrp_core.cli.app import run_app
from nrp_core.findings import Finding, Level


def problem(folder: Path) -> Finding:
    """Return the only finding about an experiment that is not a note about its functions."""
    (finding,) = [one for one in validate_file(folder) if one.level is not Level.NOTE]
    return finding


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
    finding = problem(husky)
    assert "a check executes the script without network access" in finding.message


def test_a_file_with_other_contents_has_nothing_to_do_with_rights(husky: Path) -> None:
    pytest.importorskip("nir")
    (husky / "net.nir").write_text("hello")
    found = [one.message for one in validate_file(husky, [f"brain.model={husky}/net.nir"])]
    (message,) = [one for one in found if "is not a NIR file" in one]
    assert "network access" not in message
    (husky / "brain.py").write_text("open('no/such/file')\n")
    finding = problem(husky)
    assert "No such file" in finding.message
    assert "a check executes" not in finding.message


@pytest.mark.one_of(8)
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="confinement needs Linux")
@pytest.mark.parametrize(
    ("statement", "error"),
    [
        ("open('{beside}/written', 'w')", "PermissionError"),
        ("os.remove('{beside}/room.sdf')", "PermissionError"),
        ("os.mkdir('{beside}/made')", "PermissionError"),
        ("subprocess.run(['touch', '{beside}/touched'], check=True)", "CalledProcessError"),
        ("socket.create_connection(('127.0.0.1', {port}), timeout=5)", "PermissionError"),
        ("bytearray(10**15)", "MemoryError"),
        ("socket.socket(socket.AF_UNIX).connect('{unix}')", "PermissionError"),
        ("socket.socket(socket.AF_UNIX).connect('\\0nrp-test-abstract')", "PermissionError"),
        ("os.kill({victim}, 15)", "ProcessLookupError"),
        ("os.chmod('{beside}/room.sdf', 0o777)", "PermissionError"),
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


ALLOWED = {
    "read a file": "a script can read what its user can read",
    "read a program": "the same",
    "write a temporary file": "in a folder of its own",
    "run a program": "it is confined like the script",
    "leave a process behind": "it ends with the script",
    "send elsewhere from a stream": "the system ignores the other address",
    "end all processes": "of its own namespace",
}
"""What a script may do, and why that does no harm."""
ALLOWED_TO_ROOT = {
    "start many processes": "the system does not limit those of root; they end with the script"
}
LINUX = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="confinement needs Linux")
ROOT = os.geteuid() == 0


@pytest.fixture
def outside() -> Iterator[Path]:
    """A folder of the user, not below the temporary ones of pytest, which only their owner can enter."""
    folder = Path("/var/tmp") / f"nrp-attempts-{os.getpid()}"
    folder.mkdir(mode=0o777)
    folder.chmod(0o777)
    for name in ("kept", "scratch"):
        (folder / name).mkdir(mode=0o777) if name == "scratch" else (folder / name).write_text("kept")
    (folder / "scratch").chmod(0o777)
    (folder / "kept").chmod(0o600)
    os.mkfifo(folder / "pipe")
    yield folder
    shutil.rmtree(folder)


def attempt(outside: Path, before: list[str]) -> dict[str, str]:
    """Return what came of all attempts of a program that a command starts, beside a process and sockets."""
    program = Path(__file__).with_name("attempts.py")
    libc = ctypes.CDLL(None)
    segment = libc.shmget(0, 4096, 0o666 | 0o1000)
    with contextlib.ExitStack() as stack:
        stack.callback(libc.shmctl, segment, 0, None)
        server = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
        stack.enter_context(socket.create_server(str(outside / "stream"), family=socket.AF_UNIX))
        datagrams = stack.enter_context(socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM))
        datagrams.bind(str(outside / "datagrams"))
        datagrams.setblocking(False)
        victim = stack.enter_context(subprocess.Popen(["sleep", "60"], start_new_session=True))
        stack.callback(victim.kill)
        state = state_of(outside, victim.pid)
        words = [outside / "scratch", outside, victim.pid, server.getsockname()[1], segment]
        done = subprocess.run(
            [*before, sys.executable, "-P", str(program), *map(str, words)],
            capture_output=True, text=True, check=True, timeout=120,
        )  # fmt: skip
        assert left_behind(str(program)) == []
        assert state_of(outside, victim.pid) == state
        with pytest.raises(BlockingIOError):
            datagrams.recv(100)
    answer = json.loads(done.stdout)
    assert answer["lacking"] == []
    found: dict[str, str] = answer["found"]
    return found


def state_of(outside: Path, victim: int) -> list[object]:
    """Return all that an attempt could have changed."""
    kept = outside / "kept"
    status = kept.stat()
    return [
        sorted(path.name for path in outside.iterdir()), kept.read_text(), status.st_mode, status.st_mtime_ns,
        status.st_uid, status.st_nlink, outside.stat().st_mode, os.listxattr(kept), socket.gethostname(),
        os.getpriority(os.PRIO_PROCESS, victim), os.sched_getaffinity(victim), os.sched_getscheduler(victim),
        *(Path(f"/proc/{victim}/{name}").read_text() for name in ("limits", "oom_score_adj")),
        Path(f"/proc/{victim}/exe").exists(), Path("/dev/shm/nrp-attempt").exists(),
    ]  # fmt: skip


def left_behind(program: str) -> list[str]:
    """Return the processes of a program that go on, after a moment."""
    found: list[str] = []
    for _ in range(100):
        found = []
        for path in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                is_dead = (path / "stat").read_text().rpartition(")")[2].split()[0] == "Z"
                if program in (path / "cmdline").read_text() and not is_dead:
                    found.append(path.name)
        if not found:
            break
        time.sleep(0.01)
    return found


WITHOUT_RIGHTS = ["setpriv", "--bounding-set=-all", "--inh-caps=-all"]


@LINUX
@pytest.mark.parametrize("before", [[], WITHOUT_RIGHTS] if ROOT else [[]], ids=len)
def test_each_attempt_to_reach_beyond_the_process_is_refused_or_harmless(
    outside: Path, before: list[str]
) -> None:
    """Root is tried with its rights and without them."""
    found = attempt(outside, before)
    done = {name: result for name, result in found.items() if result != "refused"}
    assert set(done) <= {*ALLOWED, *(ALLOWED_TO_ROOT if ROOT else {})}, done
    assert len(found) >= 71


@pytest.mark.one_of(3)
@LINUX
@pytest.mark.parametrize("before", [[], WITHOUT_RIGHTS] if ROOT else [[]], ids=len)
def test_the_libraries_of_experiments_work_in_a_confined_process(tmp_path: Path, before: list[str]) -> None:
    """Sandboxes of others forgot calls of NumPy's threads and memory, of HDF5's locks and of event loops."""
    program = Path(__file__).with_name("computations.py")
    done = subprocess.run(
        [*before, sys.executable, "-P", str(program), str(tmp_path)],
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    assert json.loads(done.stdout.splitlines()[-1]) == {
        "lacking": [], "numpy": 1.0, "scipy": 3.0, "opencv": [99, 99, 3], "matplotlib": "PNG", "numba": 42,
        "hdf5": [1, 2], "pynn": 100, "program": "a\n", "threads": [1, 2], "events": "slept",
    }  # fmt: skip


MISSING = {
    "Landlock": "confinement._landlock_version = lambda: 0",
    "seccomp": "confinement.allow_own_calls = lambda **_: False",
    "namespaces": "confinement._enter_namespaces = lambda: False",
}


@pytest.mark.one_of(6)
@LINUX
@pytest.mark.parametrize("missing", MISSING)
def test_a_script_is_executed_only_where_it_can_be_confined(
    husky: Path, missing: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    """The system lacks one means in all children; without namespaces the others suffice."""
    (tmp_path / "sitecustomize.py").write_text(
        f"import sys\nfrom nrp_core._support import confinement\n{MISSING[missing]}\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(probe, "_FORKER", Forker())
    mark = husky / "MARK"
    brain = husky / "brain.py"
    code = f"open({str(mark)!r}, 'w')" if missing != "namespaces" else "import os; os.getpid() > 2 or 1 / 0"
    brain.write_text(f"{code}  # {missing}\n{brain.read_text()}")
    words = ["validate", str(husky)]
    code_of_exit = run_app(words)
    told = capsys.readouterr()
    if missing == "namespaces":
        assert (code_of_exit, told.out) == (0, "valid\n")
        return
    assert (code_of_exit, told.out) == (0, "valid, but not checked in full (NRP239)\n")
    assert run_app([*words, "-v"]) == 0
    assert f"{missing} cannot be used; --trust executes it" in capsys.readouterr().err
    assert run_app(["map", *words[1:]]) == 3
    assert f"{missing} cannot be used" in capsys.readouterr().err
    assert not mark.exists()
    assert run_app([*words, "--trust"]) == 0
    assert mark.exists()
    assert capsys.readouterr().out == "valid\n"


@pytest.mark.heavy
@LINUX
def test_without_namespaces_a_process_that_is_left_behind_ends_with_its_group(
    husky: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sitecustomize.py").write_text(
        f"from nrp_core._support import confinement\n{MISSING['namespaces']}\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(probe, "_FORKER", Forker())
    brain = husky / "brain.py"
    for turn in range(2):  # of a new interpreter, and of a fork
        leave = f"import subprocess, os\nsubprocess.Popen(['sleep', '61{turn}{os.getpid()}'])\n"
        brain.write_text(f"{leave}{brain.read_text()}")
        validate_file(husky)
        assert left_behind(f"sleep\x0061{turn}{os.getpid()}") == []


@pytest.mark.parametrize(
    ("command", "executed", "where"),
    [
        ("validate", "the brain script and the transfer functions are executed", "in processes"),
        ("map", "executes the brain script", "in a process"),
    ],
)
def test_the_help_says_that_a_check_executes_the_brain_script(
    command: str, executed: str, where: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run_app([command, "--help"]) == 0
    told = " ".join(capfd.readouterr().out.replace("│", " ").split()).lower()
    assert executed in told
    assert f"{where} without network that can write only temporary files" in told
