"""Replay a recording: to verify it, to run against a recorded side, or to continue from a time in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import reduce
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

from nrp_core._support import machine
from nrp_core._support.closing import Closing
from nrp_core._support.used_files import FilesRead
from nrp_core.clock import seconds
from nrp_core.errors import ExperimentError, RecordingError, SimulationError, SnapshotError, did_you_mean
from nrp_core.experiment.making.plan import Plan, ProgressCallback, no_progress
from nrp_core.experiment.model.experiment import Build, Experiment
from nrp_core.experiment.running.run import Run
from nrp_core.findings import Code, Finding, Findings, InvalidExperimentError, Level
from nrp_core.messages.nrp_msgs import Called
from nrp_core.recording.folder.calls import LOST, changes_functions, lost_call, repeat
from nrp_core.recording.folder.dependencies import Dependencies
from nrp_core.recording.folder.recording_folder import (
    FORMAT,
    OLDEST_FORMAT,
    ContinuedRecording,
    RecordingFolder,
    recorded_experiment,
)
from nrp_core.recording.layout import RUN_NAME, SNAPSHOTS, Images
from nrp_core.recording.reading.integrity import Flaw, IntegrityCheck
from nrp_core.recording.reading.steps import Comparison, Difference, RecordedStep, steps_of
from nrp_core.recording.recording import Recording
from nrp_core.recording.replay.recorded_world import (
    recorded_network,
    with_recorded_brain,
    with_recorded_world,
)
from nrp_core.recording.writing.hashes import GROUPS, Hasher
from nrp_core.recording.writing.recorder import StepCollector

_MOST_NAMED = 5
_MACHINE = ("python", "architecture", "cpu_features")
"""The properties of a machine that results may depend on."""


def require_format(recording: Recording) -> None:
    """Refuse a recording with another layout of files and hashes than this version's.

    Raises:
        ExperimentError: it has another layout; the message names the version that made it.
    """
    found = recording.run.get("format", FORMAT)
    if found not in range(OLDEST_FORMAT, FORMAT + 1):
        maker = dict(recording.run.get("distributions") or {}).get("nrp-core", "of an unknown version")
        raise ExperimentError(
            f"{recording.folder}: recorded by nrp-core {maker} in format {found}; "
            f"this version replays formats {OLDEST_FORMAT} to {FORMAT}"
        )


def explanations(recording: Recording, check: IntegrityCheck) -> Iterator[Finding]:
    """Yield findings about a recording itself: files that were changed or are missing, and others."""
    if not recording.run:
        yield _differs(f"it has no {RUN_NAME}, so the versions and files of its run are unknown", RUN_NAME)
        return
    for flaw in check.flaws:
        yield _differs(str(flaw), flaw.file)
    yield from map(_differs, check.notes)


def other_surroundings(recording: Recording) -> Iterator[Finding]:
    """Yield findings about versions, code and processor that have changed since the recording."""
    then = Dependencies.recorded(recording.run)
    if versions := then.changed_versions():
        yield _differs(f"it was made with {_join_names(versions)}")
    if other := other_code(recording):
        yield _differs(f"it was made by {other}")
    if others := replace(then.without_files_below_root(), packages={}, versions={}).changes():
        yield _differs(f"it was made with another content of {' and '.join(others)}")
    yield from map(
        _differs, _compare_machines(dict(recording.run.get("machine") or {}), machine.describe_machine())
    )


def _differs(message: str, subject: str | None = None) -> Finding:
    return Finding(Code.NRP285, message, Level.WARNING, subject=subject)


def other_code(recording: Recording) -> str:
    """Return a text that names packages whose code has changed since the recording; empty if none.

    They are the core, the backends, and the plugins and modules that the run loaded, such as sensors.
    """
    then = Dependencies.recorded(recording.run)
    if not then.packages:
        return "unknown code"
    changed = then.changed_packages()
    return f"other code of {' and '.join(changed)}" if changed else ""


def _compare_machines(then: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    for key in _MACHINE:
        if key in then and then[key] != now[key]:
            before, after = (_words(about[key]) for about in (then, now))
            yield f"it was made on another machine: {key.replace('_', ' ')} {before} (now {after})"


def _words(value: Any) -> str:
    return " ".join(value) if isinstance(value, list) else str(value)


def _join_names(names: list[str]) -> str:
    more = len(names) - _MOST_NAMED
    return ", ".join(names[:_MOST_NAMED]) + (f" and {more} more with other versions" if more > 0 else "")


class ReplayVerdict(StrEnum):
    """Whether a replay equals its recording."""

    IDENTICAL = "identical"
    """Everything that was recorded was compared, and is equal."""
    SAME = "the same"
    """A part of it was compared, and is equal."""
    DIFFERENT = "differs"
    """Something differs."""
    UNPROVED = "not identical"
    """Nothing was compared, or the recording is damaged."""


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """The result of a replay.

    Args:
        steps: the number of steps that were compared.
        difference: the first one, if any.
        from_ns, until_ns: the period that was compared; the run may have continued.
        flaws: the damaged files of the recording.
        not_compared: the parts of the recording that were not compared, as texts.
        error: the error that ended the run early; it may have ended the recorded run, too.
        warnings: possible reasons for a difference.
    """

    steps: int
    difference: Difference | None
    from_ns: int
    until_ns: int
    flaws: tuple[Flaw, ...] = ()
    not_compared: tuple[str, ...] = ()
    error: str | None = None
    warnings: Findings = field(default_factory=Findings)

    @property
    def verdict(self) -> ReplayVerdict:
        """Whether everything is equal."""
        if self.difference is not None:
            return ReplayVerdict.DIFFERENT
        if self.flaws or not self.steps:
            return ReplayVerdict.UNPROVED
        return ReplayVerdict.SAME if self.not_compared else ReplayVerdict.IDENTICAL

    @property
    def identical(self) -> bool:
        """Whether everything that was recorded was compared, and is equal."""
        return self.verdict is ReplayVerdict.IDENTICAL


Recorded = Literal["brain", "world"]


@dataclass(frozen=True, slots=True)
class ReplayRequest:
    """The request for a replay.

    Args:
        recorded: which sides are played back instead of simulated.
        from_ns: start time, ns; by default the beginning.
        until_ns: end time, ns; by default the end of the recording.
        functions: files that replace those of the same name.
        record: a new folder to record into from there on.
        overwrite: whether to replace a recording in that folder.
    """

    recorded: frozenset[Recorded] = frozenset()
    from_ns: int | None = None
    until_ns: int | None = None
    functions: Sequence[Path] = ()
    record: Path | None = None
    overwrite: bool = False


class Replay(Closing):
    """A recording that runs again.

    Args:
        recording: the recording.
        request: the request.
        progress: called with the name of each task as it begins.
        files: notes the files that are read, for a new recording.
        check: the result of a check of the recording; by default it is checked.

    Raises:
        ExperimentError: the recording cannot be replayed, or not with this request.
    """

    def __init__(
        self,
        recording: Recording,
        request: ReplayRequest,
        progress: ProgressCallback = no_progress,
        *,
        files: FilesRead | None = None,
        check: IntegrityCheck | None = None,
    ) -> None:
        require_format(recording)
        self._recording, self._request, self._progress, self._files = recording, request, progress, files
        if request.from_ns is not None and request.recorded:
            raise ExperimentError("a single recorded side can only be played back from the start")
        since_ns, until_ns = request.from_ns, request.until_ns
        if since_ns is not None and until_ns is not None and until_ns <= since_ns:
            raise ExperimentError(
                f"cannot continue from {seconds(since_ns):g} s until {seconds(until_ns):g} s"
            )
        experiment = recorded_experiment(recording, ["pace=max"])
        edited = _with_edited_files(recording, experiment, request.functions)
        self._experiment = edited if request.from_ns is None else experiment
        self._edited = None if self._experiment is edited else edited
        self._awaited: RecordedStep | None = None
        groups = [name for name in GROUPS if name not in request.recorded]
        self._comparison, self._hasher = Comparison(groups), Hasher()
        self._chain = ""
        self._check = recording.check() if check is None else check
        self.warnings = Findings(explanations(recording, self._check))
        self._open()

    def _open(self) -> None:
        """Open the engines, at time 0."""
        with ExitStack() as opened:
            self._scratch = Path(opened.enter_context(TemporaryDirectory(prefix="nrp-replay-")))
            self.run: Run = opened.enter_context(self._opened())
            self._collector = StepCollector(
                self.run.brain, self.run.world, period_ns=self._experiment.timestep,
                images=_images(self._recording), scope=self._experiment.recording,
            )  # fmt: skip
            opened.callback(self._collector.close)
            self._close = opened.pop_all().close
        self.run.loop.hooks.from_outside.append(self._collector.note_from_outside)
        self.run.on_step(self._after_step)
        self._changes: list[Called] = []
        self._lost: list[Finding] = []

    def _opened(self) -> Run:
        """Return a run; one with a recorded brain has no projections, unless a function needs them."""
        build = self._build()
        try:
            return Run(self._experiment, self._progress, revise=self._revise, build=build)
        except InvalidExperimentError:
            if build is None:
                raise
            return Run(self._experiment, self._progress, revise=self._revise)

    def close(self) -> None:
        """Release the engines."""
        self._close()

    def verify(self) -> ReplayResult:
        """Run it up to the first difference, and return the result."""
        return self._go(stop_at_difference=True)

    def go(self) -> ReplayResult:
        """Run all of it, regardless of differences; record it if requested."""
        return self._go(stop_at_difference=False)

    # -- the parts of a replay

    def _revise(self, plan: Plan) -> Plan:
        exchange = {"brain": with_recorded_brain, "world": with_recorded_world}
        return reduce(
            lambda p, side: exchange[side](p, self._recording), sorted(self._request.recorded), plan
        )

    def _build(self) -> Build | None:
        """Return a maker of the network that does not run the script, if the brain is played back."""
        network = recorded_network(self._recording.run) if "brain" in self._request.recorded else None
        return None if network is None else lambda _: network

    def _go(self, *, stop_at_difference: bool) -> ReplayResult:
        recorded, begin_ns = self._begin()
        self._comparison.steps = 0
        error, compared_ns = None, begin_ns
        try:
            self._follow(recorded, self._request.from_ns or begin_ns, stop_at_difference=False)
            with ExitStack() as stack:
                self._change(stack)
                self._follow(recorded, self._request.until_ns, stop_at_difference=stop_at_difference)
                compared_ns = self.run.loop.now_ns
                if not (stop_at_difference and self._comparison.difference):
                    self._run_on()
        except RecordingError:
            raise
        except SimulationError as raised:
            error = str(raised)
            self._comparison.ended(self._awaited or next(recorded, None), error)
        comparison = self._comparison
        if comparison.difference is not None:
            self.warnings += other_surroundings(self._recording)
        return ReplayResult(
            comparison.steps,
            comparison.difference,
            begin_ns,
            compared_ns if error is None else self.run.loop.now_ns,
            self._check.flaws,
            tuple(self._not_compared(begin_ns, compared_ns, next(recorded, None))),
            error,
            self.warnings,
        )

    def _not_compared(self, begin_ns: int, compared_ns: int, rest: RecordedStep | None) -> Iterator[str]:
        if begin_ns > self._recorded_from_ns:
            yield f"the steps up to {seconds(begin_ns):g} s"
        if rest is not None:
            yield f"the steps after {seconds(self.run.loop.now_ns):g} s"
        elif self.run.loop.now_ns > compared_ns:
            yield f"the steps after {seconds(compared_ns):g} s, which were not recorded"
        for side in sorted(self._request.recorded):
            yield f"the {side}, which was played back"

    def _begin(self) -> tuple[Iterator[RecordedStep], int]:
        """Advance the run to the start of the comparison; return the recorded steps from there, and the time.

        If a snapshot does not fit, a recording that starts at 0 is run from there.
        """
        recorded = steps_of(self._recording)
        first = self._first(recorded)
        snapshot = self._snapshot(first)
        try:
            if snapshot is not None:
                self._go_to(first, recorded, *snapshot)
                return recorded, snapshot[0]
        except SnapshotError as error:
            if first.t_ns > 0 or self._lost:
                raise
            self.warnings.add(Code.NRP285, f"{error}; the run starts at 0 instead")
            self._close()
            self._open()
            recorded = steps_of(self._recording)
            first = next(recorded)
        self._compare(first)
        return recorded, first.t_ns

    def _first(self, recorded: Iterator[RecordedStep]) -> RecordedStep:
        first = next(recorded, None)
        if first is None:
            raise ExperimentError(
                "not a recording of a run, or without an intact step", path=self._recording.file
            )
        self._recorded_from_ns = first.t_ns
        if self._request.from_ns is not None and self._request.from_ns < first.t_ns:
            raise ExperimentError(f"starts at {seconds(first.t_ns):g} s only", path=self._recording.folder)
        return first

    def _go_to(
        self, first: RecordedStep, recorded: Iterator[RecordedStep], at_ns: int, snapshot: bytes
    ) -> None:
        """Advance the run and the recording to a snapshot."""
        passed = self._pass(first, recorded, at_ns)
        self._restore(snapshot)
        if passed is first:
            self._compare(first)
            return
        self._chain = passed.hash.chain
        self._collector.step(passed.hash.step)  # these messages belong to a step before the comparison

    def _pass(self, first: RecordedStep, recorded: Iterator[RecordedStep], at_ns: int) -> RecordedStep:
        """Skip the steps up to a time, but repeat the changes of functions; return the last one."""
        step = first
        while True:
            for call in step.calls:
                if call.name == LOST or changes_functions(call):
                    self._repeat(call)
            if step.t_ns >= at_ns:
                return step
            step = next(recorded)

    def _restore(self, snapshot: bytes) -> None:
        try:
            self.run.restore(snapshot)
        except SnapshotError as error:
            reasons = [str(error), *(finding.message for finding in self._lost), *self._about_snapshot()]
            raise SnapshotError("; ".join(reasons)) from error

    def _about_snapshot(self) -> Iterator[str]:
        """Return possible reasons why a snapshot does not fit, and a remedy."""
        if other := other_code(self._recording):
            yield f"it was made by {other}"
        if origin := self._recording.run.get("continues"):
            place = f"'{origin['recording']}' at {seconds(origin['t_ns']):g} s"
            yield f"continue again from {place}, from which this run started"

    def _repeat(self, call: Called) -> None:
        """Repeat a call from outside, or warn that this is not possible."""
        if call.name == LOST:
            self._lost.append(lost_call(bytes(call.data).decode()))
            self.warnings.append(self._lost[-1])
            return
        repeat(self.run, call, self._scratch)
        if changes_functions(call):
            self._changes.append(call)

    def _snapshot(self, first: RecordedStep) -> tuple[int, bytes] | None:
        """Return the last snapshot before the start, or None if the run can start at time 0."""
        wanted_ns = first.t_ns if self._request.from_ns is None else self._request.from_ns
        found: tuple[int, bytes] | None = None
        for one in self._recording.messages({SNAPSHOTS}):
            if one.t_ns <= wanted_ns:
                found = one.t_ns, bytes(one.message.data)
        if found is None and first.t_ns > 0:
            raise ExperimentError(
                f"cannot be run again: it starts at {seconds(first.t_ns):g} s and has no snapshot",
                path=self._recording.folder,
            )
        return found if found is None or self._may_fit(first) else None

    def _may_fit(self, first: RecordedStep) -> bool:
        """Return whether to use snapshots; those from other code may be misread without an error.

        A recording that starts with a snapshot needs it.
        """
        other = other_code(self._recording)
        if other:
            instead = "they may not fit" if first.t_ns else "the run starts at 0 instead"
            self.warnings.add(Code.NRP285, f"the snapshots were made by {other}; {instead}")
        return bool(first.t_ns) or not other

    def _follow(
        self, recorded: Iterator[RecordedStep], until_ns: int | None, *, stop_at_difference: bool
    ) -> None:
        """Repeat the recorded steps up to a time, by default all."""
        if until_ns is not None and until_ns <= self.run.loop.now_ns:
            return
        for step in recorded:
            for call in step.calls:
                self._repeat(call)
            for topic, message in step.from_outside:
                self.run.loop.publish(topic, message)
            self._awaited = step
            self.run.step()
            if stop_at_difference and self._comparison.difference is not None:
                return
            if until_ns is not None and step.t_ns >= until_ns:
                return

    def _after_step(self, run: Run) -> None:
        """Compare the last step, even if a transfer function has failed in it."""
        if self._awaited is not None:
            self._compare(self._awaited)
            self._awaited = None

    def _compare(self, recorded: RecordedStep) -> None:
        step = self._collector.step(recorded.hash.step)
        self._comparison.add(recorded, step, self._hasher.hashes(step), self._collector.codec)
        self._chain = recorded.hash.chain

    def _change(self, stack: ExitStack) -> None:
        """Use the edited transfer functions, and start to record."""
        now_ns = self.run.loop.now_ns
        if self._request.from_ns is not None and now_ns != self._request.from_ns:
            raise self._no_step(self._request.from_ns)
        if self._edited is not None:
            self._take_up(self._edited)
        if self._request.record is not None:
            origin = (
                ContinuedRecording(str(self._recording.folder.name), now_ns, self._chain) if now_ns else None
            )
            recording_folder = RecordingFolder(
                self.run, self._request.record, images=_images(self._recording), files=self._files,
                origin=origin, calls=self._changes, overwrite=self._request.overwrite,
            )  # fmt: skip
            stack.callback(lambda: self.warnings.extend(recording_folder.warnings))
            stack.push(lambda kind, *_: recording_folder.close("failed" if kind else "finished"))

    def _no_step(self, wanted_ns: int) -> ExperimentError:
        """Return the error for a time without a step, which the run has passed or did not reach."""
        now_ns = self.run.loop.now_ns
        there = "the recording ends at" if now_ns < wanted_ns else "the next step is at"
        message = f"there is no step at {seconds(wanted_ns):g} s; {there} {seconds(now_ns):g} s"
        return ExperimentError(message, path=self._recording.folder)

    def _take_up(self, edited: Experiment) -> None:
        """Continue with the functions of the files, including those that were edited."""
        self.run.continue_as(edited)
        if self._changes:
            self.warnings.add(
                Code.NRP285,
                f"from {self.run.now_s:g} s on the transfer functions are those of the files; changes "
                "made to them during the recorded run are left out",
            )
            self._changes.clear()

    def _run_on(self) -> None:
        """Continue beyond the end of the recording if requested, and decide the criteria."""
        until_ns = self._request.until_ns
        if until_ns is not None and until_ns < self.run.loop.now_ns:
            raise self._no_step(until_ns)
        self.run.run(seconds(self.run.loop.now_ns if until_ns is None else until_ns))


def _with_edited_files(recording: Recording, experiment: Experiment, files: Sequence[Path]) -> Experiment:
    """Return the experiment with files of transfer functions replaced by those of the same name."""
    if not files:
        return experiment
    own = list(experiment.transfer_functions)
    for file in files:
        names = [path.name for path in own]
        if file.name not in names and len(own) != 1:
            hint = did_you_mean(file.name, names)
            raise ExperimentError(f"does not have the name of a file of transfer functions{hint}", path=file)
        own[names.index(file.name) if file.name in names else 0] = file.resolve()
    listed = ", ".join(f'"{path}"' for path in own)
    return recorded_experiment(recording, ["pace=max", f"transfer_functions=[{listed}]"])


def _images(recording: Recording) -> Images:
    return Images(str(recording.run.get("images") or recording.run.get("pictures") or Images.EXACT))
