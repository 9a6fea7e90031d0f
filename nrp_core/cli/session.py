"""One run from the command line: load, open, step, record, draw, summarize."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from nrp_core.cli.options import usage_errors
from nrp_core.cli.output import INTERRUPTED, NO, as_data, complain, document, lines, warn
from nrp_core.cli.progress import Display, display
from nrp_core.cli.summary import summary
from nrp_core.clock import from_seconds, milliseconds, seconds
from nrp_core.errors import NrpError
from nrp_core.experiment.model.experiment import Experiment
from nrp_core.experiment.reading.find import load_experiment
from nrp_core.experiment.running.control import ControlServer
from nrp_core.experiment.running.control_commands import commands_of
from nrp_core.experiment.running.result import Result
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Weight
from nrp_core.findings.problems import is_warning
from nrp_core.network.files.network_file import check_network_file, save_network
from nrp_core.quantities import RoundedNs, time_ns
from nrp_core.recording.layout import Images, check_folder
from nrp_core.running import open_checked_run
from nrp_core.scripts import intercept_os_exit

if TYPE_CHECKING:
    from nrp_core._support.used_files import FilesRead
    from nrp_core.recording.folder.recording_folder import RecordingFolder

OFF = "off"


@dataclass(frozen=True, slots=True)
class RunRequest:
    """The request of the command line.

    Args:
        experiment: its name, file or folder.
        overrides: settings, ``dotted.key=value``.
        until: end time with its unit; None: the end of the experiment.
        record: a folder to record into.
        images: how camera images are recorded.
        snapshots: the time between two snapshots with its unit, or ``off``.
        plots: files to draw a figure into.
        overwrite: whether existing files and recordings are replaced.
        control: a socket to listen on.
        allow_incomplete: whether an incomplete run may succeed.
        verbose: whether to print every problem, not only their number.
        ignore: codes of findings that are not reported.
        save_brain: a network file to store the brain in, with its weights at the end.
    """

    experiment: str
    overrides: Sequence[str]
    until: str | None = None
    record: Path | None = None
    images: Images = Images.EXACT
    snapshots: str = "10s"
    plots: tuple[Path, ...] = ()
    overwrite: bool = False
    control: Path | None = None
    allow_incomplete: bool = False
    verbose: bool = False
    ignore: tuple[str, ...] = ()
    save_brain: Path | None = None


class Session:
    """Carries out one request."""

    def __init__(self, request: RunRequest) -> None:
        self._request = request
        self._error: NrpError | None = None
        self._interrupted = False
        self._fixed: list[str] = []
        self._control: ControlServer | None = None

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
            if folder is not None:
                self._draw(folder)
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
        for target in request.plots:
            from nrp_core.recording.figures import check_target

            with usage_errors("--plot"):
                check_target(target, overwrite=request.overwrite)
        if request.record is not None:
            with usage_errors("--record"):
                check_folder(request.record, overwrite=request.overwrite)
        if request.save_brain is not None:
            with usage_errors("--save-brain"):
                check_network_file(request.save_brain, overwrite=request.overwrite)

    def _recording_folder(self, stack: ExitStack) -> Path | None:
        """Return the folder to record into; a figure alone needs a temporary recording."""
        if self._request.record is None and self._request.plots:
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
            is_rounded = isinstance(experiment.timestep, RoundedNs)
            if too_far_ns and experiment.strict and not is_rounded:
                step = f"{milliseconds(experiment.timestep):g} ms"
                raise ValueError(f"{self._request.until} is not a whole number of steps of {step}")
            if too_far_ns:  # with a rounded period, or the old platform's time step
                until_ns += experiment.timestep - too_far_ns
        return seconds(until_ns)

    # -- the run

    def _read(self) -> Experiment:
        experiment = load_experiment(self._request.experiment, self._request.overrides)
        return experiment.ignoring(self._request.ignore) if self._request.ignore else experiment

    def _simulate(self, shown: Display, folder: Path | None) -> Result:
        shown.begin_task("reading the experiment")
        with ExitStack() as stack:
            files = None
            if folder is not None:
                from nrp_core._support.used_files import FilesRead

                files = stack.enter_context(FilesRead())
            experiment = self._read()
            until_s = self._until_s(experiment)
            simulation = stack.enter_context(open_checked_run(experiment, shown.begin_task, until_s=until_s))
            if self._request.record is None:
                with usage_errors("--overwrite"):
                    simulation.check_csv(overwrite=self._request.overwrite)
            _announce(simulation)
            shown.watch(simulation, seconds(experiment.duration) if until_s is None else until_s)
            if self._request.control is not None:
                commands = commands_of(simulation)
                self._control = stack.enter_context(
                    ControlServer(self._request.control, commands, waits=True)
                )
            with intercept_os_exit():
                self._step(simulation, until_s, folder, files)
            self._write_csv(simulation)
            self._save_brain(simulation)
            result, floats = simulation.result(), simulation.world.engine.floats
            self._fixed = [robot for robot in result.final_pose if not floats(robot)]
            return result

    def _step(
        self, simulation: Run, until_s: float | None, folder: Path | None, files: FilesRead | None
    ) -> None:
        """Run to the end, with or without a recording."""
        if folder is None:
            self._run_guarded(simulation, until_s)
            return
        from nrp_core.recording.folder.expected_size import size_note
        from nrp_core.recording.folder.recording_folder import RecordingFolder

        request = self._request
        note = size_note(simulation, until_s) if request.record is not None else None
        if note is not None:
            complain(note, label="note")
        snapshots_ns = None if request.snapshots == OFF else time_ns(request.snapshots)
        recording_folder = RecordingFolder(
            simulation,
            folder,
            images=request.images,
            files=files,
            snapshots_ns=snapshots_ns,
            overwrite=request.overwrite,
        )
        state = "failed"
        try:
            self._run_guarded(simulation, until_s)
            if self._error is None:
                state = "interrupted" if self._interrupted else "finished"
        finally:
            self._complete(recording_folder, state)

    def _complete(self, recording_folder: RecordingFolder, state: str) -> None:
        try:
            recording_folder.close(state)
        except NrpError as error:
            self._error = self._error or error

    def _write_csv(self, simulation: Run) -> None:
        if self._request.record is not None:
            return  # the recording holds the rows
        try:
            simulation.write_csv(overwrite=self._request.overwrite)
        except NrpError as error:
            self._error = self._error or error

    def _save_brain(self, simulation: Run) -> None:
        file = self._request.save_brain
        try:
            if file is not None and self._error is None:
                save_network(simulation.brain.learned_network(), file, overwrite=self._request.overwrite)
        except NrpError as error:
            self._error = error

    def _run_guarded(self, simulation: Run, until_s: float | None) -> None:
        if self._control is not None:
            self._control.answer()  # the recording must begin first, because it notes every change
        try:
            if until_s is None:
                simulation.run()
            else:
                simulation.run_until_ns(from_seconds(until_s))  # the user wrote its unit
        except KeyboardInterrupt:
            self._interrupted = True
        except NrpError as error:
            self._error = error

    # -- after the run

    def _draw(self, folder: Path) -> None:
        for target in self._request.plots:
            from nrp_core.recording import figures as plot
            from nrp_core.recording.recording import Recording

            plot.plot(Recording(folder), target, overwrite=True)

    def _report(self, result: Result, *, as_json: bool) -> None:
        error = self._error
        if as_json:
            document({
                **result.to_dict(),
                "error": None if error is None else as_data(error),
                "interrupted": self._interrupted,
                "recording": self._request.record,
                "figure": next(iter(self._request.plots), None),
                "figures": self._request.plots,
            })  # fmt: skip
            return
        for line in lines(error) if error else ():
            complain(line)
        request = self._request
        summary(
            result,
            recording=request.record,
            figures=request.plots,
            fixed=self._fixed,
            details=request.verbose,
        )

    def _exit_code(self, result: Result) -> int:
        if self._interrupted:
            return INTERRUPTED
        is_missed = not (result.complete or self._request.allow_incomplete)
        return NO if self._error is not None or result.passed is False or is_missed else 0


def _announce(simulation: Run) -> None:
    """Report the number of problems before the first step; the summary at the end lists them."""
    problems = [problem for problem in simulation.problems if is_warning(problem)]
    others = [problem for problem in problems if problem.weight is not Weight.INCOMPLETE]
    warnings = sum(problem.count for problem in others)
    missing = sum(problem.count for problem in problems) - warnings
    if missing:
        parts = "a part of the experiment is" if missing == 1 else f"{missing} parts of the experiment are"
        warn(f"{parts} left out, so the run will not be complete")
    if warnings:
        kinds = len({problem.code for problem in others})
        count = "1 warning" if warnings == 1 else f"{warnings} warnings of {kinds} kind{'s' * (kinds > 1)}"
        complain(f"{count}, shown at the end; nrp validate shows them now", label="note")
