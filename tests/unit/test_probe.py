"""Questions that are asked in a child process."""

import os
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path

import pytest

from nrp_core._support.probe import ChildResult, run_probe


@pytest.fixture
def module(site: Path) -> Path:
    """A module ``asked`` for a child process to run."""
    return site / "asked.py"


def test_an_answer_holds_the_output_of_the_child_and_its_end(module: Path) -> None:
    module.write_text("import sys; print(sys.argv[1]); print('oh', file=sys.stderr); sys.exit(3)")
    assert run_probe("asked", "yes") == ChildResult(3, "yes\n", "oh\n")


def test_a_child_that_is_killed_shows_the_signal(module: Path) -> None:
    module.write_text("import os; os.kill(os.getpid(), 9)")
    assert run_probe("asked") == ChildResult(-9)


def test_a_child_that_does_not_end_is_ended_with_whatever_it_started(module: Path, tmp_path: Path) -> None:
    grandchild = f"{sys.executable} -c 'import time; time.sleep(600)'"
    module.write_text(
        f"import os; open(r'{tmp_path}/pid', 'w').write(str(os.getpid())); os.system({grandchild!r})"
    )
    assert run_probe("asked", timeout_s=0.5) == ChildResult(None)
    group = (tmp_path / "pid").read_text()
    for _ in range(500):  # the system takes a moment
        if not alive(group):
            return
        time.sleep(0.01)
    raise AssertionError("it runs on")


@pytest.mark.one_of(6)
@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/schedstat").is_file(), reason="the system does not say it")
@pytest.mark.parametrize("start", ["", "import os\nif os.fork():\n    os.wait()\n    os._exit(0)\n"])
def test_time_in_which_others_had_the_processor_does_not_count(module: Path, start: str) -> None:
    """The child, or its child, computes for 1 s, and shares its processor with four others."""
    work = "import time\nwhile time.process_time() < 1.0:\n    pass\nprint('done', flush=True)"
    module.write_text(start + work)
    ours = os.sched_getaffinity(0)
    with ExitStack() as stack:
        stack.callback(os.sched_setaffinity, 0, ours)
        os.sched_setaffinity(0, {min(ours)})
        for _ in range(4):
            other = stack.enter_context(subprocess.Popen(
                [sys.executable, "-c", "while True: pass"],
                start_new_session=True,  # else the system may give all of them one share
            ))  # fmt: skip
            stack.callback(other.kill)
        assert run_probe("asked", timeout_s=2.5) == ChildResult(0, "done\n")


def alive(group: str) -> bool:
    """Return whether a process of a group runs."""
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, its_group = path.read_text().rpartition(")")[2].split()[:3]
        except OSError:
            continue  # it ended while we looked
        if its_group == group and state != "Z":
            return True
    return False


def test_an_answer_is_kept_under_all_that_it_depends_on(module: Path) -> None:
    module.write_text("import random; print(random.random())")
    first = run_probe("asked", depends_on="version 1")
    assert run_probe("asked", depends_on="version 1") == first
    assert run_probe("asked", depends_on="version 2") != first
    assert run_probe("asked", depends_on="version 1", refresh=True) != first


def test_without_a_place_to_keep_answers_it_is_asked_every_time(
    module: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    module.write_text("print('here')")
    assert run_probe("asked").exit_code == 0
    assert run_probe("asked").exit_code == 0


def test_a_damaged_answer_is_asked_anew(module: Path) -> None:
    module.write_text("print('here')")
    run_probe("asked")
    (kept,) = Path(os.environ["XDG_CACHE_HOME"]).rglob("*.json")
    kept.write_text('{"answer": {"nonsense": 1}}')
    assert run_probe("asked").output == "here\n"
