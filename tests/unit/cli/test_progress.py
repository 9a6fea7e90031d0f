"""What a run shows while it goes."""

import io
import re
from types import SimpleNamespace
from typing import Any

import pytest
from rich.console import Console

from nrp_core._support.stopwatch import work
from nrp_core.cli import progress
from nrp_core.cli.progress import HINT, SCRIPT_HINT, Bar, Lines, display

SHARES = {"brain": 0.1, "world": 0.6, "transfer_functions": 0.2, "engine": 0.1}


def run_at(now_s: float) -> Any:
    """Something that looks like a run for a display."""
    account = SimpleNamespace(shares=lambda: SHARES)
    loop, experiment = SimpleNamespace(account=account), SimpleNamespace(name="driving")
    observers: list[Any] = []
    return SimpleNamespace(
        on_step=observers.append, observers=observers, now_s=now_s, loop=loop, experiment=experiment
    )


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The displays' clock, set by hand."""
    now = SimpleNamespace(s=100.0)
    monkeypatch.setattr(progress, "monotonic", lambda: now.s)
    return now


def test_without_a_terminal_a_line_comes_now_and_then(clock: Any, capsys: pytest.CaptureFixture[str]) -> None:
    run = run_at(0.0)
    with Lines() as lines:
        lines.watch(run, 60.0)
        for second in range(25):
            clock.s, run.now_s = 100.0 + second, 5.0 * second
            run.observers[0](run)
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines() == [
        "50.0 of 60 s, 5.0 x real time (brain 10%, world 60%, functions 20%, loop 10%)",
        "100.0 of 60 s, 5.0 x real time (brain 10%, world 60%, functions 20%, loop 10%)",
    ]


def test_a_notebook_that_asks_for_colours_gets_no_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("FORCE_COLOR", "CLICOLOR_FORCE", "CLICOLOR"):  # as the kernel of Jupyter sets them
        monkeypatch.setenv(name, "1")
    assert isinstance(display(), Lines)


def test_a_long_task_is_explained(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress, "PATIENCE_S", 0.01)
    with Lines() as lines:
        lines.begin_task("opening the brain (event)")
        assert lines._timer is not None
        lines._timer.join()
        work.stop()  # as while code is compiled
        lines.begin_task("opening the brain (event)")
        lines._timer.join()
        work.go_on()
        lines.begin_task("executing the brain script brain.py")
        lines._timer.join()
    opening, compiling, executing = capsys.readouterr().err.splitlines()
    assert opening == "opening the brain (event); still working"
    assert compiling == f"opening the brain (event); {HINT}"
    assert executing == f"executing the brain script brain.py; {SCRIPT_HINT}"


def test_a_short_task_is_not_mentioned(capsys: pytest.CaptureFixture[str]) -> None:
    with Lines() as lines:
        lines.begin_task("opening the brain (event)")
        lines.watch(run_at(0.0), 60.0)
    assert capsys.readouterr().err == ""


def test_on_a_terminal_a_bar_shows_time_speed_and_what_takes_the_time(clock: Any) -> None:
    screen = io.StringIO()
    run = run_at(0.0)
    with Bar(Console(file=screen, force_terminal=True, width=140, legacy_windows=False)) as bar:
        bar.begin_task("opening the world (mujoco)")
        bar.watch(run, 60.0)
        run.observers[0](run)
        clock.s, run.now_s = 104.0, 20.0
        run.observers[0](run)
    shown = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", screen.getvalue())
    assert "driving" in shown
    assert "20.0 of 60 s, 5.0 x real time (brain 10%, world 60%, functions 20%, loop 10%)" in shown


def test_counts_are_printed_from_time_to_time_and_at_the_end(
    clock: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    with Lines() as lines:
        for done in range(26):
            clock.s += 1.0
            lines.count("runs", done, 25)
    assert capsys.readouterr().err.splitlines() == [
        "runs: 0 of 25", "runs: 10 of 25", "runs: 20 of 25", "runs: 25 of 25"
    ]  # fmt: skip


def test_on_a_terminal_a_bar_shows_how_many_are_done() -> None:
    screen = io.StringIO()
    with Bar(Console(file=screen, force_terminal=True, width=120, highlight=False)) as bar:
        bar.count("runs", 3, 25, "event-mujoco-7")
    assert "3 of 25" in re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", screen.getvalue())
