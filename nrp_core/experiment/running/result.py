"""The result of a run, and its judgement: whether it is complete, passed, and its problems.

``passed`` is True only if the run is complete, has criteria and meets them all. It is False if a criterion is
not met or an error ended the run. Otherwise it is None: it has no criteria, some are still open,
or a requested part is missing from the run.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Final

from nrp_core._support.named_values import Named
from nrp_core._support.overview import Overview, Row
from nrp_core.cle.loop import Failure
from nrp_core.clock import from_seconds, seconds
from nrp_core.errors import ExperimentError
from nrp_core.experiment.events.criteria import Verdict
from nrp_core.findings import Code, Finding, Level, Weight
from nrp_core.findings.problems import ProblemGroup, grouped, is_complete, lines_of, ordered
from nrp_core.scene.rigid import Pose

FINISHED, FAILED, INTERRUPTED, RUNNING = "finished", "failed", "interrupted", "running"
"""The states of a run; a recording that still says ``running`` was killed."""

_ROBOTS: Final = (Code.NRP382, Code.NRP256)
"""Codes of robots that are lost or left out."""


def passed_of(state: str, complete: bool, criteria: Iterable[bool | None]) -> bool | None:
    """Return whether a run passed.

    Args:
        state: how it ended.
        complete: whether all requested parts were there.
        criteria: the outcome of each criterion.
    """
    outcomes = list(criteria)
    if state == FAILED or False in outcomes:
        return False
    return True if complete and outcomes and None not in outcomes else None


@dataclass(frozen=True, slots=True)
class Judgement:
    """The judgement of a run.

    Args:
        state: how it ended.
        problems: the problems by weight, then by place.
        criteria: the outcome of each criterion.
        reached_s: simulated time that was reached, s.
        duration_s: simulated time of the whole experiment, s; None: not known.
    """

    state: str
    problems: tuple[Finding, ...]
    criteria: Mapping[str, bool | None]
    reached_s: float
    duration_s: float | None = None

    @property
    def complete(self) -> bool:
        """Whether the run had all requested parts."""
        return is_complete(self.problems)

    @property
    def passed(self) -> bool | None:
        """Whether the run passed; see the module."""
        return passed_of(self.state, self.complete, self.criteria.values())

    @property
    def covers_all(self) -> bool:
        """Whether the run reached the end of the experiment, as far as known."""
        if self.duration_s is None:
            return self.state == FINISHED
        return self.state == FINISHED and from_seconds(self.reached_s) >= from_seconds(self.duration_s)

    @property
    def headline(self) -> str:
        """The judgement in one line."""
        return f"{self._verdict}{self._span}"

    @property
    def groups(self) -> list[ProblemGroup]:
        """The problems by code, the weightiest first."""
        return list(grouped(self.problems))

    def lines(self, *, details: bool = False) -> Iterator[tuple[Weight, str]]:
        """Yield the problems with their weight; several with the same code are counted.

        Args:
            details: whether to yield each of several problems, and its place, as well.
        """
        yield from lines_of(self.problems, details=details)

    @property
    def _verdict(self) -> str:
        if self.state == RUNNING:
            return f"killed or still running at {self.reached_s:g} s"
        if self.state != FINISHED:
            return f"{self.state} at {self.reached_s:g} s"
        failed = sum(passed is False for passed in self.criteria.values())
        if failed:
            return f"failed: {'a criterion is' if failed == 1 else f'{failed} criteria are'} not met"
        if not self.complete:
            return f"not complete: {self._missing}"
        if not self.criteria:
            return "done"
        return "passed" if self.passed else "not decided: the run ended early"

    @property
    def _missing(self) -> str:
        """What is missing from the run: the robots first."""
        missing = [group for group in self.groups if group.weight is Weight.INCOMPLETE]
        missing.sort(key=lambda group: group.code not in _ROBOTS)
        more = sum(len(group.findings) for group in missing[1:])
        return missing[0].headline + (f" (and {more} more)" if more else "")

    @property
    def _span(self) -> str:
        """The part of the experiment that was judged, if not all of it."""
        if self.covers_all or self.state != FINISHED:
            return ""
        if not self.criteria:
            return f" ({self.reached_s:g} s of {self.duration_s:g} s)"
        outcomes = list(self.criteria.values())
        counts = {"met": outcomes.count(True), "not met": outcomes.count(False), "open": outcomes.count(None)}
        text = ", ".join(f"{count} {word}" for word, count in counts.items() if count)
        return f" (criteria judged up to {self.reached_s:g} s of {self.duration_s:g} s: {text})"


def recorded_judgement(run: Mapping[str, Any], reached_s: float) -> Judgement | None:
    """Return the judgement of a recorded run; None for a bare file without a description of its run.

    Args:
        run: the contents of ``run.json``.
        reached_s: simulated time of the last recorded step, s.
    """
    if not run:
        return None
    result = dict(run.get("result") or {})
    state = str(run.get("state") or RUNNING) if result else RUNNING
    criteria = {name: outcome["passed"] for name, outcome in dict(result.get("criteria") or {}).items()}
    problems = _recorded_problems(result, state, reached_s)
    reached_s = result.get("sim_time_s", reached_s)
    return Judgement(state, problems, criteria, reached_s, result.get("duration_s"))


def _recorded_problems(result: Mapping[str, Any], state: str, reached_s: float) -> tuple[Finding, ...]:
    """Return the problems of a recorded result; before version 0.2 results had texts and failures."""
    if "problems" in result:
        found = [Finding.from_dict(problem) for problem in result["problems"]]
        if state == INTERRUPTED and is_complete(found):  # the run continued, its recording did not
            found.append(interruption("recorded only in part, up to", reached_s))
        if state == FAILED and is_complete(found):  # the error came from outside of the run
            found.append(_ended_by(result))
        return ordered(found)
    found = [Finding(Code.NRP278, str(text), Level.WARNING) for text in result.get("warnings", ())]
    for failure in result.get("failures", ()) if state == FINISHED else ():
        message = f"the transfer function '{failure['function']}' raised {failure['error']}"
        found.append(Finding(Code.NRP272, message, Level.WARNING, line=failure["line"]))
    if state == FAILED:
        found.append(_ended_by(result))
    if state in (INTERRUPTED, RUNNING):
        found.append(interruption("killed at" if state == RUNNING else "interrupted at", reached_s))
    return ordered(found)


def _ended_by(result: Mapping[str, Any]) -> Finding:
    return Finding(Code.NRP276, str(result.get("error") or "an error ended the run"), Level.WARNING)


def interruption(how: str, t_s: float) -> Finding:
    """Return the finding about a run that was interrupted or killed."""
    return Finding(Code.NRP294, f"the run was {how} {t_s:g} s", Level.WARNING)


_KINDS: Final = {
    "criteria": "criterion", "final_pose": "robot", "spikes": "population or view", "events": "event",
    "activity": "activity", "time_share": "share of time",
}  # fmt: skip
"""What the names in the dictionaries of a result are of."""


@dataclass(frozen=True, slots=True, repr=False)
class Result(Overview):
    """The result of a run. The results of equal runs differ only in wall times and time shares.

    A name that a dictionary lacks raises :class:`.UnknownNameError`, with the valid names.

    Args:
        experiment: name of the experiment.
        brain, world: names of the backends.
        seed: the seed of all random numbers.
        sim_time_s: simulated time that was reached, s.
        wall_time_s: wall time that it took, s, without opening and compiling.
        real_time_factor: their ratio; 0 before the first step.
        steps: steps of the closed loop.
        duration_s: simulated time of the whole experiment, s.
        state: how the run ended: ``finished``, ``failed`` or ``interrupted``.
        complete: whether no part of the experiment was left out, no function
            was stopped by an error, and no error or interruption ended the run early.
        passed: True: complete, and all criteria are met. False: a criterion is not met, or an error ended the
            run. None: it has no criteria, some are open, or the run is not complete.
        problems: the findings about the run, by weight, then by place.
        error: the error that ended the run early, if any.
        criteria: the outcome of each criterion.
        time_share: shares of ``brain``, ``world``, ``transfer_functions`` and ``engine`` in the total.
        final_pose: final pose of each robot: ``x, y, z`` in m, ``roll, pitch, yaw`` in rad.
        trajectory_digest: hash of the poses of all models that move, and of the positions of their joints, at
            every step, bit for bit; up to version 0.3 of the poses of robots alone.
        spikes: number of spikes of each named view and population.
        activity: number of ``spikes`` of all neurons, and of ``synaptic_events``, the synapses that these
            reached.
        events: time of each event, s; None: it did not happen.
        failures: transfer functions that raised: ``function, path, line, t_s, error``.
    """

    experiment: str
    brain: str
    world: str
    seed: int
    sim_time_s: float
    wall_time_s: float
    real_time_factor: float
    steps: int
    duration_s: float
    state: str
    complete: bool
    passed: bool | None
    problems: list[Finding]
    error: str | None
    criteria: dict[str, Verdict]
    time_share: dict[str, float]
    final_pose: dict[str, dict[str, float]]
    trajectory_digest: str
    spikes: dict[str, int]
    activity: dict[str, int]
    events: dict[str, float | None]
    failures: list[dict[str, Any]]

    def __post_init__(self) -> None:
        for name, kind in _KINDS.items():
            object.__setattr__(self, name, Named(getattr(self, name), kind))

    def _overview(self) -> tuple[str, Iterable[Row]]:
        marks = {True: "met", False: "not met", None: "open"}
        return (
            f"of {self.experiment} on {self.brain} and {self.world}, seed {self.seed}: "
            f"{self.judgement.headline}",
            [
                ("part", "value", "meaning"),
                *((name, marks[one.passed], one.reason) for name, one in self.criteria.items()),
                *(
                    (name, f"({at['x']:.3g}, {at['y']:.3g}, {at['z']:.3g}) m", "final position")
                    for name, at in self.final_pose.items()
                ),
                *((name, count, "spikes") for name, count in self.spikes.items()),
                *((name, "-" if t_s is None else f"{t_s:g} s", "event") for name, t_s in self.events.items()),
                *((str(one.code.name), one.level.value, one.message) for one in self.problems),
            ],
        )

    @property
    def judgement(self) -> Judgement:
        """The judgement of the run, as all summaries print it."""
        criteria = {name: outcome.passed for name, outcome in self.criteria.items()}
        return Judgement(self.state, tuple(self.problems), criteria, self.sim_time_s, self.duration_s)

    @property
    def recording(self) -> Any:
        """The :class:`~nrp_core.Recording` of the run.

        Raises:
            ExperimentError: it was not recorded.
        """
        raise ExperimentError("the run was not recorded; run(..., record='folder') records it")

    def plot(self, what: str = "run", **options: Any) -> Any:
        """Draw the run, if it was recorded; see :meth:`.Recording.plot`."""
        return self.recording.plot(what, **options)

    def video(self, **options: Any) -> Any:
        """Write a video of the run, if it was recorded; see :meth:`.Recording.video`."""
        return self.recording.video(**options)

    def to_xarray(self) -> Any:
        """Return all numbers of the run, if it was recorded; see :meth:`.Recording.to_xarray`."""
        return self.recording.to_xarray()

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data for JSON."""
        return asdict(replace(self, problems=[])) | {"problems": [each.to_dict() for each in self.problems]}


def state_of(error: BaseException | None) -> str:
    """Return the final state of a run, given the error that ended it."""
    if error is None:
        return FINISHED
    return FAILED if isinstance(error, Exception) else INTERRUPTED


def pose_data(pose: Pose) -> dict[str, float]:
    """Return a pose as an experiment file writes it, by name."""
    return dict(zip(("x", "y", "z", "roll", "pitch", "yaw"), (*pose.position, *pose.rpy), strict=True))


def failure_data(failure: Failure) -> dict[str, Any]:
    """Return the data of a failure for the result."""
    return {
        "function": failure.function,
        "path": str(failure.path),
        "line": failure.line,
        "t_s": seconds(failure.t_ns),
        "error": f"{type(failure.error).__name__}: {failure.error}",
    }
