"""Runs as jobs of SLURM: an array of jobs, each of which performs some of them in sequence."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import sleep

from nrp_core._support.writing import writing
from nrp_core.errors import BackendLoadError
from nrp_lab.sweep.chunk import ERROR, JOBS, last_begun, write_chunks
from nrp_lab.sweep.executors.deaths import Deaths
from nrp_lab.sweep.executors.interface import Executor
from nrp_lab.sweep.journal import records_in
from nrp_lab.sweep.record import Record, Task

SCRIPT = """#!/bin/sh
#SBATCH --job-name=nrp-sweep
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --array={first}-{last}{limit}
#SBATCH --output={folder}/jobs/%a.log
exec {python} -m nrp_lab.sweep.chunk {folder}/jobs/$SLURM_ARRAY_TASK_ID.jsonl \\
    {folder}/journal.$SLURM_ARRAY_TASK_ID.jsonl
"""
_CHUNKS = 4
"""Jobs per worker, so that workers that finish early get more work."""
_WORKERS = 16
_ARRAYS = 5
"""Number of arrays of jobs in a row that may end before a run begins."""
_LOOK_S = 0.5


class SlurmExecutor(Executor):
    """Submits arrays of jobs and reads their journals; options of a site come from ``SBATCH_*`` variables."""

    def __enter__(self) -> SlurmExecutor:
        if shutil.which("sbatch") is None:
            raise BackendLoadError("sbatch was not found: the executor 'slurm' needs SLURM's commands")
        _command("squeue", "--noheader", "--me")
        return self

    @property
    def size(self) -> int:
        return self.workers or _WORKERS

    def perform(self, tasks: Sequence[Task]) -> Iterator[Record]:
        waiting, deaths = {task.id: task for task in tasks}, Deaths(_ARRAYS)
        cause = f"see {self.folder / JOBS}/*.log"
        while waiting:
            chunks = write_chunks(self.folder, list(waiting.values()), self.size * _CHUNKS)
            for record in self._array(chunks):
                if waiting.pop(record.id, None) is not None:
                    yield record
            begun = {last_begun(file) for file, _ in chunks} - {None}
            if waiting and not begun:
                deaths.in_vain(cause)
            for task in [task for task in waiting.values() if task.id in begun]:  # its job was killed in it
                following = deaths.in_run(task, cause)
                if isinstance(following, Record):
                    del waiting[task.id]
                    yield following
                else:
                    waiting[task.id] = following

    def _array(self, chunks: Sequence[tuple[Path, Path]]) -> Iterator[Record]:
        """Submit jobs, and yield their records until all of them have ended."""
        first = int(chunks[0][0].stem)
        script = script_of(self.folder, first, len(chunks), self.size)
        job = _command("sbatch", "--parsable", str(script)).strip().partition(";")[0]
        seen: dict[Path, int] = {journal: 0 for _, journal in chunks}
        try:
            while True:
                ended = not _command("squeue", "--noheader", "--jobs", job, may_fail=True).strip()
                for journal, count in seen.items():
                    records = records_in(journal) if journal.exists() else []
                    yield from records[count:]
                    seen[journal] = len(records)
                if ended:
                    break
                sleep(_LOOK_S)
        except BaseException:
            _command("scancel", job, may_fail=True)
            raise
        _require_no_error([file for file, _ in chunks])


def _require_no_error(jobs: Sequence[Path]) -> None:
    """Refuse to go on if jobs ended with an error of their own, which another attempt would not mend.

    Raises:
        BackendLoadError: a job has another version of the code, or cannot write its journal.
    """
    for job in jobs:
        log = job.with_suffix(".log")
        *_, last = (log.read_text("utf-8", "replace") if log.exists() else "").splitlines() or [""]
        if last.startswith(ERROR):
            raise BackendLoadError(
                f"a job of SLURM ended: {last.removeprefix(ERROR)} (see {log}); finished runs are kept"
            )


def script_of(folder: Path, first: int, jobs: int, at_once: int) -> Path:
    """Write the script of an array of jobs into the folder of a sweep, and return it."""
    path = folder / JOBS / f"{first}.sh"
    limit = f"%{at_once}" if at_once < jobs else ""
    text = SCRIPT.format(
        first=first, last=first + jobs - 1, limit=limit, folder=folder.resolve(), python=sys.executable
    )
    with writing(path):
        path.write_text(text, "utf-8")
    return path


def _command(*command: str, may_fail: bool = False) -> str:
    """Return the output of a command of SLURM.

    Raises:
        BackendLoadError: the command fails; the error quotes its message.
    """
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode and not may_fail:
        raise BackendLoadError(f"{command[0]} of SLURM failed: {done.stderr.strip() or done.stdout.strip()}")
    return done.stdout if not done.returncode else ""
