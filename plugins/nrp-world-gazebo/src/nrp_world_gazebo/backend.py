"""The entry point of Gazebo."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from shutil import which
from typing import TYPE_CHECKING

from nrp_core.world import Diagnosis, PhysicsBackend, WorldCapabilities, WorldOptions
from nrp_world_gazebo.display import display_for
from nrp_world_gazebo.options import GazeboOptions, default_root

if TYPE_CHECKING:
    from nrp_core.world import JointedEngine

REMEDY = "scripts/gazebo, which makes a system with Gazebo 11"


class GazeboBackend(PhysicsBackend):
    """Scenes in Gazebo 11."""

    options = GazeboOptions
    interface_version = 2
    engine_name = "Gazebo"
    remedy = REMEDY
    releases_gil = True

    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        assert isinstance(options, GazeboOptions)
        known = super().capabilities(options)
        slip = float(options.drive != "planar")
        known = replace(known, ball_joints=False, ball_control=False, coupled_joints=False, loops=False)
        return replace(known, slip=slip)

    def diagnose(self) -> list[Diagnosis]:
        root = default_root()
        found = which("gzserver") if root is None else root / "usr/bin/gzserver"
        meaning = f"Gazebo is {found}" if found else "Gazebo is not on this system, and no root is chosen"
        return [Diagnosis("gzserver", bool(found), meaning, REMEDY), *super().diagnose()]

    def _own_renderers(self) -> tuple[str, ...]:
        return ("gazebo",) if display_for(default_root()) else ()

    def _engine_class(self) -> Callable[..., JointedEngine]:
        from nrp_world_gazebo.engine import GazeboEngine

        return GazeboEngine
