"""Sensors that an experiment mounts on a robot."""

from __future__ import annotations

from typing import Any

from pydantic import ConfigDict, Field, JsonValue

from nrp_core.experiment.model.section import PoseList, Section
from nrp_core.quantities import RateHz
from nrp_core.world.rigid import Pose
from nrp_core.world.robot_setup import AddedSensor


class AddedSensorSection(Section):
    """A sensor on a link of a robot; further keys are the elements of SDF's ``<sensor>``."""

    model_config = ConfigDict(extra="allow")

    __pydantic_extra__: dict[str, JsonValue]

    type: str
    """Its type in SDF: ``camera``, ``lidar``, ``imu``, ``contact`` and so on."""
    link: str
    """The link that holds it; for a ``force_torque`` the joint that it measures."""
    name: str = ""
    """Unique on its link; by default its type."""
    pose: PoseList = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """On its link: x, y, z, roll, pitch, yaw."""
    rate: RateHz = Field(default=30.0, gt=0)
    """Messages per second."""

    @property
    def sensor(self) -> AddedSensor:
        """The same for a scene."""
        x, y, z, roll, pitch, yaw = self.pose
        pose = Pose.from_rpy((x, y, z), roll, pitch, yaw)
        settings: dict[str, Any] = dict(self.__pydantic_extra__ or {})
        return AddedSensor(self.type, self.link, self.name, pose, self.rate, settings)
