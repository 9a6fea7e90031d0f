"""Read the file of a sweep, and report errors with their lines."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.tree import Tree
from nrp_core.experiment.reading.forms import form_of, read_form
from nrp_core.sweep.model import ManyRuns, SweepFile

M = TypeVar("M", bound=ManyRuns)


def read_sweep(path: Path) -> tuple[SweepFile, Tree]:
    """Read a file of a sweep; see :func:`read_many_runs`."""
    return read_many_runs(path, SweepFile, "a sweep")


def sweep_of(tree: Tree) -> SweepFile:
    """Return the sweep of a tree; see :func:`~nrp_core.experiment.reading.forms.form_of`."""
    return form_of(tree, SweepFile, "a sweep")


def read_many_runs(path: Path, form: type[M], what: str) -> tuple[M, Tree]:
    """Read a file of many runs; see :func:`~nrp_core.experiment.reading.forms.read_form`.

    Raises:
        ExperimentError: it is not there.
        InvalidExperimentError: it cannot be read or is not valid; the error carries all findings.
    """
    if not path.is_file():
        raise ExperimentError(f"there is no such file; {what} is a YAML file", path=path)
    return read_form(path, form, what)
