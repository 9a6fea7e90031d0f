"""Pushing and moving bodies."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot, isclose, isfinite

from nrp_core.errors import ExperimentError
from nrp_core.experiment import Run
from nrp_core.messages.base import Duration
from nrp_core.messages.geometry_msgs import Vector3, Wrench
from nrp_core.scene.rigid import ModelMotion, Pose
from nrp_core.world import width_m

_SHORTEST_S = 1e-6
"""Shorter than the step of any engine."""
_ROUNDING = 0.01
_FARTHEST = 10.0
"""Widths of the scene between its origin and the farthest place for a body."""


class Bodies:
    """The bodies of a run.

    Args:
        run: the run.
    """

    def __init__(self, run: Run) -> None:
        self._run = run
        self._moves: dict[str, list[int]] = {}  # of each body, those that were not taken back
        self._number = 0

    def push(self, body: str, force_n: Sequence[float], duration_s: float) -> None:
        """Apply a force, N, to the first link of a body for a time.

        Raises:
            ExperimentError: no body would move.
        """
        force = _numbers(force_n, 3, "a force, N")
        model = self._run.world.scene.model(body)
        if model.static:
            raise ExperimentError(f"'{body}' is static: no force moves it")
        if not any(force):
            raise ExperimentError("force_n: a force of 0 N moves nothing")
        if not (isfinite(duration_s) and duration_s >= _SHORTEST_S):
            raise ExperimentError(f"duration_s: a time of {_SHORTEST_S:g} s or more, not {duration_s:g} s")
        whole, part = divmod(round(duration_s * 1e9), 1_000_000_000)
        self._run.world.call(
            "/gazebo/apply_body_wrench",
            body_name=f"{body}::{model.links[0].name}",
            wrench=Wrench(force=Vector3(*force)),
            duration=Duration(int(whole), int(part)),
        )

    def place(
        self,
        body: str,
        position: Sequence[float],
        orientation: Sequence[float],
        undoes: int | None = None,
    ) -> dict[str, int]:
        """Move a body to a pose, at rest, and return the number of the move.

        Args:
            body: its name.
            position: m.
            orientation: x, y, z, w.
            undoes: the number of the move that this one takes back.

        Raises:
            ExperimentError: the pose is impossible, or the move to be taken back is not the last one.
        """
        moves = self._moves.get(body, [])
        if undoes is not None and moves[-1:] != [undoes]:
            raise ExperimentError(
                f"'{body}' stays where it is: since then it was reset or moved again, perhaps by others"
            )
        x, y, z = _numbers(position, 3, "a position, m")
        width = width_m(self._run.world.scene)
        if hypot(x, y, z) > _FARTHEST * width:
            raise ExperimentError(
                f"position: at most {_FARTHEST * width:.3g} m from the origin, since the scene is "
                f"{width:.3g} m wide, not {hypot(x, y, z):.3g} m"
            )
        a, b, c, d = _numbers(orientation, 4, "an orientation, x, y, z and w")
        length = hypot(a, b, c, d)
        if not isclose(length, 1.0, abs_tol=_ROUNDING):
            raise ExperimentError(f"orientation: x, y, z and w of a quaternion of length 1, not {length:.3g}")
        self._run.world.place(body, ModelMotion(Pose((x, y, z), (a, b, c, d))))
        if undoes is not None:
            moves.pop()
            return {"number": undoes}
        self._number += 1
        self._moves[body] = [*moves, self._number]
        return {"number": self._number}

    def forget(self) -> None:
        """Forget all moves, which a reset has taken back."""
        self._moves.clear()


def _numbers(given: Sequence[float], count: int, what: str) -> tuple[float, ...]:
    if len(given) != count or not all(map(isfinite, given)):
        raise ExperimentError(f"{what} is {count} finite numbers, not {list(given)}")
    return tuple(given)
