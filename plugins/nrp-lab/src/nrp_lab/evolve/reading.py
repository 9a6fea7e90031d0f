"""Read the file of a search, and report errors with their lines."""

from __future__ import annotations

from pathlib import Path

from nrp_core.experiment.model.tree import Tree
from nrp_core.experiment.reading.forms import form_of
from nrp_lab.evolve.model import EvolveFile
from nrp_lab.sweep.reading import read_many_runs


def read_evolve(path: Path) -> tuple[EvolveFile, Tree]:
    """Read a file of a search.

    Returns:
        the search, and the file with the place of every value.

    Raises:
        InvalidExperimentError: it cannot be read or is not valid; the error carries all findings.
    """
    return read_many_runs(path, EvolveFile, "a search")


def evolve_of(tree: Tree) -> EvolveFile:
    """Return the search of a tree.

    Raises:
        InvalidExperimentError: it is not valid; the error carries all findings.
    """
    return form_of(tree, EvolveFile, "a search")
