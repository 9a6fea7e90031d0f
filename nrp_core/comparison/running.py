"""Run a grid, several runs at once, each in a process that others follow; what is there already is kept."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import active_children, get_context, parent_process
from pathlib import Path
from threading import Thread

from nrp_core.comparison.grid import Cell, Grid
from nrp_core.comparison.signals import RunSignals
from nrp_core.errors import ExperimentError, RecordingError, SimulationError
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.capsule import Capsule
from nrp_core.recording.layout import RUN_NAME, Pictures
from nrp_core.recording.reading.recording import Recording

Progress = Callable[[int, int, str], None]
"""Told how many runs are done, of how many, and which was the last."""

WHOLE = ("finished", "failed")
"""States of a recording that running again would not change."""


def run_grid(grid: Grid, results: Path, workers: int, tell: Progress) -> dict[Cell, RunSignals]:
    """Run what is not recorded yet.

    Args:
        grid: what runs.
        results: a folder for the recordings; those that are in it are not made again.
        workers: processes at once.
        tell: told after every run.

    Returns:
        every run.

    Raises:
        NrpError: an experiment cannot be opened so. What else ends a run is part of its result.
    """
    folders = {cell: grid.folder(results, cell) for cell in grid.cells}
    missing = [cell for cell, folder in folders.items() if not _is_whole(folder)]
    done = len(folders) - len(missing)
    tell(done, len(folders), "")
    for cell in _run_all(grid, {cell: folders[cell] for cell in missing}, workers):
        done += 1
        tell(done, len(folders), str(cell))
    return {cell: RunSignals(Recording(folder)) for cell, folder in folders.items()}


def record(grid: Grid, cell: Cell, folder: Path) -> None:
    """Run one cell into a folder, with hashes for pictures; half of one that was killed is removed before.

    Raises:
        NrpError: it cannot be opened, or not be written.
    """
    shutil.rmtree(folder, ignore_errors=True)
    with Run(grid.load(cell)) as run:
        capsule = Capsule(run, folder, pictures=Pictures.HASH, snapshots_ns=None)
        state = "interrupted"
        try:
            run.run()
            state = "finished"
        except RecordingError:  # which is not the experiment's fault: with room on the disk it may go well
            raise
        except SimulationError:
            state = "failed"
        finally:
            capsule.close(state)


def _run_all(grid: Grid, folders: dict[Cell, Path], workers: int) -> Iterator[Cell]:
    """Run cells and return each when it is done."""
    workers = min(workers, len(folders))
    if workers < 2:
        for cell, folder in folders.items():
            record(grid, cell, folder)
            yield cell
        return
    # engines keep threads and libraries of their own, which a forked process would get half of
    pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_follow_parent)
    try:
        futures = {pool.submit(record, grid, cell, folder): cell for cell, folder in folders.items()}
        for future in as_completed(futures):
            _require_done(future, futures[future])
            yield futures[future]
    except BaseException:
        for worker in active_children():  # what they have begun would be made again anyway
            worker.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _follow_parent() -> None:
    """Leave Ctrl-C, which a terminal sends to all, to the process that waits for this one; end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    assert parent is not None

    def end() -> None:
        parent.join()
        os._exit(1)

    Thread(target=end, daemon=True).start()


def _require_done(future: Future[None], cell: Cell) -> None:
    try:
        future.result()
    except BrokenProcessPool as error:
        message = f"a process was killed, or an engine crashed in it, at {cell} or a run beside it"
        raise SimulationError(f"{message}; the finished runs are kept", t_ns=0) from error


def _is_whole(folder: Path) -> bool:
    """Whether a run was recorded to its end."""
    if not (folder / RUN_NAME).is_file():
        return False
    try:
        return Recording(folder).run.get("state") in WHOLE
    except ExperimentError:  # damaged: it is made again
        return False
