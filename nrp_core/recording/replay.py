"""Run a recording again: to verify it, against a recorded side, or on from somewhere within."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import reduce
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

from nrp_core.clock import seconds
from nrp_core.closing import Closing
from nrp_core.errors import ExperimentError, SimulationError, SnapshotError, did_you_mean
from nrp_core.experiment.model import Experiment
from nrp_core.experiment.prepare import Plan, Say, quietly
from nrp_core.experiment.run import Run
from nrp_core.recording.calls import LOST, changes_functions, repeat
from nrp_core.recording.capsule import Capsule, Origin
from nrp_core.recording.explanations import explanations, other_surroundings
from nrp_core.recording.hashes import GROUPS, Hasher
from nrp_core.recording.layout import SNAPSHOTS, Pictures
from nrp_core.recording.observer import Observer
from nrp_core.recording.read import Recording
from nrp_core.recording.recorded_brain import with_recorded_brain
from nrp_core.recording.recorded_world import with_recorded_world
from nrp_core.recording.self_contained import recorded_experiment
from nrp_core.recording.steps import Comparison, Difference, RecordedStep, steps_of
from nrp_core.recording.used_files import FilesRead
from nrp_core.world.messages.nrp_msgs import Called

Recorded = Literal["brain", "world"]


@dataclass(frozen=True, slots=True)
class Request:
    """How a recording shall run again.

    Args:
        recorded: which sides are played back instead of simulated.
        from_ns: where to go on from; by default from the beginning.
        until_ns: where to end; by default where the recording ends.
        functions: files that take the place of those of the same name.
        record: a new folder to record into from there on.
    """

    recorded: frozenset[Recorded] = frozenset()
    from_ns: int | None = None
    until_ns: int | None = None
    functions: Sequence[Path] = ()
    record: Path | None = None


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a replay.

    Args:
        steps: how many steps were compared.
        difference: the first one, if any.
        from_ns, until_ns: what was run and compared.
        error: what ended the run before its time, as it may have ended the recorded one.
        warnings: what may explain a difference.
    """

    steps: int
    difference: Difference | None
    from_ns: int
    until_ns: int
    error: str | None = None
    warnings: list[str] = field(default_factory=list)

    @property
    def identical(self) -> bool:
        """Whether everything was the same."""
        return self.difference is None


