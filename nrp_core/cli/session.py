"""One run from the command line: load, open, step, record, draw, summarize."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from nrp_core.cli.failure import INTERRUPTED, NO, as_data, complain, lines
from nrp_core.cli.options import usage_errors
from nrp_core.cli.output import document
from nrp_core.cli.progress import Display, display
from nrp_core.cli.summary import summary
from nrp_core.clock import milliseconds, seconds
from nrp_core.errors import NrpError
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.commands import commands_of
from nrp_core.experiment.running.control import ControlServer
from nrp_core.experiment.running.result import Result
from nrp_core.experiment.running.run import Run
from nrp_core.quantities import time_ns
from nrp_core.recording.layout import Pictures, check_folder

if TYPE_CHECKING:
    from nrp_core.recording.folder.recording_folder import RecordingFolder
    from nrp_core.recording.folder.used_files import FilesRead

OFF = "off"


@dataclass(frozen=True, slots=True)
class RunRequest:
    """What the command line asks for.

    Args:
        experiment: its name, file or folder.
        overrides: settings, ``dotted.key=value``.
        until: end time with its unit; None: the end of the experiment.
        record: a folder to record into.
        pictures: how camera images are recorded.
        snapshots: the time between two snapshots with its unit, or ``off``.
        plot: a file to draw a figure into.
        control: a socket to listen on.
    """

    experiment: str
    overrides: Sequence[str]
    until: str | None = None
    record: Path | None = None
    pictures: Pictures = Pictures.EXACT
    snapshots: str = "10s"
    plot: Path | None = None
    control: Path | None = None


class Session:
    """Carries out one request."""

    def __init__(self, request: RunRequest) -> None:
        self._request = request
        self._error: NrpError | None = None
        self._interrupted = False
        self._printed: list[str] = []

    def run(self, *, as_json: bool) -> int:
        """Carry out the request and return the exit code.

        Raises:
            NrpError: the run could not begin. An error after that is reported with the result.
        """
        self._check_options()
        with ExitStack() as stack:
            shown = stack.enter_context(display())
            folder = self._recording_folder(stack)
            result = self._simulate(shown, folder)
            if self._request.plot is not None and folder is not None:
                self._draw(folder, self._request.plot)
        self._report(result, as_json=as_json)
        return self._exit_code(result)

    # -- before the run

    def _check_options(self) -> None:
        """Refuse invalid options before the experiment is opened."""
        request = self._request
        if request.until is not None:
            with usage_errors("--until"):
                time_ns(request.until)
        if request.snapshots != OFF:
            with usage_errors("--snapshots"):
                if time_ns(request.snapshots) <= 0:
                    raise ValueError(f"expected a time above 0 or '{OFF}', not {request.snapshots}")
        if request.plot is not None:
            from nrp_core.recording.figures import check_target

            with usage_errors("--plot"):
                check_target(request.plot)
        if request.record is not None:
            with usage_errors("--record"):
                check_folder(request.record)

    def _recording_folder(self, stack: ExitStack) -> Path | None:
        """Return the folder to record into; a figure alone needs a temporary recording."""
        if self._request.record is None and self._request.plot is not None:
            return Path(stack.enter_context(TemporaryDirectory())) / "recording"
        return self._request.record

    def _until_s(self, experiment: Experiment) -> float | None:
        if self._request.until is None:
            return None
        until_ns = time_ns(self._request.until)
        with usage_errors("--until"):
            if until_ns < 0:
                raise ValueError(f"a run begins at 0 s, so it cannot stop at {self._request.until}")
            too_far_ns = until_ns % experiment.timestep
            if too_far_ns and experiment.strict:
                step = f"{milliseconds(experiment.timestep):g} ms"
                raise ValueError(f"{self._request.until} is not a whole number of steps of {step}")
            if too_far_ns:  # round up where the old platform's time step applies
                until_ns += experiment.timestep - too_far_ns
        return seconds(until_ns)

    # -- the run

    def _simulate(self, shown: Display, folder: Path | None) -> Result:
        shown.begin_task("reading the experiment")
        with ExitStack() as stack:
            files = None
            if folder is not None:
                from nrp_core.recording.folder.used_files import FilesRead

                files = stack.enter_context(FilesRead())
            experiment = load_experiment(self._request.experiment, self._request.overrides)
            until_s = self._until_s(experiment)
            simulation = stack.enter_context(Run(experiment, shown.begin_task))
            self._warn(simulation.warnings)
            shown.watch(simulation, seconds(experiment.duration) if until_s is None else until_s)
            if self._request.control is not None:
                stack.enter_context(ControlServer(self._request.control, commands_of(simulation)))
            warnings = self._step(simulation, until_s, folder, files)
            self._write_csv(simulation)
            result = simulation.result()
        return replace(result, warnings=[*result.warnings, *warnings])

    def _step(
        self, simulation: Run, until_s: float | None, folder: Path | None, files: FilesRead | None
    ) -> list[str]:
        """Run to the end, with or without a recording; return the warnings of the recording."""
        if folder is None:
            self._run_guarded(simulation, until_s)
            return []
        from nrp_core.recording.folder.recording_folder import RecordingFolder

        request = self._request
        snapshots_ns = None if request.snapshots == OFF else time_ns(request.snapshots)
        recording_folder = RecordingFolder(
            simulation, folder, pictures=request.pictures, files=files, snapshots_ns=snapshots_ns
        )
        state = "failed"
        try:
            self._run_guarded(simulation, until_s)
            if self._error is None:
                state = "interrupted" if self._interrupted else "finished"
        finally:
            self._complete(recording_folder, state)
        return recording_folder.warnings

    def _complete(self, recording_folder: RecordingFolder, state: str) -> None:
        try:
            recording_folder.close(state)
        except NrpError as error:
            self._error = self._error or error

    def _write_csv(self, simulation: Run) -> None:
        recorded = self._request.record
        try:
            simulation.write_csv(None if recorded is None else recorded / "csv")
        except NrpError as error:
            self._error = self._error or error

    def _run_guarded(self, simulation: Run, until_s: float | None) -> None:
        try:
            simulation.run(until_s)
        except KeyboardInterrupt:
            self._interrupted = True
        except NrpError as error:
            self._error = error

    def _warn(self, warnings: Sequence[str]) -> None:
        """Print the warnings that have not been printed yet."""
        for warning in warnings:
            if warning not in self._printed:
                complain(warning, label="warning", color="yellow")
                self._printed.append(warning)

    # -- after the run

    def _draw(self, folder: Path, target: Path) -> None:
        from nrp_core.recording import figures as plot
        from nrp_core.recording.reading.recording import Recording

        plot.plot(Recording(folder), target)

    def _report(self, result: Result, *, as_json: bool) -> None:
        error = self._error
        self._warn(result.warnings)
        if as_json:
            document({
                **result.to_dict(),
                "error": None if error is None else as_data(error),
                "interrupted": self._interrupted,
                "recording": self._request.record,
                "figure": self._request.plot,
            })  # fmt: skip
            return
        for line in lines(error) if error else ():
            complain(line)
        summary(
            result, interrupted=self._interrupted, recording=self._request.record, figure=self._request.plot
        )

    def _exit_code(self, result: Result) -> int:
        if self._interrupted:
            return INTERRUPTED
        return NO if self._error is not None or result.passed is False else 0
