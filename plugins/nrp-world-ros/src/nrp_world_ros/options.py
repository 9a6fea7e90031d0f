"""Options of the ``ros`` backend."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from pathlib import Path
from typing import Annotated, Any, Self

from nrp_core import worlds
from nrp_core.clock import NS_PER_MS, NS_PER_S
from nrp_core.errors import BackendError, ExperimentError
from nrp_core.paths import MissingFileError, existing_file, existing_folder
from nrp_core.quantities import DurationNs
from nrp_core.world import Scene, World, WorldBackend, WorldCapabilities, WorldOptions
from pydantic import BeforeValidator, Field, ValidationError, model_validator


@dataclass(frozen=True, slots=True)
class Simulator:
    """A world backend and its options."""

    backend: WorldBackend
    options: WorldOptions

    @classmethod
    def named(cls, name: str, options: Mapping[str, Any]) -> Simulator:
        """Find the backend.

        Args:
            name: its entry-point name.
            options: as in an experiment file.

        Raises:
            BackendError: the backend does not exist, or it does not load.
            ExperimentError: an option is wrong, or the backend runs in real time.
        """
        backend = worlds().load(name)
        try:
            simulator = cls(backend, backend.options.model_validate(dict(options)))
        except ValidationError as error:
            first = error.errors()[0]
            option = ".".join(map(str, first["loc"]))
            raise ExperimentError(f"option '{option}' of the body '{name}': {first['msg']}") from None
        if simulator.capabilities.real_time:
            raise ExperimentError(f"'{name}' runs in real time, but a simulated body must wait for the loop")
        return simulator

    @property
    def capabilities(self) -> WorldCapabilities:
        """Its capabilities."""
        return self.backend.capabilities(self.options)

    def open(self, scene: Scene, seed: int) -> World:
        """Open a scene."""
        return self.backend.open(scene, seed=seed, options=self.options)


LAST_DOMAIN = 232
"""Maximum domain; DDS does not have ports for more."""


class Ros(IntEnum):
    """The versions of ROS."""

    ONE = 1
    """A master, TCP, rospy."""
    TWO = 2
    """DDS with automatic discovery."""


class TimeSource(StrEnum):
    """The source of the time."""

    CLOCK = "clock"
    """The topic ``/clock``, as a simulator publishes it."""
    WALL = "wall"
    """The clock of this machine."""
    LOCKSTEP = "lockstep"
    """The loop itself: a body under ``nrp ros-bridge --lockstep`` waits for it."""


def _existing(value: object) -> Path:
    """Return the path of a bag, which is a file or a folder; pydantic reports an error."""
    try:
        return existing_file(value)
    except MissingFileError:
        with suppress(MissingFileError):
            return existing_folder(value)
        raise


class RosOptions(WorldOptions):
    """Options of the ``ros`` backend."""

    ros: Annotated[Ros, Field(description="version of ROS of the body, 1 or 2")] = Ros.ONE
    domain: Annotated[
        int | None,
        Field(ge=0, le=LAST_DOMAIN, description="the domain of ROS 2; by default ROS_DOMAIN_ID"),
    ] = None
    time: Annotated[TimeSource, Field(description="source of the time: clock, wall or lockstep")] = (
        TimeSource.CLOCK
    )
    timestep: Annotated[DurationNs, Field(gt=0, description="the time grid of the loop")] = NS_PER_MS
    stop_after: Annotated[
        DurationNs,
        Field(gt=0, description="how late a step may be at wall time before drives are stopped"),
    ] = 200 * NS_PER_MS
    stamped: Annotated[bool, Field(description="drives take TwistStamped instead of Twist")] = False
    patience: Annotated[DurationNs, Field(gt=0, description="time limit of waiting for ROS")] = 10 * NS_PER_S
    body: Annotated[
        str | None,
        Field(description="the backend that simulates the body in a process of its own, behind ROS 2"),
    ] = None
    body_options: Annotated[
        dict[str, Any], Field(default_factory=dict, description="the options of that backend")
    ]

    bag: Annotated[
        Annotated[Path, BeforeValidator(_existing)] | None,
        Field(description="the messages of this file or folder arrive, instead of those of ROS"),
    ] = None

    @model_validator(mode="before")
    @classmethod
    def _suits_a_body_of_ours(cls, given: Any) -> Any:
        """Set the defaults of a simulated body: ROS 2 and lockstep."""
        if isinstance(given, dict) and given.get("body") is not None:
            return {"ros": Ros.TWO, "time": TimeSource.LOCKSTEP, **given}
        return given

    @model_validator(mode="after")
    def _agrees_with_itself(self) -> Self:
        others = ", ".join(f"'{name}'" for name in self.model_fields_set - {"bag", "timestep"})
        if self.bag is not None and others:
            raise ValueError(f"a bag does not use ROS: remove {others}")
        if self.domain is not None and self.ros is Ros.ONE:
            raise ValueError("only ROS 2 has domains: add 'ros: 2'")
        if self.body is None:
            if self.body_options:
                raise ValueError("'body_options' are for a simulated body: add 'body'")
            return self
        if (self.ros, self.time) != (Ros.TWO, TimeSource.LOCKSTEP):
            raise ValueError("a simulated body always uses ROS 2 in lockstep: remove 'ros' and 'time'")
        if "timestep" in self.model_fields_set:
            raise ValueError("set the step of a simulated body in 'body_options'")
        try:
            Simulator.named(self.body, self.body_options)
        except BackendError as error:  # wrong options are reported unchanged
            raise ValueError(str(error)) from None
        return self
