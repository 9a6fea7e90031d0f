"""The Virtual Coach: it finds experiments and launches them, in this process."""

from __future__ import annotations

import atexit
import shutil
from functools import partial
from pathlib import Path
from typing import Any

from hbp_nrp_virtual_coach import records, settings
from hbp_nrp_virtual_coach.runner import STOPPED
from hbp_nrp_virtual_coach.settings import log, say_once
from hbp_nrp_virtual_coach.simulation import Simulation
from hbp_nrp_virtual_coach.storage import Storage, folders_of
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import load_experiment, shipped

_TYPES = ("csv", "profiler")
_HERE = "this process"


class VirtualCoach:
    """Launches experiments. Errors are ``NrpError``.

    Args:
        environment: a folder with a folder for each experiment. Names and addresses of servers are accepted;
            experiments are then in the folders of the variable ``NRP_EXPERIMENTS``.
        oidc_username, oidc_password, oidc_token, storage_username, storage_password: accepted.

    Raises:
        ExperimentError: a folder does not exist.
    """

    def __init__(
        self,
        environment: str | Path = "local",
        oidc_username: str | None = None,
        oidc_password: str | None = None,
        oidc_token: str | None = None,
        storage_username: str | None = None,
        storage_password: str | None = None,
    ) -> None:
        self._storage = Storage(folders_of(str(environment)))
        if str(environment) != "local" and not Path(environment).is_dir():
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
    ) -> Simulation:
        """Open an experiment and return its simulation, which is paused.

        Args:
            experiment_id: the name of its folder, or of an installed experiment.
            server: accepted.
            reservation: accepted.
            cloned: accepted: experiments in the folders precede installed ones.
            brain_processes: accepted.
            profiler: accepted.

        Raises:
            NrpError: it does not exist, or is invalid.
        """
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
        """Print and return the one place where experiments run."""
        _print([_HERE])
        return [_HERE]

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

    clone_cloned_experiment = clone_experiment_to_storage

    def delete_cloned_experiment(self, experiment_id: str) -> None:
        """Delete the folder of an experiment.

        Raises:
            ExperimentError: it does not exist, or it is installed.
        """
        shutil.rmtree(self._storage.find_own(experiment_id).file.parent)

    def import_experiment(self, path: str | Path) -> str:
        """Copy the folder or ZIP archive of an experiment into the first folder and return its name.

        Raises:
            ExperimentError: it is not an experiment, or no folder is set.
        """
        return self._storage.add(Path(path), Path(path).stem)

    def set_experiment_file(self, experiment_id: str, file_name: str, file_content: str) -> None:
        """Write a file of an experiment.

        Raises:
            ExperimentError: no such experiment of yours exists, or the file would lie outside of it.
        """
        folder = self._storage.find_own(experiment_id).file.parent.resolve()
        path = (folder / file_name).resolve()
        if folder not in path.parents:
            raise ExperimentError(
                f"'{file_name}' lies outside of the experiment '{experiment_id}'", path=path
            )
        path.write_text(file_content, encoding="utf-8")

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

    def get_experiment_run_file(self, exp_id: str, file_type: str, run_id: int, file_name: str) -> str:
        """Return the text of a file of a run.

        Raises:
            ExperimentError: the experiment, run or file does not exist.
        """
        run = self._storage.find(exp_id).run(int(run_id))
        _names(run, file_type)
        return records.csv_text(run, file_name)

    def get_last_run_file(self, exp_id: str, file_type: str, file_name: str) -> str:
        """Return the text of a file of the last run.

        Raises:
            ExperimentError: the experiment, run or file does not exist.
        """
        return self.get_experiment_run_file(exp_id, file_type, -1, file_name)

    def print_csv_experiment_runs(self, exp_id: str) -> None:
        """Print the runs of an experiment, with the names of their CSV files."""
        self.print_experiment_runs_files(exp_id, "csv")

    def get_csv_experiment_run_file(self, exp_id: str, run_id: int, file_name: str) -> str:
        """Return the text of a CSV file of a run."""
        return self.get_experiment_run_file(exp_id, "csv", run_id, file_name)

    def get_csv_last_run_file(self, exp_id: str, file_name: str) -> str:
        """Return the text of a CSV file of the last run."""
        return self.get_last_run_file(exp_id, "csv", file_name)


def _names(run: Path, file_type: str) -> list[str]:
    if file_type not in _TYPES:
        raise ExperimentError(f"there are no files of type '{file_type}'{did_you_mean(file_type, _TYPES)}")
    return records.csv_names(run) if file_type == "csv" else []


def _print(lines: list[Any]) -> None:
    for line in lines:
        print(line)
