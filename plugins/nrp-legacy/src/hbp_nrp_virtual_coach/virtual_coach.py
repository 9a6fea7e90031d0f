"""The Virtual Coach: it finds experiments and launches them, in this process."""

from __future__ import annotations

import atexit
import json
import os
import shutil
from functools import partial
from pathlib import Path
from typing import Any

from hbp_nrp_virtual_coach import records, settings
from hbp_nrp_virtual_coach.runner import STOPPED
from hbp_nrp_virtual_coach.settings import log, say_once
from hbp_nrp_virtual_coach.simulation import Simulation
from hbp_nrp_virtual_coach.storage import Storage, folders_of
from nrp_core.archives import unpack
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import load_experiment, shipped

_TYPES = ("csv", "profiler")
_HERE, _BUSY = "localhost", "No available servers."
_LOCAL = (None, "local", "http://localhost:9000")
"""Environments that are this machine."""
_SHELVES = ("robots", "brains", "environments")


class VirtualCoach:
    """Launches experiments. Errors are ``NrpError``.

    Args:
        environment: a folder with a folder for each experiment. Names and addresses of servers are accepted;
            experiments are then in the folders of the variable ``NRP_EXPERIMENTS``.
        oidc_username, oidc_password, storage_username, storage_password, oidc_token: accepted.

    Raises:
        ExperimentError: a folder does not exist.
    """

    def __init__(
        self,
        environment: str | Path | None = "http://localhost:9000",
        oidc_username: str | None = None,
        oidc_password: str | None = None,
        storage_username: str | None = None,
        storage_password: str | None = None,
        *,
        oidc_token: str | None = None,
    ) -> None:
        self._storage = Storage(folders_of(str(environment)))
        if environment not in _LOCAL and not Path(str(environment)).is_dir():
            say_once(f"environment '{environment}' is not a folder: experiments run in this process")
        if any((oidc_username, oidc_password, oidc_token, storage_username, storage_password)):
            say_once("accounts are not needed: experiments run in this process")
        self._simulations: list[tuple[str, Simulation]] = []
        atexit.register(self._leave)

    # -- experiments

    def launch_experiment(
        self,
        experiment_id: str,
        server: str | None = None,
        reservation: str | None = None,
        cloned: bool = True,
        brain_processes: int = 1,
        profiler: str = "disabled",
        recordingPath: str | None = None,  # noqa: N803 - the name in scripts
    ) -> Simulation:
        """Open an experiment and return its simulation, which is paused.

        Args:
            experiment_id: the name of its folder, or of an installed experiment.
            server: accepted.
            reservation: accepted.
            cloned: accepted: experiments in the folders precede installed ones.
            brain_processes: accepted.
            profiler: accepted.
            recordingPath: not supported.

        Raises:
            NrpError: it does not exist, or is invalid, or a recording is to be played.
        """
        if recordingPath is not None:
            raise ExperimentError(f"recordings of the platform are not played: {recordingPath}")
        if server or reservation:
            say_once("servers are not needed: experiments run in this process")
        if brain_processes != 1 or profiler != "disabled":
            say_once("brain_processes and profiler have no effect: a brain runs in this process")
        stored = self._storage.find(experiment_id)
        read = partial(load_experiment, stored.file, settings.overrides())
        simulation = Simulation(stored, read)
        self._simulations = [*self._running(), (experiment_id, simulation)]
        return simulation

    def print_templates(self, dev: bool = False) -> None:
        """Print the names of the installed experiments."""
        _print(shipped())

    def print_cloned_experiments(self) -> None:
        """Print the names of the experiments in the folders."""
        _print(self._storage.own())

    def print_running_experiments(self, cloned: bool = False) -> None:
        """Print the names of the experiments that were launched and are not stopped, with their states."""
        _print([f"{name}: {one.get_state()}" for name, one in self._running()])

    def print_available_servers(self) -> list[str]:
        """Print and return the servers on which no simulation runs: this machine, or a sentence."""
        servers = [_BUSY if self._running() else _HERE]
        _print(servers)
        return servers

    def clone_experiment_to_storage(self, exp_id: str) -> str:
        """Copy an experiment into the first folder and return its new name.

        Raises:
            ExperimentError: it does not exist, or no folder; or it is a variant of another one.
        """
        stored = self._storage.find(exp_id)
        base, _, variant = exp_id.partition("/")
        if variant:
            raise ExperimentError(f"'{exp_id}' is a variant of '{base}': clone that", subject=exp_id)
        return self._storage.add(stored.file.parent, exp_id)

    def clone_cloned_experiment(self, experiment_id: str) -> bytes:
        """Copy an experiment of a folder; return both names as JSON, ``clonedExp`` and ``originalExp``.

        Raises:
            ExperimentError: it does not exist, or is installed.
        """
        self._storage.find_own(experiment_id)
        clone = self.clone_experiment_to_storage(experiment_id)
        return json.dumps({"clonedExp": clone, "originalExp": experiment_id}).encode()

    def delete_cloned_experiment(self, exp_id: str) -> None:
        """Delete the folder of an experiment.

        Raises:
            ExperimentError: it does not exist, or it is installed.
        """
        shutil.rmtree(self._storage.find_own(exp_id).file.parent)

    def import_experiment(self, path: str | Path) -> str:
        """Copy the folder or ZIP archive of an experiment into the first folder and return its name.

        Raises:
            ExperimentError: it is not an experiment, or no folder is set.
        """
        return self._storage.add(Path(path), Path(path).stem)

    def set_experiment_file(self, exp_id: str, file_name: str, file_content: str | bytes) -> None:
        """Write a file of an experiment.

        Raises:
            ExperimentError: no such experiment of yours exists, or the file would lie outside of it.
        """
        folder = self._storage.find_own(exp_id).file.parent.resolve()
        path = (folder / file_name).resolve()
        if folder not in path.parents:
            raise ExperimentError(f"'{file_name}' lies outside of the experiment '{exp_id}'", path=path)
        path.write_bytes(file_content if isinstance(file_content, bytes) else file_content.encode())

    # -- models

    def print_available_models(self, model_type: str, user: str = "all") -> None:
        """Print the names of the models of a type.

        Args:
            model_type: ``robots``, ``brains`` or ``environments``.
            user: accepted.

        Raises:
            ExperimentError: another type, or no folder of models is known.
        """
        _print([path.name for path in sorted(_shelf(model_type).glob("*")) if path.is_dir()])

    def import_model(self, path: str, model_type: str) -> str:
        """Copy the folder or ZIP archive of a model into the folder of its type; return its name.

        Raises:
            ExperimentError: another type, a model of its name exists, or no folder of models is known.
        """
        source = Path(path)
        new = _shelf(model_type) / source.stem
        if new.exists():
            raise ExperimentError(f"the model '{new.name}' already exists", path=new)
        shutil.copytree(unpack(source) if source.suffix == ".zip" else source, new)
        return new.name

    def delete_model(self, model_type: str, name: str) -> None:
        """Delete the folder of a model.

        Raises:
            ExperimentError: it does not exist.
        """
        known = {path.name: path for path in _shelf(model_type).glob("*") if path.is_dir()}
        if name not in known:
            raise ExperimentError(f"no model '{name}' in {model_type}{did_you_mean(name, known)}")
        shutil.rmtree(known[name])

    def _running(self) -> list[tuple[str, Simulation]]:
        return [(name, one) for name, one in self._simulations if one.get_state() != STOPPED]

    def _leave(self) -> None:
        for name, simulation in self._running():
            log.warning("the script ends: the simulation of '%s' is stopped", name)
            simulation.stop()

    # -- files of runs

    def print_experiment_runs_files(self, exp_id: str, file_type: str) -> None:
        """Print the runs of an experiment, with the names of their files."""
        for number, run in enumerate(self._storage.find(exp_id).runs()):
            print(f"run {number}: {', '.join(_names(run, file_type))}")

    def print_experiment_run_files(self, exp_id: str, file_type: str, run_id: int) -> None:
        """Print the names of the files of a run."""
        _print(_names(self._storage.find(exp_id).run(int(run_id)), file_type))

    def print_last_run_files(self, exp_id: str, file_type: str) -> None:
        """Print the names of the files of the last run."""
        self.print_experiment_run_files(exp_id, file_type, -1)

    def get_experiment_run_file(self, exp_id: str, file_type: str, run_id: int, file_name: str) -> bytes:
        """Return the contents of a file of a run.

        Raises:
            ExperimentError: the experiment, run or file does not exist.
        """
        run = self._storage.find(exp_id).run(int(run_id))
        _names(run, file_type)
        return records.csv_contents(run, file_name)

    def get_last_run_file(self, exp_id: str, file_type: str, file_name: str) -> bytes:
        """Return the contents of a file of the last run.

        Raises:
            ExperimentError: the experiment, run or file does not exist.
        """
        return self.get_experiment_run_file(exp_id, file_type, -1, file_name)

    def print_csv_experiment_runs(self, exp_id: str) -> None:
        """Print the runs of an experiment, with the names of their CSV files."""
        self.print_experiment_runs_files(exp_id, "csv")

    def get_csv_experiment_run_file(self, exp_id: str, run_id: int, file_name: str) -> str:
        """Return the text of a CSV file of a run."""
        return self.get_experiment_run_file(exp_id, "csv", run_id, file_name).decode()

    def get_csv_last_run_file(self, exp_id: str, file_name: str) -> str:
        """Return the text of a CSV file of the last run."""
        return self.get_last_run_file(exp_id, "csv", file_name).decode()


def _names(run: Path, file_type: str) -> list[str]:
    if file_type not in _TYPES:
        raise ExperimentError(f"there are no files of type '{file_type}'{did_you_mean(file_type, _TYPES)}")
    return records.csv_names(run) if file_type == "csv" else []


def _shelf(model_type: str) -> Path:
    """Return the folder of the models of a type."""
    if model_type not in _SHELVES:
        raise ExperimentError(f"model_type is one of {', '.join(_SHELVES)}, not {model_type!r}")
    models = (os.environ.get("NRP_MODELS") or "").split(os.pathsep)[0]
    if not Path(models or "/no folder").is_dir():
        raise ExperimentError("no folder of models is known: name one by NRP_MODELS")
    return Path(models, model_type)


def _print(lines: list[Any]) -> None:
    for line in lines:
        print(line)
