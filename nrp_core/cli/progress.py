"""Progress of a run on standard error: a bar on a terminal, occasional lines elsewhere."""

from __future__ import annotations

import sys
import threading
from abc import ABC, abstractmethod
from collections.abc import Mapping
from time import monotonic
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn
from rich.table import Column

from nrp_core._support.stopwatch import work
from nrp_core.cli.output import visible
from nrp_core.experiment.making.prepare import EXECUTING
from nrp_core.experiment.running.run import Run

PATIENCE_S = 2.0
HINT = "code is compiled for this machine, once"
SCRIPT_HINT = "this is the experiment's own code; brain.time_limit stops it"

_WIDE = 110
_SHORT = {"transfer_functions": "functions", "engine": "loop"}


def display() -> Display:
    """Return the display that suits standard error.

    Notebooks ask for colours (``FORCE_COLOR``), but keep every update of a bar as an output of its own.
    """
    console = Console(file=getattr(sys.stderr, "stream", sys.stderr), highlight=False)
    return Bar(console) if console.is_terminal and sys.stderr.isatty() else Lines()


def shares_text(shares: Mapping[str, float]) -> str:
    """Return the shares of the wall time as text."""
    return ", ".join(f"{_SHORT.get(name, name)} {share:.0%}" for name, share in shares.items())


def _hint(task: str) -> str:
    """Return the reason why a task takes long, if it is known."""
    if task.startswith(EXECUTING):
        return SCRIPT_HINT
    return HINT if work.is_stopped else "still working"


class Display(ABC):
    """Shows the current task and the progress of a run.

    Attributes:
        interval_s: wall time between two updates.
    """

    interval_s = 0.2

    def __init__(self) -> None:
        self._timer: threading.Timer | None = None
        self._next_s = self._began_s = 0.0
        self._end_s = 0.0

    def begin_task(self, task: str) -> None:
        """Show a task; if it takes long, also show a possible reason."""
        task = visible(task)
        self._stop_waiting()
        self._show_task(task)
        self._timer = threading.Timer(PATIENCE_S, self._show_delay, (task,))
        self._timer.daemon = True
        self._timer.start()

    def watch(self, run: Run, end_s: float) -> None:
        """Show the progress of a run until a simulated time."""
        self.begin_task("taking the first step")
        self._end_s = end_s
        run.on_step(self._after_step)

    def count(self, task: str, done: int, total: int, last: str = "") -> None:
        """Show the number of completed items and the name of the last one."""
        self._stop_waiting()
        self._show_count(visible(task), done, total, visible(last))

    def _after_step(self, run: Run) -> None:
        now_s = monotonic()
        if self._timer is not None:
            self._stop_waiting()
            self._began_s, self._next_s = now_s, now_s + self.interval_s
        if now_s >= self._next_s:
            self._next_s = now_s + self.interval_s
            self._show_progress(run, run.now_s / (now_s - self._began_s))

    def _stop_waiting(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop_waiting()

    @abstractmethod
    def _show_task(self, task: str) -> None: ...

    @abstractmethod
    def _show_delay(self, task: str) -> None: ...

    @abstractmethod
    def _show_progress(self, run: Run, factor: float) -> None: ...

    @abstractmethod
    def _show_count(self, task: str, done: int, total: int, last: str) -> None: ...


class Bar(Display):
    """A progress bar that disappears at the end."""

    def __init__(self, console: Console) -> None:
        super().__init__()
        text = Column(no_wrap=True)
        columns = (
            TextColumn("{task.description}", table_column=text),
            BarColumn(None, table_column=Column(min_width=8, max_width=30, ratio=1)),
            TextColumn("{task.fields[status]}", table_column=text),
        )
        self._progress = Progress(
            *columns, console=console, transient=True, expand=True, refresh_per_second=5
        )
        self._task = self._progress.add_task("", total=None, status="")

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        super().__exit__(kind, error, trace)
        self._progress.stop()

    def _show_task(self, task: str) -> None:
        self._progress.update(self._task, description=task, total=None, status="")

    def _show_delay(self, task: str) -> None:
        self._progress.update(self._task, status=_hint(task))

    def _show_progress(self, run: Run, factor: float) -> None:
        shares = run.loop.account.shares()
        if self._progress.console.width < _WIDE:
            most = max(shares, key=lambda name: shares[name])
            shares = {most: shares[most]}
        status = (
            f"{run.now_s:.1f} of {self._end_s:g} s, {factor:.1f} x real time "
            f"[dim]({shares_text(shares)})[/dim]"
        )
        name = visible(run.experiment.name)
        self._progress.update(
            self._task, description=name, total=self._end_s, completed=run.now_s, status=status
        )

    def _show_count(self, task: str, done: int, total: int, last: str) -> None:
        status = f"{done} of {total} [dim]{last}[/dim]"
        self._progress.update(self._task, description=task, total=total, completed=done, status=status)


class Lines(Display):
    """One line of text from time to time."""

    interval_s = 10.0

    def _show_task(self, task: str) -> None: ...

    def _show_delay(self, task: str) -> None:
        self._write(f"{task}; {_hint(task)}")

    def _show_progress(self, run: Run, factor: float) -> None:
        shares = shares_text(run.loop.account.shares())
        self._write(f"{run.now_s:.1f} of {self._end_s:g} s, {factor:.1f} x real time ({shares})")

    def _show_count(self, task: str, done: int, total: int, last: str) -> None:
        if monotonic() >= self._next_s or done == total:
            self._next_s = monotonic() + self.interval_s
            self._write(f"{task}: {done} of {total}" + (f" ({last})" if last else ""))

    def _write(self, line: str) -> None:
        sys.stderr.write(f"{line}\n")
        sys.stderr.flush()