class Replay(Closing):
    """A recording that runs again.

    Args:
        recording: of which run.
        request: how.
        say: told what is being done.
        files: what notices which files are read, for a recording that is made of it.

    Raises:
        ExperimentError: the recording cannot be run again, or not so.
    """

    def __init__(
        self, recording: Recording, request: Request, say: Say = quietly, *, files: FilesRead | None = None
    ) -> None:
        self._recording, self._request, self._files = recording, request, files
        if request.from_ns is not None and request.recorded:
            raise ExperimentError("what is recorded of one side alone can only be run from the beginning")
        experiment = recorded_experiment(recording, ["pace=max"])
        edited = _edited(recording, experiment, request.functions)
        at_once = edited if request.from_ns is None else experiment
        self._edited = None if at_once is edited else edited
        with ExitStack() as opened:
            self._scratch = Path(opened.enter_context(TemporaryDirectory(prefix="nrp-replay-")))
            self.run: Run = opened.enter_context(Run(at_once, say, revise=self._revised))
            self._observer = Observer(
                self.run.brain, self.run.world, period_ns=experiment.timestep, pictures=_pictures(recording)
            )
            opened.callback(self._observer.close)
            self._close = opened.pop_all().close
        self.run.loop.hooks.from_outside.append(self._observer.note_from_outside)
        self.run.on_step.append(self._after_step)
        self._awaited: RecordedStep | None = None
        self._changes: list[Called] = []
        self._lost: list[str] = []
        groups = [name for name in GROUPS if name not in request.recorded]
        self._comparison, self._hasher = Comparison(groups), Hasher()
        self._chain = ""
        self.warnings = explanations(recording)

    def close(self) -> None:
        """Release the engines."""
        self._close()

    def verify(self) -> Outcome:
        """Run it, up to the first difference, and say what it is."""
        return self._go(stop_at_difference=True)

    def go(self) -> Outcome:
        """Run all of it, whatever differs; record it where that is wanted."""
        return self._go(stop_at_difference=False)

    # -- the parts of a replay

    def _revised(self, plan: Plan) -> Plan:
        exchange = {"brain": with_recorded_brain, "world": with_recorded_world}
        return reduce(
            lambda p, side: exchange[side](p, self._recording), sorted(self._request.recorded), plan
        )

    def _go(self, *, stop_at_difference: bool) -> Outcome:
        recorded = steps_of(self._recording)
        begin_ns = self._begin(recorded)
        self._comparison.steps = 0
        error = None
        try:
            self._follow(recorded, self._request.from_ns or begin_ns, stop_at_difference=False)
            with ExitStack() as stack:
                self._change(stack)
                self._follow(recorded, self._request.until_ns, stop_at_difference=stop_at_difference)
                if not (stop_at_difference and self._comparison.difference):
                    self._run_on()
        except SimulationError as raised:
            error = str(raised)
            self._comparison.ended(self._awaited or next(recorded, None), error)
        comparison = self._comparison
        if comparison.difference is not None:
            self.warnings += other_surroundings(self._recording)
        return Outcome(
            comparison.steps, comparison.difference, begin_ns, self.run.loop.now_ns, error, self.warnings
        )

    def _begin(self, recorded: Iterator[RecordedStep]) -> int:
        """Bring the run to where the comparison begins, and the recording with it; return the time."""
        first = next(recorded, None)
        if first is None:
            raise ExperimentError("not a single step was recorded", path=self._recording.file)
        if self._request.from_ns is not None and self._request.from_ns < first.t_ns:
            raise ExperimentError(f"begins at {seconds(first.t_ns):g} s only", path=self._recording.folder)
        snapshot = self._snapshot(first)
        if snapshot is None:
            self._compare(first)
            return first.t_ns
        at_ns, data = snapshot
        passed = self._pass(first, recorded, at_ns)
        self._restore(data)
        if passed is first:
            self._compare(first)
            return at_ns
        self._chain = passed.hash.chain
        self._observer.step(passed.hash.step)  # what has been compared when it was recorded
        return at_ns

    def _pass(self, first: RecordedStep, recorded: Iterator[RecordedStep], at_ns: int) -> RecordedStep:
        """Pass over the steps up to a time, changing functions as they were changed; return the last one."""
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
            if self._lost:
                raise SnapshotError(f"{error}; {'; '.join(self._lost)}") from error
            raise

    def _repeat(self, call: Called) -> None:
        """Do again what was done from outside, or say that it cannot be."""
        if call.name == LOST:
            self._lost.append(f"a replay does without {bytes(call.data).decode()}")
            self.warnings.append(self._lost[-1])
            return
        repeat(self.run, call, self._scratch)
        if changes_functions(call):
            self._changes.append(call)

    def _snapshot(self, first: RecordedStep) -> tuple[int, bytes] | None:
        """Return the last snapshot that was taken in time, or None where time 0 will do."""
        wanted_ns = first.t_ns if self._request.from_ns is None else self._request.from_ns
        found: tuple[int, bytes] | None = None
        for one in self._recording.messages({SNAPSHOTS}):
            if one.t_ns <= wanted_ns:
                found = one.t_ns, bytes(one.message.data)
        if found is None and first.t_ns > 0:
            raise ExperimentError(
                f"cannot be run again: it begins at {seconds(first.t_ns):g} s, and there is no snapshot",
                path=self._recording.folder,
            )
        return found

    def _follow(
        self, recorded: Iterator[RecordedStep], until_ns: int | None, *, stop_at_difference: bool
    ) -> None:
        """Take the steps that were recorded up to a time; by default all."""
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
        """Compare the step just taken, also where a transfer function has failed in it."""
        if self._awaited is not None:
            self._compare(self._awaited)
            self._awaited = None

    def _compare(self, recorded: RecordedStep) -> None:
        step = self._observer.step(recorded.hash.step)
        self._comparison.add(recorded, step, self._hasher.hashes(step), self._observer.codec)
        self._chain = recorded.hash.chain

    def _change(self, stack: ExitStack) -> None:
        """Take up the edited transfer functions, and begin to record."""
        wanted_ns, now_ns = self._request.from_ns, self.run.loop.now_ns
        if wanted_ns is not None and now_ns != wanted_ns:
            there = "the recording goes to" if now_ns < wanted_ns else "the next is at"
            raise ExperimentError(
                f"there is no step at {seconds(wanted_ns):g} s; {there} {seconds(now_ns):g} s",
                path=self._recording.folder,
            )
        if self._edited is not None:
            self._take_up(self._edited)
        if self._request.record is not None:
            origin = Origin(str(self._recording.folder.name), now_ns, self._chain) if now_ns else None
            capsule = Capsule(
                self.run, self._request.record, pictures=_pictures(self._recording), files=self._files,
                origin=origin, calls=self._changes,
            )  # fmt: skip
            stack.callback(lambda: self.warnings.extend(capsule.warnings))
            stack.push(lambda kind, *_: capsule.close("failed" if kind else "finished"))

    def _take_up(self, edited: Experiment) -> None:
        """Go on with the functions of the files, those that were edited among them."""
        self.run.continue_as(edited)
        if self._changes:
            self.warnings.append(
                f"from {self.run.now_s:g} s on the transfer functions are those of the files; how they were "
                "changed while the run went on is left out"
            )
            self._changes.clear()

    def _run_on(self) -> None:
        """Go on beyond what was recorded where that is wanted, and decide the criteria."""
        until_ns = self._request.until_ns
        self.run.run(seconds(self.run.loop.now_ns if until_ns is None else until_ns))


def _edited(recording: Recording, experiment: Experiment, files: Sequence[Path]) -> Experiment:
    """Return the experiment with files of transfer functions in place of those of the same name."""
    if not files:
        return experiment
    own = list(experiment.transfer_functions)
    for file in files:
        names = [path.name for path in own]
        if file.name not in names and len(own) != 1:
            hint = did_you_mean(file.name, names)
            raise ExperimentError(f"takes the place of no file of transfer functions{hint}", path=file)
        own[names.index(file.name) if file.name in names else 0] = file.resolve()
    listed = ", ".join(f'"{path}"' for path in own)
    return recorded_experiment(recording, ["pace=max", f"transfer_functions=[{listed}]"])


def _pictures(recording: Recording) -> Pictures:
    return Pictures(str(recording.run.get("pictures") or Pictures.EXACT))
