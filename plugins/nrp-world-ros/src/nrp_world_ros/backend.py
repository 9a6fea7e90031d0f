"""The entry point: what the backend has, its options. Importing it does not load ROS."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, ClassVar

from nrp_core.clock import NS_PER_MS, NS_PER_S
from nrp_core.diagnosis import Diagnosis
from nrp_core.quantities import DurationNs
from nrp_core.simulation import Determinism
from nrp_core.world.interface import World, WorldBackend, WorldCapabilities, WorldOptions
from nrp_core.world.scene.model import Scene
from pydantic import Field

from nrp_world_ros.rospy_import import INSTALL, why_missing


class TimeSource(StrEnum):
    """What says how late it is."""

    CLOCK = "clock"
    """The topic ``/clock``, as a simulator publishes it."""
    WALL = "wall"
    """The clock of this machine."""
    LOCKSTEP = "lockstep"
    """The loop itself: a body under ``nrp ros-bridge --lockstep`` waits for it."""


class RosOptions(WorldOptions):
    """Options of the ``ros`` backend."""

    time: Annotated[TimeSource, Field(description="clock, wall or lockstep: what says how late it is")] = (
        TimeSource.CLOCK
    )
    timestep: Annotated[DurationNs, Field(gt=0, description="the grid on which the loop may look")] = (
        NS_PER_MS
    )
    patience: Annotated[DurationNs, Field(gt=0, description="how long to wait for anything from ROS")] = (
        10 * NS_PER_S
    )


class RosBackend(WorldBackend):
    """The body is whatever listens to the topics: a robot, Gazebo, another process of this platform."""

    options: ClassVar[type[WorldOptions]] = RosOptions

    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        assert isinstance(options, RosOptions)
        return WorldCapabilities(
            step_ns=options.timestep,
            determinism=Determinism.STATISTICAL,
            releases_gil=True,
            real_time=options.time is not TimeSource.LOCKSTEP,
        )

    def diagnose(self) -> list[Diagnosis]:
        reason = why_missing()
        meaning = "rospy is here" if reason is None else reason
        return [Diagnosis("ROS 1", reason is None, meaning, INSTALL, needed=True)]

    def open(self, scene: Scene, *, seed: int, options: WorldOptions) -> World:
        from nrp_world_ros.world import RosWorld

        assert isinstance(options, RosOptions)
        return RosWorld(scene, seed, self.capabilities(options), options)
