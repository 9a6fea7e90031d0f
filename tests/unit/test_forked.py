"""Modules that are run in forks of a process that has loaded their libraries."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from nrp_core._support.forked import Forker, ForkResult

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="forks are used on Linux only")

ASKED = """\
import importlib.util, os, random, subprocess, sys, time

CALLS = []


def load():
    pass


def main(question, *arguments):
    CALLS.append(question)
    return globals()[question](*arguments)


def count():
    print(len(CALLS), os.getpid(), random.random())


def leave(code):
    print("oh", file=sys.stderr)
    sys.exit(int(code) if code.isdigit() else code)


def fail():
    raise ValueError("no")


def crash():
    os.kill(os.getpid(), 9)


def describe():
    print(os.getcwd(), os.environ.get("OWN"), sys.argv[1:], os.getcwd() in sys.path, threads())
    print(*sorted(os.listdir("/proc/self/fd")), os.getsid(0) == os.getpid())


def threads():
    return len(os.listdir("/proc/self/task"))


def find(name):
    print(importlib.util.find_spec(name) is not None)


def hang():
    subprocess.run([sys.executable, "-c", "import time; time.sleep(600)"])
"""


@pytest.fixture(scope="module")
def forker(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Forker]:
    """One that has run the module ``asked`` before."""
    site = tmp_path_factory.mktemp("site")
    (site / "asked.py").write_text(ASKED)
    (site / "asked_too.py").write_text(ASKED)
    (site / "beside.py").touch()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(site))
        forker = Forker()
        assert forker.run("asked", ["count"], 30.0) is None  # most programs ask once
        yield forker
        forker.end()


def done(forker: Forker, *arguments: str, timeout_s: float = 30.0) -> ForkResult:
    result = forker.run("asked", list(arguments), timeout_s)
    assert result is not None
    return result


def assert_apart(run: Callable[[], str]) -> None:
    """Check that two runs share neither what they have changed nor their random numbers."""
    (one, first, drawn), (two, second, again) = (run().split() for _ in range(2))
    assert (one, two) == ("1", "1")
    assert first != second
    assert drawn != again


def test_runs_share_nothing(forker: Forker) -> None:
    assert_apart(lambda: done(forker, "count").output)


def test_runs_in_one_process_are_found_to_share(capsys: pytest.CaptureFixture[str]) -> None:
    space: dict[str, Any] = {}
    exec(ASKED, space)

    def in_place() -> str:
        space["main"]("count")
        return capsys.readouterr().out

    with pytest.raises(AssertionError):
        assert_apart(in_place)


@pytest.mark.parametrize(
    ("arguments", "code", "last"),
    [
        (["leave", "3"], 3, "oh"),
        (["leave", "bye"], 1, "bye"),
        (["fail"], 1, "ValueError: no"),
        (["crash"], -9, None),
    ],
)
def test_a_fork_ends_as_a_new_interpreter_does(
    forker: Forker, arguments: list[str], code: int, last: str | None
) -> None:
    result = done(forker, *arguments)
    assert result.exit_code == code
    assert (result.errors.splitlines() or [None])[-1] == last


def test_a_fork_has_the_surroundings_of_its_caller_and_no_other_files(
    forker: Forker, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("OWN", "value")
    told, files = done(forker, "describe").output.splitlines()
    assert told == f"{tmp_path} value ['describe'] False 1"  # one thread
    assert files == "0 1 2 3 True"  # 3 is the folder of files that it lists


def test_a_fork_finds_the_modules_that_a_new_interpreter_would(
    forker: Forker, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "own_module.py").touch()
    assert done(forker, "find", "own_module").output == "False\n"
    assert done(forker, "find", "beside").output == "True\n"
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    assert done(forker, "find", "own_module").output == "True\n"
    assert done(forker, "find", "beside").output == "False\n"


def test_a_fork_that_takes_too_long_is_ended_with_whatever_it_started(forker: Forker) -> None:
    before = set(sleepers())
    assert done(forker, "hang", timeout_s=0.5) == ForkResult(None, "", "")
    for _ in range(500):  # the system takes a moment
        if set(sleepers()) <= before:
            break
        time.sleep(0.01)
    else:
        raise AssertionError("it runs on")
    assert done(forker, "count").exit_code == 0


def sleepers() -> Iterator[str]:
    for path in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if (
                "time.sleep(600)" in (path / "cmdline").read_text()
                and " Z " not in (path / "stat").read_text()
            ):
                yield path.name


def test_without_a_process_to_fork_it_leaves_the_run_to_its_caller(forker: Forker) -> None:
    pid = int(done(forker, "count").output.split()[1])
    parent = forker._worker
    assert parent is not None
    assert pid != parent.process.pid
    parent.process.kill()
    parent.process.wait()
    assert forker.run("asked", ["count"], 30.0) is None
    assert done(forker, "count").exit_code == 0
    with forker._lock:  # another thread is at it
        assert forker.run("asked", ["count"], 30.0) is None


def test_another_value_of_a_variable_that_is_read_once_takes_another_process(
    forker: Forker, monkeypatch: pytest.MonkeyPatch
) -> None:
    done(forker, "count")
    before = forker._worker
    monkeypatch.setenv("OWN", "other")
    done(forker, "count")
    assert forker._worker is before
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    done(forker, "count")
    assert forker._worker is not before


def test_two_modules_are_forked_from_one_process(forker: Forker) -> None:
    assert done(forker, "count").exit_code == 0
    first = forker._worker
    forker.run("asked_too", ["count"], 30.0)
    assert forker.run("asked_too", ["count"], 30.0) is not None
    assert done(forker, "count").exit_code == 0
    assert first is not None
    assert forker._worker is first
