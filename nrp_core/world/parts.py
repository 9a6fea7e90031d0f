"""Which parts a scene has."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.errors import SceneError
from nrp_core.world.controllers.joint import ControllerPart
from nrp_core.world.controllers.trajectory import TrajectoryPart
from nrp_core.world.drives.drive import DrivePart
from nrp_core.world.drives.flight import FlightPart
from nrp_core.world.engine import Engine
from nrp_core.world.part import Part
from nrp_core.world.scene.acting import Flight
from nrp_core.world.scene.model import Link, Model
from nrp_core.world.scene.sensing import MountedSensor
from nrp_core.world.sensors.joint_states import JointStatesPart
from nrp_core.world.sensors.sensor import Sensor
from nrp_core.world.visuals import ColorPart


def parts_of(model: Model, engine: Engine) -> Iterator[Part]:
    """Return the parts that serve the topics of a model."""
    for link in model.links:
        for sensor in link.sensors:
            yield _serving(sensor, model, link, engine)
        for visual in link.visuals:
            yield ColorPart(f"{model.name}/{link.name}/{visual.name}", visual.rgba, visual.glows, engine)
    for drive in model.drives:
        yield (
            FlightPart(drive, model, engine) if isinstance(drive, Flight) else DrivePart(drive, model, engine)
        )
    yield from _controllers_of(model, engine)
    if model.joint_states_topic is not None:
        yield JointStatesPart(model, engine)


def _serving(sensor: MountedSensor, model: Model, link: Link, engine: Engine) -> Part:
    if not isinstance(sensor, Sensor):
        owner = f"'{sensor.name}' of '{model.name}/{link.name}'"
        raise SceneError(
            f"the sensor {owner} is a {type(sensor).__name__}, which is not a subclass of Sensor"
        )
    return sensor.part(model, link.name, engine)


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
