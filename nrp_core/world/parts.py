"""Which parts a scene has."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from nrp_core.world.controllers.joint import ControllerPart
from nrp_core.world.controllers.trajectory import TrajectoryPart
from nrp_core.world.drives.drive import DrivePart
from nrp_core.world.drives.flight import FlightPart
from nrp_core.world.engine import Engine
from nrp_core.world.part import Part
from nrp_core.world.scene.acting import Flight
from nrp_core.world.scene.model import Camera, Model
from nrp_core.world.scene.sensing import ContactSensor, ForceTorque, GroundTruth, Imu, Laser
from nrp_core.world.sensors.camera import CameraPart
from nrp_core.world.sensors.contact import ContactPart
from nrp_core.world.sensors.force_torque import ForceTorquePart
from nrp_core.world.sensors.ground_truth import GroundTruthPart
from nrp_core.world.sensors.imu import ImuPart
from nrp_core.world.sensors.joint_states import JointStatesPart
from nrp_core.world.sensors.laser import LaserPart
from nrp_core.world.visuals import ColorPart

_SENSORS: dict[type, Callable[[Any, Model, str, Engine], Part]] = {
    Camera: lambda sensor, model, link, engine: CameraPart(sensor, model.name, link, engine),
    Laser: lambda sensor, model, link, engine: LaserPart(sensor, model.name, link, engine),
    Imu: lambda sensor, model, link, engine: ImuPart(sensor, model.name, link, engine),
    ContactSensor: lambda sensor, model, link, engine: ContactPart(sensor, model.name, link, engine),
    GroundTruth: lambda sensor, model, link, engine: GroundTruthPart(sensor, model.name, link, engine),
    ForceTorque: ForceTorquePart,
}


def parts_of(model: Model, engine: Engine) -> Iterator[Part]:
    """Return the parts that serve the topics of a model."""
    for link in model.links:
        for sensor in link.sensors:
            yield _SENSORS[type(sensor)](sensor, model, link.name, engine)
        for visual in link.visuals:
            yield ColorPart(f"{model.name}/{link.name}/{visual.name}", visual.rgba, visual.glows, engine)
    for drive in model.drives:
        yield (
            FlightPart(drive, model, engine) if isinstance(drive, Flight) else DrivePart(drive, model, engine)
        )
    yield from _controllers_of(model, engine)
    if model.joint_states_topic is not None:
        yield JointStatesPart(model, engine)


def _controllers_of(model: Model, engine: Engine) -> Iterator[Part]:
    """Yield those of single joints before those that lead them, so that integrals are added up first."""
    parts: dict[str, ControllerPart] = {}
    followers = model.trajectory_controllers
    names = [
        *(each.joint for each in model.controllers),
        *(name for each in followers for name in each.joints),
    ]
    for joint in dict.fromkeys(names):
        controllers = [each for each in model.controllers if each.joint == joint]
        led = [each.of_joint(joint) for each in followers if joint in each.joints]
        parts[joint] = ControllerPart(controllers, led, model, engine)
    yield from parts.values()
    for follower in followers:
        yield TrajectoryPart(follower, parts, model, engine)
