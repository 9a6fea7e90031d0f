"""Perform the runs of a file in this process, as a job of a cluster.

::

    python -m nrp_lab.sweep.chunk DIR/jobs/0.jsonl DIR/journal.0.jsonl

A job that was killed resumes where it stopped.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from nrp_core._support.writing import writing
from nrp_core.errors import NrpError
from nrp_lab.sweep.journal import Journal, records_in
from nrp_lab.sweep.measuring import perform
from nrp_lab.sweep.record import Task

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


if __name__ == "__main__":
    try:
        perform_all(Path(sys.argv[1]), Path(sys.argv[2]))
    except NrpError as failure:
        sys.exit(f"{ERROR}{failure}")
