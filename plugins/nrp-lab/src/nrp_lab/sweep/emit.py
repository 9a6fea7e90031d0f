"""Write a sweep as files for the tools of a computing centre; ``nrp sweep`` then collects the results."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from nrp_core._support.writing import writing
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_lab.sweep.chunk import write_chunks
from nrp_lab.sweep.executors.slurm import script_of
from nrp_lab.sweep.record import Task

KINDS = ("slurm", "snakemake")
_SNAKEFILE = """# A journal is no output: Snakemake deletes those of a job that failed, with all runs in it.
rule all:
    input: expand("jobs/{{job}}.done", job=range({first}, {last} + 1))

rule runs:
    input: "jobs/{{job}}.jsonl"
    output: touch("jobs/{{job}}.done")
    shell: "{python} -m nrp_lab.sweep.chunk {{input}} journal.{{wildcards.job}}.jsonl"
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
