"""An experiment as one file whose paths lead into its recording."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.model.tree import Tree
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.recording.layout import EXPERIMENT_NAME, FILES_FOLDER
from nrp_core.recording.reading.recording import Recording


def write_experiment(experiment: Experiment, folder: Path, files: Collection[Path], root: Path) -> None:
    """Write an experiment into its recording, merged with the files that it extends and its overrides.

    An experiment that was not read from YAML is left as its own file and its overrides.

    Args:
        experiment: the experiment.
        folder: the folder of the recording.
        files: the files that were copied into the recording.
        root: their common folder.
    """
    is_ours = experiment.maker is None or experiment.compatibility is not None
    if not is_ours or not experiment.source.value:
        return
    content = _moved(experiment.source, {file.resolve() for file in files}, root)
    with (folder / EXPERIMENT_NAME).open("w", encoding="utf-8") as file:
        YAML().dump(content, file)


def recorded_experiment(recording: Recording, overrides: Sequence[str] = ()) -> Experiment:
    """Return the experiment of a recording, from the files in it.

    Raises:
        ExperimentError: it is missing, or invalid.
    """
    own = recording.folder / EXPERIMENT_NAME
    if own.is_file():
        return load_experiment(own, overrides)
    written = recording.run.get("file")
    if not written:
        raise ExperimentError(f"cannot be run again: it has no {EXPERIMENT_NAME}", path=recording.folder)
    before = [str(one) for one in recording.run.get("overrides") or ()]
    return load_experiment(recording.folder / str(written), [*before, *overrides])


def _moved(tree: Tree, files: Collection[Path], root: Path) -> Any:
    """Return the data of a tree, with the names of copied files replaced by those of the copies."""
    if isinstance(tree.value, dict):
        return {key: _moved(child, files, root) for key, child in tree.value.items()}
    if isinstance(tree.value, list):
        return [_moved(child, files, root) for child in tree.value]
    if not isinstance(tree.value, str) or not tree.value or "\0" in tree.value:
        return tree.value
    path = (tree.place.folder / Path(tree.value).expanduser()).resolve()
    if path in files or (path != root and any(path in file.parents for file in files)):
        return str(Path(FILES_FOLDER) / path.relative_to(root))
    return str(tree.value)
