"""Read files of many runs, and report errors with their lines."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from pydantic import ValidationError

from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.schema_findings import schema_findings
from nrp_core.experiment.model.tree import Tree
from nrp_core.experiment.reading.yaml_tree import read_tree
from nrp_core.findings import Code, Finding, InvalidExperimentError
from nrp_core.sweep.model import ManyRuns, SweepFile

M = TypeVar("M", bound=ManyRuns)


def read_sweep(path: Path) -> tuple[SweepFile, Tree]:
    """Read a file of a sweep; see :func:`read_file`."""
    return read_file(path, SweepFile, "a sweep")


def sweep_of(tree: Tree) -> SweepFile:
    """Return the sweep of a tree; see :func:`file_of`."""
    return file_of(tree, SweepFile, "a sweep")


def read_file(path: Path, model: type[M], what: str) -> tuple[M, Tree]:
    """Read a file of many runs.

    Args:
        path: the file.
        model: its form.
        what: the whole file, in messages.

    Returns:
        its contents, and the file with the place of every value.

    Raises:
        InvalidExperimentError: it cannot be read or is not valid; the error carries all findings.
    """
    if not path.is_file():
        raise ExperimentError(f"there is no such file; {what} is a YAML file", path=path)
    try:
        tree = read_tree(path.resolve())
    except ExperimentError as error:
        raise InvalidExperimentError([Finding.of(error, Code.NRP200)]) from error
    return file_of(tree, model, what), tree


def file_of(tree: Tree, model: type[M], what: str) -> M:
    """Return the contents of a tree.

    Raises:
        InvalidExperimentError: it is not valid; the error carries all findings.
    """
    try:
        return model.model_validate(tree.plain())
    except ValidationError as error:
        raise InvalidExperimentError(schema_findings(error, model, tree, what=what)) from None
