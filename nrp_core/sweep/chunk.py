"""Perform the runs of a file in this process, as a job of a cluster.

::

    python -m nrp_core.sweep.chunk DIR/jobs/0.jsonl DIR/journal.0.jsonl

A job that was killed resumes where it stopped.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path

from nrp_core._support.writing import writing
from nrp_core.errors import NrpError
from nrp_core.sweep.journal import Journal, records_in
from nrp_core.sweep.measuring import perform
from nrp_core.sweep.record import Task

JOBS, ERROR = "jobs", "error: "


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


def perform_all(tasks: Iterable[Task], journal: Path) -> None:
    """Perform the tasks of a chunk that are not yet in its journal."""
    done = {record.id for record in records_in(journal)} if journal.exists() else set()
    with Journal(journal) as written:
        for task in tasks:
            if task.id not in done:
                written.add(perform(task))


def _cut(tasks: Sequence[Task], chunks: int) -> list[Sequence[Task]]:
    """Return contiguous parts, so that runs that differ only in the seed stay together."""
    chunks = min(chunks, len(tasks))
    ends = [round(len(tasks) * n / chunks) for n in range(chunks + 1)] if chunks else [0]
    return [tasks[begin:end] for begin, end in pairwise(ends)]


if __name__ == "__main__":
    try:
        perform_all(read_tasks(Path(sys.argv[1])), Path(sys.argv[2]))
    except NrpError as failure:
        sys.exit(f"{ERROR}{failure}")
