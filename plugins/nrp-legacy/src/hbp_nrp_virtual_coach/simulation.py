"""A simulation as scripts steer it."""

from __future__ import annotations

from pathlib import Path

from nrp_legacy.code import Source, ignore_note
from nrp_legacy.maker import ShimmedMaker

from hbp_nrp_virtual_coach.brain import BrainEdits
from hbp_nrp_virtual_coach.live import Live
from hbp_nrp_virtual_coach.records import Records
from hbp_nrp_virtual_coach.settings import log, say_once
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment import Run


class StateMachineEdits(Live):
    """The part of a simulation that deals with state machines, which are named as their files."""

    def print_state_machines(self) -> None:
        """Print the names of the state machines."""
        for name in self._machines():
            print(name)

    def get_state_machine(self, state_machine_name: str) -> str:
        """Return the source of a state machine.

        Raises:
            ExperimentError: it does not exist.
        """
        return Source.of_file(self._machine(state_machine_name)).text

    def edit_state_machine(self, state_machine_name: str, state_machine: str) -> None:
        """End a state machine and begin the new one, between two steps.

        Raises:
            ExperimentError: it does not exist, or the source is not Python.
        """
        self._exchange_machine(self._machine(state_machine_name), state_machine_name, state_machine)

    def add_state_machine(self, state_machine_name: str, state_machine: str) -> None:
        """Begin another state machine between two steps.

        Raises:
            ExperimentError: one of this name exists, or the source is not Python.
        """
        if Path(state_machine_name).stem in self._machines():
            raise ExperimentError(
                f"there is a state machine '{state_machine_name}' already; edit it",
                subject=state_machine_name,
            )
        self._exchange_machine(None, state_machine_name, state_machine)

    def delete_state_machine(self, state_machine_name: str) -> None:
        """End a state machine.

        Raises:
            ExperimentError: it does not exist.
        """
        path = self._machine(state_machine_name)
        self._runner.call(lambda run: _maker(run).playing.exchange(path, None))

    def save_state_machines(self) -> None:
        """Write changed state machines into the folder of the experiment.

        Raises:
            ExperimentError: that is not yours.
        """
        for path in self._machines().values():
            if self._is_draft(path):
                self._save(self._stored.file.parent / path.name, Source.of_file(path).text)

    def _exchange_machine(self, old: Path | None, name: str, source: str) -> None:
        path = self._draft(f"{Path(name).stem}.exd", source)
        Source.of_file(path).compiled(ignore_note)
        self._runner.call(lambda run: _maker(run).playing.exchange(old, path))

    def _machines(self) -> dict[str, Path]:
        return self._runner.call(lambda run: {path.stem: path for path in _maker(run).machines})

    def _machine(self, name: str) -> Path:
        machines = self._machines()
        if Path(name).stem not in machines:
            raise ExperimentError(
                f"there is no state machine '{name}'{did_you_mean(name, machines)}", subject=name
            )
        return machines[Path(name).stem]


def _maker(run: Run) -> ShimmedMaker:
    maker = run.experiment.maker
    if not isinstance(maker, ShimmedMaker):
        raise ExperimentError(
            "state machines run in experiments of the Neurorobotics Platform only; use events"
        )
    return maker


_RESETS = ("full", "robot_pose", "world", "brain")


class Simulation(BrainEdits, StateMachineEdits, Records):
    """An experiment that was launched by :meth:`.VirtualCoach.launch_experiment`; errors are ``NrpError``."""

    __logger = log  # scripts quieten it: sim._Simulation__logger.setLevel(...)

    def reset(self, reset_type: str) -> None:
        """Pause the simulation and reset a part of it; it stays paused.

        Args:
            reset_type: ``full``: everything, time too; ``robot_pose``: the robots return to where they began;
                ``world``: so do all other models; ``brain``: the network restarts; the time continues.

        Raises:
            ExperimentError: the reset does not exist.
            CapabilityError: the engine cannot put bodies elsewhere.
        """
        if reset_type not in _RESETS:
            hint = did_you_mean(reset_type, _RESETS)
            raise ExperimentError(f"there is no reset '{reset_type}'{hint}", subject=reset_type)
        part = {"robot_pose": "robot"}.get(reset_type, reset_type)
        self._runner.reset(lambda run: run.reset("all" if part == "full" else part))

    def save_world(self) -> None:
        """Do nothing: experiments begin in the state of their files."""
        say_once("save_world: the world of an experiment is its SDF file, which stays as it is")
