"""Inertial measurement units."""

from __future__ import annotations

from typing import Any

from nrp_core.world.engine import Engine
from nrp_core.world.messages.geometry_msgs import Quaternion, Vector3
from nrp_core.world.messages.sensor_msgs import Imu as ImuMessage
from nrp_core.world.rigid.motion import ModelMotion
from nrp_core.world.rigid.pose import Vector
from nrp_core.world.scene.sensing import Imu
from nrp_core.world.sensors.sensor import SensorPart


class ImuPart(SensorPart):
    """Serves one inertial sensor.

    An accelerometer measures how its velocity changes against free fall; here over the last physics step, in
    every engine alike. Right after the start, and after its model was put elsewhere, it feels gravity alone.
    """

    foresees = True

    def __init__(self, imu: Imu, model: str, link: str, engine: Engine) -> None:
        super().__init__(imu, model, link, engine)
        self._imu = imu
        self._before: tuple[int, Vector] | None = None
        self.topics = (self._served(imu.topic, ImuMessage, f"inertial sensor {imu.name}"),)

    def foresee(self, topic: str, now_ns: int) -> None:
        self._before = now_ns, self._motion().linear

    def read(self, topic: str, now_ns: int) -> ImuMessage:
        motion = self._motion()
        to_sensor = motion.pose.inverse()
        felt = [
            a - g for a, g in zip(self._acceleration(motion, now_ns), self._engine.scene.gravity, strict=True)
        ]
        acceleration = to_sensor.rotate((felt[0], felt[1], felt[2]))
        turning, feeling = self._noisy(topic, now_ns, to_sensor.rotate(motion.angular), acceleration)
        message = ImuMessage(self._header(now_ns), Quaternion(*motion.pose.orientation))
        message.angular_velocity, message.linear_acceleration = Vector3(*turning), Vector3(*feeling)
        return message

    def reset(self) -> None:
        self._before = None

    def save(self) -> object:
        return self._before

    def restore(self, saved: Any) -> None:
        self._before = saved

    def _motion(self) -> ModelMotion:
        return self._engine.link_motion(*self._place).at(self._imu.pose)

    def _acceleration(self, motion: ModelMotion, now_ns: int) -> Vector:
        if self._before is None or self._before[0] >= now_ns:
            return 0.0, 0.0, 0.0
        before_ns, velocity = self._before
        dt = (now_ns - before_ns) * 1e-9
        x, y, z = ((now - then) / dt for now, then in zip(motion.linear, velocity, strict=True))
        return x, y, z
