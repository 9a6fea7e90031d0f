"""Read the file of a sweep, and report errors with their lines."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.tree import Tree
from nrp_core.experiment.reading.forms import form_of, read_form, read_form_tree
from nrp_core.findings import Code, InvalidExperimentError
from nrp_lab.sweep.model import ManyRuns, SweepFile

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
        ExperimentError: it does not exist, or is a folder.
        InvalidExperimentError: it cannot be read or is not valid; the error carries all findings.
    """
    if not path.is_file():
        wrong = "it is a folder" if path.is_dir() else "there is no such file"
        raise ExperimentError(f"{wrong}; {what} is a YAML file", path=path)
    _require_fitting(path, form, what)
    return read_form(path, form, what)


def _require_fitting(path: Path, form: type[ManyRuns], what: str) -> None:
    """Refuse the file of another command, before all the keys that it lacks are listed.

    Raises:
        InvalidExperimentError: it is one.
    """
    tree = read_form_tree(path, what)
    keys, of_search = set(tree.value), {"objective", "population", "generations"}
    if not keys & {"experiment", "vary"} and keys & {"brain", "world", "extends"}:
        message = f"this file is an experiment; {what} names one under 'experiment'"
    elif keys & of_search and not of_search & form.model_fields.keys():
        message = "this file has an objective: use nrp evolve"
    elif not keys & of_search and of_search <= form.model_fields.keys():
        message = "this file has no objective: use nrp sweep"
    else:
        return
    raise InvalidExperimentError([tree.place.finding(Code.NRP201, message)])
