"""State machines of a simulation: read, exchanged, added and deleted while it runs."""

from __future__ import annotations

from pathlib import Path

from nrp_legacy.code import Source
from nrp_legacy.maker import ShimmedMaker
from nrp_legacy.notes import unnoted

from hbp_nrp_virtual_coach.live import Live
from nrp_core.errors import ExperimentError, did_you_mean
from nrp_core.experiment.running.run import Run


class StateMachineEdits(Live):
    """The part of a simulation that deals with state machines, which are named as their files."""

    def print_state_machines(self) -> None:
        """Print the names of the state machines."""
        for name in self._machines():
            print(name)

    def get_state_machine(self, name: str) -> str:
        """Return the source of a state machine.

        Raises:
            ExperimentError: there is none of this name.
        """
        return Source.of_file(self._machine(name)).text

    def edit_state_machine(self, name: str, source: str) -> None:
        """End a state machine and begin the new one, between two steps.

        Raises:
            ExperimentError: there is none of this name, or the source is not Python.
        """
        self._exchange_machine(self._machine(name), name, source)

    def add_state_machine(self, name: str, source: str) -> None:
        """Begin another state machine between two steps.

        Raises:
            ExperimentError: there is one of this name, or the source is not Python.
        """
        if Path(name).stem in self._machines():
            raise ExperimentError(f"there is a state machine '{name}' already; edit it", subject=name)
        self._exchange_machine(None, name, source)

    def delete_state_machine(self, name: str) -> None:
        """End a state machine.

        Raises:
            ExperimentError: there is none of this name.
        """
        path = self._machine(name)
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
        Source.of_file(path).compiled(unnoted)
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
