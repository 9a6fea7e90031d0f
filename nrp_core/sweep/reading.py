"""Read the file of a sweep, and report errors with their lines."""

from __future__ import annotations

from pathlib import Path

from pydantic import ValidationError

from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.schema_findings import schema_findings
from nrp_core.experiment.model.tree import Tree
from nrp_core.experiment.reading.yaml_tree import read_tree
from nrp_core.findings import Code, Finding, InvalidExperimentError
from nrp_core.sweep.model import SweepFile


def read_sweep(path: Path) -> tuple[SweepFile, Tree]:
    """Read a file of a sweep.

    Returns:
        the sweep, and the file with the place of every value.

    Raises:
        InvalidExperimentError: it cannot be read or is not valid; the error carries all findings.
    """
    if not path.is_file():
        raise ExperimentError("there is no such file; a sweep is a YAML file", path=path)
    try:
        tree = read_tree(path.resolve())
    except ExperimentError as error:
        raise InvalidExperimentError([Finding.of(error, Code.NRP200)]) from error
    return sweep_of(tree), tree


def sweep_of(tree: Tree) -> SweepFile:
    """Return the sweep of a tree.

    Raises:
        InvalidExperimentError: it is not valid; the error carries all findings.
    """
    try:
        return SweepFile.model_validate(tree.plain())
    except ValidationError as error:
        raise InvalidExperimentError(schema_findings(error, SweepFile, tree, what="a sweep")) from None
