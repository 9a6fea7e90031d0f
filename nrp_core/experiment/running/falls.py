"""Robots that fall out of the room during a run."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from math import isfinite

from nrp_core.clock import seconds
from nrp_core.findings import Code, Finding, Level
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.raycast.solids import can_fall, room_of
from nrp_core.world.rigid import Pose
from nrp_core.world.scene.model import Scene

DEPTH_M = 2.0
"""A robot has fallen if it is this far below everything that is static, or below its start without a room."""


def bodies_fall(capabilities: WorldCapabilities) -> bool:
    """Return whether a world lets the bodies of its scene fall."""
    return capabilities.dynamics and not capabilities.own_scene


class FallWatch:
    """Checks the height of robots at every step, and reports the first time of each fall.

    Args:
        scene: the scene with the robots at their start poses.
        robots: names of the robots.
        capabilities: capabilities of the world; without dynamics nothing is checked.
    """

    def __init__(self, scene: Scene, robots: Collection[str], capabilities: WorldCapabilities) -> None:
        self._limits_m = dict(_limits_m(scene, robots)) if bodies_fall(capabilities) else {}
        self.reset()

    def reset(self) -> None:
        """Forget all falls."""
        self._fallen: dict[str, Finding] = {}

    def look(self, now_ns: int, poses: Mapping[str, Pose]) -> None:
        """Check the poses at a time."""
        for name, limit_m in self._limits_m.items():
            if name not in self._fallen and name in poses and poses[name].position[2] < limit_m:
                message = (
                    f"the robot '{name}' has fallen {DEPTH_M:g} m below the room: it is at z "
                    f"{poses[name].position[2]:.2f} m at {seconds(now_ns):g} s"
                )
                self._fallen[name] = Finding(Code.NRP293, message, Level.WARNING, subject=name)

    def findings(self) -> list[Finding]:
        """Return a finding for each robot that has fallen."""
        return list(self._fallen.values())


def _limits_m(scene: Scene, robots: Collection[str]) -> Iterator[tuple[str, float]]:
    """Yield each robot that can fall, and the height below which it has fallen."""
    room_m = min((solid.lowest_m for solid in room_of(scene)), default=None)
    for model in scene.models:
        if model.name in robots and can_fall(model, scene):
            start_m = model.pose.position[2]
            lowest_m = start_m if room_m is None else min(room_m, start_m)
            if isfinite(lowest_m):
                yield model.name, lowest_m - DEPTH_M
