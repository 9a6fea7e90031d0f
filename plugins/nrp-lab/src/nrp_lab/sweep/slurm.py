"""Runs as jobs of a computing centre: arrays of SLURM jobs, or rules of Snakemake.

Each job performs the tasks of one file in sequence; a job that was killed resumes where it stopped::

    python -m nrp_lab.sweep.slurm DIR/jobs/0.jsonl DIR/journal.0.jsonl
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from time import sleep

from nrp_core.errors import BackendLoadError, ExperimentError, NrpError, did_you_mean
from nrp_core.utilities import writing
from nrp_lab.sweep.executor import Deaths, Executor
from nrp_lab.sweep.measuring import perform
from nrp_lab.sweep.record import Journal, Record, Task, records_in

JOBS, ERROR, BEGUN = "jobs", "error: ", ".begun"


def write_chunks(folder: Path, tasks: Sequence[Task], chunks: int) -> list[tuple[Path, Path]]:
    """Write tasks into files of about equal length.

    Returns:
        the file of tasks of each chunk, and the journal that the chunk will write.
    """
    jobs = folder / JOBS
    with writing(jobs):
        jobs.mkdir(exist_ok=True)
    first = len(list(jobs.glob("*.jsonl")))
    found = []
    for number, chunk in enumerate(_cut(tasks, chunks), first):
        file = jobs / f"{number}.jsonl"
        with writing(file):
            file.write_text("".join(task.to_line() for task in chunk), "utf-8")
        found.append((file, folder / f"journal.{number}.jsonl"))
    return found


def read_tasks(path: Path) -> list[Task]:
    """Return the tasks of a file."""
    return list(map(Task.from_line, path.read_text("utf-8").splitlines()))


def perform_all(file: Path, journal: Path) -> None:
    """Perform the tasks of a chunk that are not yet in its journal, and keep the id of the last begun."""
    done = {record.id for record in records_in(journal)} if journal.exists() else set()
    begun = file.with_suffix(BEGUN)
    with Journal(journal) as written:
        for task in read_tasks(file):
            if task.id not in done:
                with writing(begun):
                    begun.write_text(task.id, "utf-8")
                written.add(perform(task))


def last_begun(file: Path) -> str | None:
    """Return the id of the run of a chunk that was begun last; None: none was."""
    begun = file.with_suffix(BEGUN)
    return begun.read_text("utf-8") if begun.exists() else None


def _cut(tasks: Sequence[Task], chunks: int) -> list[Sequence[Task]]:
    """Return contiguous parts, so that runs that differ only in the seed stay together."""
    chunks = min(chunks, len(tasks))
    ends = [round(len(tasks) * n / chunks) for n in range(chunks + 1)] if chunks else [0]
    return [tasks[begin:end] for begin, end in pairwise(ends)]


SCRIPT = """#!/bin/sh
#SBATCH --job-name=nrp-sweep
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --array={first}-{last}{limit}
#SBATCH --output={folder}/jobs/%a.log
exec {python} -P -m nrp_lab.sweep.slurm {folder}/jobs/$SLURM_ARRAY_TASK_ID.jsonl \\
    {folder}/journal.$SLURM_ARRAY_TASK_ID.jsonl
"""
_CHUNKS = 4
"""Jobs per worker, so that workers that finish early get more work."""
_WORKERS = 16
_ARRAYS = 5
"""Number of arrays of jobs in a row that may end before a run begins."""
_LOOK_S = 0.5


class SlurmExecutor(Executor):
    """Submits arrays of jobs and reads their journals; ``SBATCH_*`` variables set a site's options."""

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


KINDS = ("slurm", "snakemake")
_SNAKEFILE = """# A journal is no output: Snakemake deletes those of a job that failed, with all runs in it.
rule all:
    input: expand("jobs/{{job}}.done", job=range({first}, {last} + 1))

rule runs:
    input: "jobs/{{job}}.jsonl"
    output: touch("jobs/{{job}}.done")
    shell: "{python} -P -m nrp_lab.sweep.slurm {{input}} journal.{{wildcards.job}}.jsonl"
"""


def emit(kind: str, folder: Path, tasks: Sequence[Task], jobs: int) -> tuple[Path, str]:
    """Write the runs as jobs.

    Args:
        kind: one of :data:`KINDS`.
        folder: the folder of the sweep.
        tasks: the runs.
        jobs: number of jobs.

    Returns:
        the file to run, and the command that runs it.

    Raises:
        ExperimentError: the kind is unknown, all runs are done, or the files cannot be written.
    """
    if kind not in KINDS:
        raise ExperimentError(f"a sweep cannot be written for '{kind}'{did_you_mean(kind, KINDS)}")
    if not tasks:
        raise ExperimentError("all runs are done: there is nothing to write", path=folder)
    chunks = write_chunks(folder, tasks, jobs)
    first = int(chunks[0][0].stem)
    if kind == "slurm":
        script = script_of(folder, first, len(chunks), len(chunks))
        return script, f"sbatch {script}"
    path = folder / "Snakefile"
    with writing(path):
        path.write_text(_SNAKEFILE.format(first=first, last=first + len(chunks) - 1, python=sys.executable))
    return path, f"snakemake --cores all --snakefile {path} --directory {folder}"


if __name__ == "__main__":
    try:
        perform_all(Path(sys.argv[1]), Path(sys.argv[2]))
    except NrpError as failure:
        sys.exit(f"{ERROR}{failure}")
