"""What came of a run, as data."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from nrp_core.cle.failures import Failure
from nrp_core.clock import seconds
from nrp_core.experiment.events.criteria import Verdict
from nrp_core.world.rigid.pose import Pose


@dataclass(frozen=True, slots=True)
class Result:
    """What came of a run. Two runs that agree differ in nothing but the wall times and the time shares.

    Args:
        experiment: its name.
        brain, world: names of the backends.
        seed: what everything random followed from.
        sim_time_s: simulated time that was reached.
        wall_time_s: real time that it took, opening and compiling not counted.
        real_time_factor: their ratio; 0 before the first step.
        steps: steps of the closed loop.
        passed: whether all criteria are met; None: some are not decided, the run was cut short.
        error: what ended the run before its time, if anything did.
        criteria: what came of each.
        time_share: of ``brain``, ``world``, ``transfer_functions`` and ``engine`` in the work.
        final_pose: of each robot: ``x, y, z`` in m, ``roll, pitch, yaw`` in rad.
        trajectory_digest: hash of the poses of all robots at every step, bit for bit.
        spikes: of each named view and population.
        events: when each happened, s; None: it did not.
        failures: transfer functions that raised: ``function, path, line, t_s, error``.
        warnings: what was not as expected.
    """

    experiment: str
    brain: str
    world: str
    seed: int
    sim_time_s: float
    wall_time_s: float
    real_time_factor: float
    steps: int
    passed: bool | None
    error: str | None
    criteria: dict[str, Verdict]
    time_share: dict[str, float]
    final_pose: dict[str, dict[str, float]]
    trajectory_digest: str
    spikes: dict[str, int]
    events: dict[str, float | None]
    failures: list[dict[str, Any]]
    warnings: list[str]

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain data for JSON."""
        return asdict(self)


def pose_data(pose: Pose) -> dict[str, float]:
    """Return a pose as an experiment file writes it, by name."""
    return dict(zip(("x", "y", "z", "roll", "pitch", "yaw"), (*pose.position, *pose.rpy), strict=True))


def failure_data(failure: Failure) -> dict[str, Any]:
    """Return what is worth keeping of a failure."""
    return {
        "function": failure.function,
        "path": str(failure.path),
        "line": failure.line,
        "t_s": seconds(failure.t_ns),
        "error": f"{type(failure.error).__name__}: {failure.error}",
    }
