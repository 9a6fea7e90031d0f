"""Run a grid in several processes at once; finished runs are kept."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

from nrp_core._support.worker_pool import WorkerDiedError, WorkerPool
from nrp_core.errors import ExperimentError, RecordingError, SimulationError
from nrp_core.experiment.making.prepare import Plan
from nrp_core.experiment.running.run import Run
from nrp_core.recording.folder.recording_folder import RecordingFolder
from nrp_core.recording.layout import RUN_NAME, Images
from nrp_core.recording.reading.recording import Recording
from nrp_lab.comparison.grid import GridCell, RunGrid
from nrp_lab.comparison.signals import RunSignals

Progress = Callable[[int, int, str], None]
"""Called with the number of finished runs, the number of all runs, and the last finished run."""

WHOLE = ("finished", "failed")
"""Final states of a recording, which is then not repeated."""


def run_grid(grid: RunGrid, results: Path, workers: int, tell: Progress) -> dict[GridCell, RunSignals]:
    """Make the runs that are not recorded yet.

    Args:
        grid: the grid.
        results: a folder for the recordings; recordings that are in it are kept.
        workers: number of processes.
        tell: called after every run.

    Returns:
        Every run.

    Raises:
        NrpError: an experiment cannot be opened. Anything else that ends a run is part of its result.
    """
    folders = {cell: grid.folder(results, cell) for cell in grid.cells}
    missing = [cell for cell, folder in folders.items() if not is_whole(folder)]
    done = len(folders) - len(missing)
    tell(done, len(folders), "")
    for cell in _run_all(grid, {cell: folders[cell] for cell in missing}, workers):
        done += 1
        tell(done, len(folders), str(cell))
    return {cell: RunSignals(Recording(folder)) for cell, folder in folders.items()}


def record(
    grid: RunGrid, cell: GridCell, folder: Path, *,
    images: Images = Images.HASH, revise: Callable[[Plan], Plan] | None = None,
) -> None:  # fmt: skip
    """Record one run into a folder; an incomplete recording is removed first.

    Args:
        grid: the grid.
        cell: one of its runs.
        folder: the folder.
        images: how images are kept, by default as hashes.
        revise: may exchange a side of the run for a recorded one.

    Raises:
        NrpError: the experiment cannot be opened, or the recording cannot be written.
    """
    shutil.rmtree(folder, ignore_errors=True)
    with Run(grid.load(cell), revise=revise) as run:
        recording_folder = RecordingFolder(run, folder, images=images, snapshots_ns=None)
        state = "interrupted"
        try:
            run.run()
            state = "finished"
        except (
            RecordingError
        ):  # a full disk is not the experiment's fault: with room on the disk the run may succeed
            raise
        except SimulationError:
            state = "failed"
        finally:
            recording_folder.close(state)


def _run_all(grid: RunGrid, folders: dict[GridCell, Path], workers: int) -> Iterator[GridCell]:
    """Run cells and yield each when it is done."""
    workers = min(workers, len(folders))
    if workers < 2:
        for cell, folder in folders.items():
            record(grid, cell, folder)
            yield cell
        return
    with WorkerPool(workers) as pool:
        for outcome in pool.perform(_record, ((grid, cell, folder) for cell, folder in folders.items())):
            _, cell, _ = outcome.task
            if isinstance(outcome.error, WorkerDiedError):
                message = f"a process was killed, or an engine crashed in it, at {cell} ({outcome.error})"
                raise SimulationError(f"{message}; the finished runs are kept", t_ns=0) from outcome.error
            if outcome.error is not None:
                raise outcome.error
            yield cell


def _record(task: tuple[RunGrid, GridCell, Path]) -> None:
    record(*task)


def is_whole(folder: Path) -> bool:
    """Whether a run was recorded to its end, and its recording is undamaged."""
    if not (folder / RUN_NAME).is_file():
        return False
    try:
        recording = Recording(folder)
        return recording.run.get("state") in WHOLE and not recording.check().flaws
    except ExperimentError:  # damaged: the run is repeated
        return False
