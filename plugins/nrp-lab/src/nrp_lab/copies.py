"""Runs side by side: many whole runs in one process, each to its own end, with the results of each alone.

Sweeps, searches and comparisons give their runs as attempts; :func:`perform_side_by_side` decides by the
run itself whether it steps together with others or alone.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, closing
from dataclasses import dataclass
from math import ceil
from typing import Final, Generic, TypeAlias, TypeVar

from nrp_core.clock import from_seconds
from nrp_core.errors import NrpError
from nrp_core.experiment import Experiment, Participant, Run, prepare
from nrp_core.utilities import work
from nrp_lab.side_by_side import SideBySide

R = TypeVar("R")
T = TypeVar("T")
_logger = logging.getLogger(__name__)

COPIES: Final = 32
"""The largest number of runs that are open at once; more gain nothing."""
CELLS: Final = 50_000
"""The number of cells in all open runs from which on no other one is opened, for the sake of memory."""
_LARGEST_SHARE: Final = 2 * COPIES
"""The maximum number of tasks of a process at once; their results are stored when all have finished."""


@dataclass(frozen=True, slots=True)
class Opened:
    """A run that is to be taken to its end.

    Args:
        run: the run, at time 0.
        until_s: its end, s; None: that of the experiment.
        context: is active while it steps; may be entered again.
    """

    run: Run
    until_s: float | None
    context: AbstractContextManager[object]

    @property
    def until_ns(self) -> int:
        """Its end, ns."""
        return self.run.experiment.duration if self.until_s is None else from_seconds(self.until_s)

    @property
    def steps(self) -> int:
        """The number of steps to its end; 0 if that is not a whole number."""
        steps, rest = divmod(self.until_ns - self.run.loop.now_ns, self.run.experiment.timestep)
        return 0 if rest else steps


Attempt: TypeAlias = Generator[Opened, None, R]
"""Opens a run and yields it; continues when it has ended, or with the error that ended it."""


def python_calls(run: Run) -> list[str]:
    """Return the names of the functions that Python calls for each run: those that are not vectorised."""
    return [one.name for one in run.loop.functions if not one.vectorized]


def calls_text(names: list[str]) -> str:
    """Return in a line how many functions are called for each copy."""
    return f"Python functions: {len(names)} calls per copy ({', '.join(names)})"


def why_alone(run: Run) -> str:
    """Return in a line why a run does not step together with others; empty if it does."""
    if names := python_calls(run):
        return calls_text(names)
    if isinstance(run.experiment.maker, Participant):
        return "state machines: one run at a time"
    if not run.brain.advances_together:
        return f"the brain '{run.experiment.brain.backend}' advances alone"
    if not run.world.capabilities.snapshot:
        return f"the world '{run.experiment.world.backend}' steps alone"
    return ""


def may_step_together(load: Callable[[], Experiment]) -> bool:
    """Return whether the run of an experiment steps together with others; False if it cannot be opened."""
    try:
        experiment = load()
        if not all(function.vectorized for function in prepare(experiment).functions):
            return False  # most experiments; without engines
        with Run(experiment) as run:
            return not why_alone(run)
    except NrpError:
        return False


def shares(tasks: Sequence[T], processes: int) -> Iterator[tuple[T, ...]]:
    """Divide tasks that step together among processes."""
    rounds = ceil(len(tasks) / (processes * _LARGEST_SHARE))
    size = ceil(len(tasks) / (processes * rounds)) if tasks else 1
    return (tuple(tasks[first : first + size]) for first in range(0, len(tasks), size))


class Queue(deque[T]):
    """An iterator over its items, to which others may be added even after it was exhausted."""

    def __iter__(self) -> Iterator[T]:
        return self

    def __next__(self) -> T:
        if not self:
            raise StopIteration
        return self.popleft()


def perform_alone(attempt: Attempt[R]) -> R:
    """Take one run to its end, and return the result of its attempt."""
    return next(perform_side_by_side(iter((attempt,)), is_alone=True))


def log_reason(reason: str) -> None:
    """Log why runs do not step together, each reason once."""
    if reason and reason not in _LOGGED:
        _LOGGED.add(reason)
        _logger.info("one run after another: %s", reason)


_LOGGED: set[str] = set()


def perform_side_by_side(
    attempts: Iterator[Attempt[R]],
    on_reason: Callable[[str], None] = log_reason,
    *,
    is_alone: bool = False,
) -> Iterator[R]:
    """Take runs to their ends, together where that is possible; yield their results as they end.

    Args:
        attempts: are taken from the iterator when there is room for another run.
        on_reason: called with the reason why a run steps alone, or with an empty string, for each run.
        is_alone: whether each steps alone.
    """
    with closing(_Group[R]()) as group:
        has_more = True
        while has_more or group:
            while has_more and group.has_room:
                if (attempt := next(attempts, None)) is None:
                    has_more = False
                    break
                try:
                    opened = next(attempt)
                except StopIteration as done:
                    yield done.value
                    continue
                if not is_alone:
                    on_reason(reason := why_alone(opened.run))
                if is_alone or reason or opened.steps < 1:
                    yield _run(attempt, opened)
                else:
                    group.add(attempt, opened)
            yield from group.step_until_one_ends()


def _run(attempt: Attempt[R], opened: Opened) -> R:
    """Take one run to its end."""
    error: BaseException | None = None
    with opened.context:
        try:
            opened.run.run(opened.until_s)
        except BaseException as raised:  # noqa: BLE001 - the attempt decides
            error = raised
    return _finish(attempt, error)


def _finish(attempt: Attempt[R], error: BaseException | None) -> R:
    """Continue an attempt whose run has ended, and return its result."""
    try:
        if error is None:
            next(attempt)
        else:
            attempt.throw(error)
    except StopIteration as done:
        return done.value  # type: ignore[no-any-return]
    raise AssertionError("an attempt has more than one run")


class _Group(Generic[R]):
    """Runs that step together."""

    def __init__(self) -> None:
        self._open: dict[Run, tuple[Attempt[R], Opened]] = {}
        self._together, self._ended = SideBySide(), 0

    def __len__(self) -> int:
        return len(self._open)

    @property
    def has_room(self) -> bool:
        """Whether another run may be opened."""
        return len(self) < COPIES and sum(run.brain.network.size for run in self._open) < CELLS

    def add(self, attempt: Attempt[R], opened: Opened) -> None:
        self._open[opened.run] = attempt, opened

    def step_until_one_ends(self) -> Iterator[R]:
        """Step all runs until at least one of them has ended, and yield the results of these."""
        ended: dict[Run, Exception | None] = {}
        with ExitStack() as active:
            for _, opened in self._open.values():
                active.enter_context(opened.context)
            while self._open and not ended:
                ended = self._step()
        for run, error in ended.items():
            attempt, _ = self._open.pop(run)
            yield _finish(attempt, error)
        self._ended += len(ended)
        if self._ended >= COPIES:  # it holds on to the runs that it has stepped
            self._together.close()
            self._together, self._ended = SideBySide(), 0

    def _step(self) -> dict[Run, Exception | None]:
        runs, began = list(self._open), work.now_ns()
        failed = self._together.step([run.loop for run in runs])
        share_ns = (work.now_ns() - began) // len(runs)
        ended: dict[Run, Exception | None] = {}
        for number, run in enumerate(runs):
            error = failed.get(number)
            run.note_step(share_ns, error)
            if error is not None or run.loop.is_stopping or run.loop.now_ns >= self._open[run][1].until_ns:
                ended[run] = error
        return ended

    def close(self) -> None:
        """Abandon the runs that have not ended."""
        for attempt, _ in self._open.values():
            attempt.close()
        self._together.close()
