"""Read a YAML or JSON file that has a form, and report errors with their lines."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.schema_findings import schema_findings
from nrp_core.experiment.model.tree import Tree
from nrp_core.experiment.reading.yaml_tree import read_tree
from nrp_core.findings import Code, Finding, InvalidExperimentError

F = TypeVar("F", bound=BaseModel)


def read_form(path: Path, form: type[F], what: str) -> tuple[F, Tree]:
    """Read a file.

    Args:
        path: the file.
        form: its keys and the types of their values.
        what: the whole file, in messages.

    Returns:
        its contents, and the file with the place of every value.

    Raises:
        InvalidExperimentError: it cannot be read or is not valid; the error carries all findings.
    """
    tree = read_form_tree(path, what)
    return form_of(tree, form, what), tree


def read_form_tree(path: Path, what: str) -> Tree:
    """Read a file without checking its keys; see :func:`read_form`."""
    try:
        return read_tree(path.resolve(), what)
    except ExperimentError as error:
        raise InvalidExperimentError([Finding.of(error, Code.NRP200)]) from error


def form_of(tree: Tree, form: type[F], what: str) -> F:
    """Return the contents of a tree.

    Raises:
        InvalidExperimentError: it is not valid; the error carries all findings.
    """
    try:
        return form.model_validate(tree.plain())
    except ValidationError as error:
        raise InvalidExperimentError(schema_findings(error, form, tree, what=what)) from None
