"""Experiments by the names of their folders, and the files that their runs have written."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path

from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import READERS, find_file, shipped

FOLDERS = "NRP_EXPERIMENTS"
"""The environment variable with the folders of experiments."""
_RUN = "run_"


@dataclass(frozen=True, slots=True)
class Stored:
    """An experiment.

    Args:
        name: the name of its folder, or of the shipped experiment.
        file: its document.
        records: the folder for the files of its runs.
        is_own: whether it is the user's, and may be changed.
    """

    name: str
    file: Path
    records: Path
    is_own: bool

    def runs(self) -> list[Path]:
        """Return the folders of its runs, the oldest first."""
        found = self.records.glob(f"{_RUN}*")
        return sorted(found, key=lambda run: int(run.name.removeprefix(_RUN)))

    def new_run(self) -> Path:
        """Return a new folder for the files of a run."""
        for number in count(len(self.runs())):
            folder = self.records / f"{_RUN}{number}"
            try:
                folder.mkdir(parents=True)
            except FileExistsError:  # another simulation began at the same time
                continue
            break
        return folder

    def run(self, number: int) -> Path:
        """Return the folder of a run; -1 is the last.

        Raises:
            ExperimentError: the run does not exist.
        """
        runs = self.runs()
        if not runs:
            raise ExperimentError(f"'{self.name}' has no runs yet")
        if not -1 <= number < len(runs):
            raise ExperimentError(f"'{self.name}' does not have a run {number}; runs: 0 to {len(runs) - 1}")
        return runs[number]


class Storage:
    """The experiments in some folders, and those that are installed.

    Args:
        folders: each holds a folder for each experiment.
    """

    def __init__(self, folders: Sequence[Path]) -> None:
        self.folders = list(folders)

    def own(self) -> list[str]:
        """Return the names of the experiments in the folders."""
        return [path.name for folder in self.folders for path in _experiments(folder)]

    def find(self, name: str) -> Stored:
        """Return an experiment.

        Raises:
            ExperimentError: it does not exist.
        """
        for folder in self.folders:
            if folder / name in _experiments(folder):
                home = folder / name
                return Stored(name, find_file(str(home)), home / "csv", is_own=True)
        if name in shipped():
            return Stored(name, find_file(name), Path.cwd() / "csv" / name, is_own=False)
        places = ", ".join(map(str, self.folders)) or f"no folder: set {FOLDERS}"
        hint = did_you_mean(name, [*self.own(), *shipped()])
        raise ExperimentError(f"there is no experiment '{name}' (searched: {places}){hint}")

    def find_own(self, name: str) -> Stored:
        """Return an experiment that may be changed.

        Raises:
            ExperimentError: it does not exist, or is an installed one.
        """
        found = self.find(name)
        if not found.is_own:
            raise ExperimentError(
                f"'{name}' is installed; clone it to change it: clone_experiment_to_storage"
            )
        return found

    def add(self, source: Path, name: str) -> str:
        """Copy the folder or archive of an experiment into the first folder; return its new name.

        Raises:
            ExperimentError: no folder is set for it, or it has no files to copy.
        """
        if not self.folders:
            raise ExperimentError(
                f"there is no folder for experiments: give one as environment, or set {FOLDERS}"
            )
        top = find_file(str(source)).parent
        new = next(f"{name}_{i}" for i in count() if not (self.folders[0] / f"{name}_{i}").exists())
        shutil.copytree(top, self.folders[0] / new, ignore=shutil.ignore_patterns("csv", "__pycache__"))
        return new


def folders_of(environment: str) -> list[Path]:
    """Return the folders of experiments that a script's environment and the variable name.

    Raises:
        ExperimentError: a folder does not exist.
    """
    named = [environment] if _is_path(environment) else []
    named += [folder for folder in os.environ.get(FOLDERS, "").split(os.pathsep) if folder]
    folders = [Path(folder).expanduser().absolute() for folder in named]
    for folder in folders:
        if not folder.is_dir():
            raise ExperimentError("there is no such folder of experiments", path=folder)
    return folders


def _is_path(environment: str) -> bool:
    return Path(environment).is_dir() or (os.sep in environment and "://" not in environment)


def _experiments(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.is_dir() and any(_documents(path)))


def _documents(folder: Path) -> Iterator[Path]:
    return (path for path in folder.iterdir() if path.suffix in READERS.names())
