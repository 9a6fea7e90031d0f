"""The result of a run, as data."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any, Final

from nrp_core._support.named_values import Named
from nrp_core.cle.engine import Failure
from nrp_core.clock import seconds
from nrp_core.experiment.events.criteria import Verdict
from nrp_core.experiment.running.judgement import Judgement
from nrp_core.findings import Finding
from nrp_core.world.rigid import Pose

_KINDS: Final = {
    "criteria": "criterion", "final_pose": "robot", "spikes": "population or view", "events": "event",
    "activity": "activity", "time_share": "share of time",
}  # fmt: skip
"""What the names in the dictionaries of a result are of."""


@dataclass(frozen=True, slots=True)
class Result:
    """The result of a run. The results of equal runs differ only in wall times and time shares.

    A name that a dictionary lacks raises :class:`.UnknownNameError`, with those that there are.

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
        trajectory_digest: hash of the poses of all robots at every step, bit for bit.
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

    @property
    def judgement(self) -> Judgement:
        """The judgement of the run, as all summaries print it."""
        criteria = {name: outcome.passed for name, outcome in self.criteria.items()}
        return Judgement(self.state, tuple(self.problems), criteria, self.sim_time_s, self.duration_s)

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data for JSON."""
        return asdict(replace(self, problems=[])) | {"problems": [each.to_dict() for each in self.problems]}


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
