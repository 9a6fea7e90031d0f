"""Pushing and moving bodies."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

from nrp_core.errors import ExperimentError
from nrp_core.experiment.running.run import Run
from nrp_core.world.messages.base import Duration
from nrp_core.world.messages.geometry_msgs import Vector3, Wrench
from nrp_core.world.rigid.motion import ModelMotion
from nrp_core.world.rigid.pose import Pose


class Bodies:
    """The bodies of a run.

    Args:
        run: the run.
    """

    def __init__(self, run: Run) -> None:
        self._run = run

    def push(self, body: str, force_n: Sequence[float], duration_s: float) -> None:
        """Apply a force, N, to the first link of a body for a time."""
        force = _numbers(force_n, 3, "a force, N")
        model = self._run.world.scene.model(body)
        whole, part = divmod(round(duration_s * 1e9), 1_000_000_000)
        self._run.world.call(
            "/gazebo/apply_body_wrench",
            body_name=f"{body}::{model.links[0].name}",
            wrench=Wrench(force=Vector3(*force)),
            duration=Duration(int(whole), int(part)),
        )

    def place(self, body: str, position: Sequence[float], orientation: Sequence[float]) -> None:
        """Move a body to a pose, at rest; position in m, orientation x, y, z, w."""
        x, y, z = _numbers(position, 3, "a position, m")
        a, b, c, d = _numbers(orientation, 4, "an orientation, x, y, z and w")
        self._run.world.place(body, ModelMotion(Pose((x, y, z), (a, b, c, d))))


def _numbers(given: Sequence[float], count: int, what: str) -> tuple[float, ...]:
    if len(given) != count or not all(map(isfinite, given)):
        raise ExperimentError(f"{what} is {count} finite numbers, not {list(given)}")
    return tuple(given)
