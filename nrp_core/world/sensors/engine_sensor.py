"""Sensors that elements for one engine describe, such as those of MJCF, as messages of ROS."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from operator import attrgetter
from typing import Any, ClassVar

from nrp_core._support.arrays import FloatArray
from nrp_core.findings import Code
from nrp_core.messages.base import resolve_name
from nrp_core.messages.generated import required
from nrp_core.scene.consistency import WORLD
from nrp_core.scene.model import Model
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.reading.plugins import ModelParts
from nrp_core.world.engine import Engine
from nrp_core.world.sensors.sensor import Sensor, SensorPart

USUAL_RATE_HZ = 100.0
"""Of sensors whose file does not say how often they measure."""
_INFRARED = 1
"""``INFRARED`` of ``sensor_msgs/Range``: one ray."""


@dataclass(frozen=True, slots=True)
class Form:
    """A message, and its fields by the kinds of sensors of MJCF that are in it."""

    message: str
    fields: dict[str, str]


_VECTORS = ("ballangvel", "framexaxis", "frameyaxis", "framezaxis", "subtreelinvel", "subtreeangmom")
_NUMBERS = ("touch", "jointpos", "jointvel", "jointactuatorfrc", "jointlimitpos", "jointlimitvel",
            "jointlimitfrc", "tendonpos", "tendonvel", "tendonactuatorfrc", "tendonlimitpos",
            "tendonlimitvel", "tendonlimitfrc", "actuatorpos", "actuatorvel", "actuatorfrc", "clock",
            "e_potential", "e_kinetic")  # fmt: skip
FORMS = {
    "imu": Form("sensor_msgs/msg/Imu",
                {"accelerometer": "linear_acceleration", "gyro": "angular_velocity"}),
    "wrench": Form("geometry_msgs/msg/WrenchStamped", {"force": "wrench.force", "torque": "wrench.torque"}),
    "pose": Form("geometry_msgs/msg/PoseStamped",
                 {"framepos": "pose.position", "framequat": "pose.orientation"}),
    "twist": Form("geometry_msgs/msg/TwistStamped",
                  {"framelinvel": "twist.linear", "frameangvel": "twist.angular"}),
    "accel": Form("geometry_msgs/msg/AccelStamped",
                  {"framelinacc": "accel.linear", "frameangacc": "accel.angular"}),
    "velocity": Form("geometry_msgs/msg/TwistStamped", {"velocimeter": "twist.linear"}),
    "magnetic_field": Form("sensor_msgs/msg/MagneticField", {"magnetometer": "magnetic_field"}),
    "range": Form("sensor_msgs/msg/Range", {"rangefinder": "range"}),
    "point": Form("geometry_msgs/msg/PointStamped", {"subtreecom": "point"}),
    "orientation": Form("geometry_msgs/msg/QuaternionStamped", {"ballquat": "quaternion"}),
    "vector": Form("geometry_msgs/msg/Vector3Stamped", dict.fromkeys(_VECTORS, "vector")),
    "number": Form("std_msgs/msg/Float64", dict.fromkeys(_NUMBERS, "data")),
}  # fmt: skip
"""The messages by their names in files."""


@dataclass(frozen=True, slots=True)
class EngineSensor(Sensor):
    """One or more sensors of an engine with a common message.

    Args:
        form: the message, one of :data:`FORMS`.
        sources: the sensors of the engine: their kind in MJCF, and their name.
        unit: of a single number.
        max_range: of a ray, m.
    """

    tag: ClassVar[str] = "engine_sensor"
    needs: ClassVar[tuple[str, ...]] = ("own_actuators",)

    form: str = "number"
    sources: tuple[tuple[str, str], ...] = ()
    unit: str = ""
    max_range: float = inf

    @classmethod
    def read_plugin(cls, plugin: Element, model: ModelParts, reading: Reading) -> tuple[str, EngineSensor]:
        """Read the ``<plugin filename="nrp_engine_sensor">`` of a model.

        It has ``<link>``, ``<topic>``, ``<message>``, one of :data:`FORMS`, and an element with the name of
        each sensor of the engine, whose tag is its kind in MJCF. ``<frame>`` is that of the message in its
        model, by default the world's; ``<update_rate>`` (Hz), ``<unit>`` and ``<max_range>`` are optional.

        Raises:
            SceneError: the link does not exist, or a kind is not in such a message.
        """
        form = plugin.choice("message", tuple(FORMS), "number")
        sources = tuple((kind, each.text) for kind in FORMS[form].fields for each in plugin.all(kind))
        if not sources:
            raise plugin.error(f"it names no sensor for a '{form}': {', '.join(FORMS[form].fields)}")
        topic = resolve_name(plugin.require("topic").text, reading.robot)
        found = cls(
            plugin.attribute("name"),
            topic,
            plugin.positive("update_rate", USUAL_RATE_HZ),
            form,
            sources,
            plugin.word("unit", ""),
            plugin.positive("max_range", inf),
            frame_name=plugin.word("frame", ""),
        )
        return model.link(plugin.require("link")).name, found

    def frame_on(self, model: str, link: str) -> str:
        return f"{model}/{self.frame_name}" if self.frame_name else WORLD

    def part(self, model: Model, link: str, engine: Engine) -> EngineSensorPart:
        return EngineSensorPart(self, model.name, link, engine)


class EngineSensorPart(SensorPart):
    """Publishes the sensors of one message; an engine without them has no topic, which is reported."""

    def __init__(self, sensor: EngineSensor, model: str, link: str, engine: Engine) -> None:
        super().__init__(sensor, model, link, engine)
        self._sensor, form = sensor, FORMS[sensor.form]
        self._message = required(form.message)
        self._fields = [(name, form.fields[kind]) for kind, name in sensor.sources]
        kinds = [kind for kind, _ in sensor.sources]
        self._unknown = [f"{form.fields[kind]}_covariance" for kind in form.fields if kind not in kinds]
        if engine.capabilities.own_actuators:
            served = self._served(sensor.topic, self._message, f"{' and '.join(kinds)} of {model}")
            self.topics = (replace(served, unit=sensor.unit),)
        else:
            message = f"{engine.title} does not have the sensor '{sensor.name}' of '{model}'"
            engine.warnings.add(Code.NRP260, message, subject=sensor.name)

    def read(self, topic: str, now_ns: int) -> Any:
        message = self._message()
        if hasattr(message, "header"):
            message.header = self._header(now_ns)
        for name, path in self._fields:
            values = self._engine.sensor_values(self._place[0], name)
            _put(message, path, self._measured(topic, now_ns, values))
        if self._sensor.form == "range":
            message.radiation_type, message.max_range = _INFRARED, self._sensor.max_range
            message.range = message.range if message.range >= 0 else inf  # REP 117: nothing is hit
        if self._sensor.form == "imu":  # unmeasured values are marked as in ROS
            for field in ("orientation_covariance", *self._unknown):
                getattr(message, field)[0] = -1.0
        return message


def _put(message: Any, path: str, values: FloatArray) -> None:
    """Set a number, a vector or a quaternion, which begins with w, in a message."""
    holder, _, field = path.rpartition(".")
    target = attrgetter(holder)(message) if holder else message
    if len(values) == 1:
        setattr(target, field, float(values[0]))
        return
    for axis, value in zip("xyz" if len(values) == 3 else "wxyz", values.tolist(), strict=True):
        setattr(getattr(target, field), axis, value)
