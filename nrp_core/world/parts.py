"""Which parts a scene has."""

from __future__ import annotations

from collections.abc import Iterator

from nrp_core.errors import SceneError
from nrp_core.world.controllers.joint import ControllerPart
from nrp_core.world.controllers.trajectory import TrajectoryPart
from nrp_core.world.drives.drive import Drive
from nrp_core.world.engine import Engine
from nrp_core.world.part import Part
from nrp_core.world.scene.model import Model
from nrp_core.world.sensors.joint_states import JointStatesPart
from nrp_core.world.sensors.sensor import Sensor
from nrp_core.world.visuals import ColorPart


def parts_of(model: Model, engine: Engine) -> Iterator[Part]:
    """Return the parts that serve the topics of a model."""
    for link in model.links:
        for sensor in link.sensors:
            if not isinstance(sensor, Sensor):
                raise _unserved(f"sensor '{sensor.name}' of '{model.name}/{link.name}'", sensor, Sensor)
            yield sensor.part(model, link.name, engine)
        for visual in link.visuals:
            yield ColorPart(f"{model.name}/{link.name}/{visual.name}", visual.rgba, visual.glows, engine)
    for drive in model.drives:
        if not isinstance(drive, Drive):
            raise _unserved(f"drive '{drive.name}' of '{model.name}'", drive, Drive)
        yield drive.part(model, engine)
    yield from _controllers_of(model, engine)
    if model.joint_states_topic is not None:
        yield JointStatesPart(model, engine)


def _unserved(owner: str, data: object, base: type) -> SceneError:
    kind = type(data).__name__
    return SceneError(f"the {owner} is a {kind}, which is not a subclass of {base.__name__}")


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
