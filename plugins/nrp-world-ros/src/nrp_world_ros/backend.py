"""The entry point: what the backend has, its options. Importing it does not load ROS."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from enum import IntEnum, StrEnum
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from nrp_core.clock import NS_PER_MS, NS_PER_S
from nrp_core.errors import BackendError, BackendLoadError
from nrp_core.quantities import DurationNs
from nrp_core.simulation import Determinism
from nrp_core.world import Diagnosis, Engine, Scene, WorldBackend, WorldCapabilities, WorldOptions
from pydantic import Field, model_validator

from nrp_world_ros import ros1, ros2

if TYPE_CHECKING:
    from nrp_world_ros.hosted.simulator import Simulator

LAST_DOMAIN = 232
"""DDS has no ports for more of them."""


class Ros(IntEnum):
    """The two that share a name."""

    ONE = 1
    """A master, TCP, rospy."""
    TWO = 2
    """DDS, in which everybody finds the others."""


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

    ros: Annotated[Ros, Field(description="1 or 2: which ROS the body is in")] = Ros.ONE
    domain: Annotated[
        int | None,
        Field(ge=0, le=LAST_DOMAIN, description="the domain of ROS 2; by default ROS_DOMAIN_ID says"),
    ] = None
    time: Annotated[TimeSource, Field(description="clock, wall or lockstep: what says how late it is")] = (
        TimeSource.CLOCK
    )
    timestep: Annotated[DurationNs, Field(gt=0, description="the grid on which the loop may look")] = (
        NS_PER_MS
    )
    patience: Annotated[DurationNs, Field(gt=0, description="how long to wait for anything from ROS")] = (
        10 * NS_PER_S
    )
    body: Annotated[
        str | None,
        Field(description="the backend that simulates the body in a process of its own, behind ROS 2"),
    ] = None
    body_options: Annotated[
        dict[str, Any], Field(default_factory=dict, description="the options of that backend")
    ]

    @model_validator(mode="before")
    @classmethod
    def _suits_a_body_of_ours(cls, given: Any) -> Any:
        """A simulated body is in ROS 2 and waits for the loop, unless the user contradicts."""
        if isinstance(given, dict) and given.get("body") is not None:
            return {"ros": Ros.TWO, "time": TimeSource.LOCKSTEP, **given}
        return given

    @model_validator(mode="after")
    def _agrees_with_itself(self) -> Self:
        if self.domain is not None and self.ros is Ros.ONE:
            raise ValueError("only ROS 2 has domains: say 'ros: 2', too")
        if self.body is None:
            if self.body_options:
                raise ValueError("'body_options' are for a simulated body: say 'body', too")
            return self
        if (self.ros, self.time) != (Ros.TWO, TimeSource.LOCKSTEP):
            raise ValueError("a simulated body is behind ROS 2, in lockstep: leave out 'ros' and 'time'")
        if "timestep" in self.model_fields_set:
            raise ValueError("the step of a simulated body is said in 'body_options'")
        try:
            _simulator(self.body, self.body_options)
        except BackendError as error:  # wrong options are told as they are
            raise ValueError(str(error)) from None
        return self


class RosBackend(WorldBackend):
    """The body is whatever listens to the topics: a robot, Gazebo, another process of this platform."""

    interface_version = 2
    options: ClassVar[type[WorldOptions]] = RosOptions

    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        assert isinstance(options, RosOptions)
        if options.body is not None:
            return replace(_simulator(options.body, options.body_options).capabilities, releases_gil=True)
        return WorldCapabilities(
            step_ns=options.timestep,
            determinism=Determinism.STATISTICAL,
            releases_gil=True,
            ball_joints=True,
            coupled_joints=True,
            own_scene=True,
            real_time=options.time is not TimeSource.LOCKSTEP,
        )

    def diagnose(self) -> list[Diagnosis]:
        found = [
            _look("ROS 1", "rospy", ros1.load_rospy, ros1.INSTALL),
            _look("ROS 2", "Cyclone DDS", ros2.load_dds, ros2.INSTALL),
        ]
        none = not any(each.present for each in found)  # one of the two is enough
        return [replace(each, needed=none) for each in found]

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        from nrp_world_ros.engine import RosEngine

        assert isinstance(options, RosOptions)
        capabilities = self.capabilities(options)
        if options.body is not None:
            from nrp_world_ros.hosted.engine import HostedEngine

            return HostedEngine(scene, seed, capabilities, options)
        return RosEngine(scene, seed, capabilities, options)


def _simulator(name: str, options: Mapping[str, Any]) -> Simulator:
    from nrp_world_ros.hosted.simulator import Simulator

    return Simulator.named(name, options)


def _look(ros: str, library: str, load: Callable[[], object], remedy: str) -> Diagnosis:
    try:
        load()
    except BackendLoadError as error:
        return Diagnosis(ros, False, f"{library} cannot be loaded: {error.__cause__}", remedy)
    return Diagnosis(ros, True, f"{library} is here", remedy)
