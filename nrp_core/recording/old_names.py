"""Names in recordings of earlier versions that have changed since."""

from __future__ import annotations

import pickle
from io import BytesIO
from typing import Any, Final

MOVED: Final[dict[str, str]] = {
    "nrp_core.world.drives.actuator": "nrp_core.world.drives.drive",
    "nrp_core.world.drives.planar_move": "nrp_core.world.drives.mecanum",
    "nrp_core.world.rigid.motion": "nrp_core.scene.rigid",
    "nrp_core.world.rigid.pose": "nrp_core.scene.rigid",
    "nrp_core.world.scene.acting": "nrp_core.scene.devices",
    "nrp_core.world.scene.finish": "nrp_core.scene.model",
    "nrp_core.world.scene.sensing": "nrp_core.scene.devices",
    "nrp_core.world.sensors.air_pressure": "nrp_core.world.sensors.navigation",
    "nrp_core.world.sensors.altimeter": "nrp_core.world.sensors.navigation",
    "nrp_core.world.sensors.force_torque": "nrp_core.world.sensors.contact",
    "nrp_core.world.sensors.imperfect": "nrp_core.world.sensors.sensor",
    "nrp_core.world.sensors.imu": "nrp_core.world.sensors.navigation",
    "nrp_core.world.sensors.logical_camera": "nrp_core.world.sensors.ground_truth",
    "nrp_core.world.sensors.magnetometer": "nrp_core.world.sensors.navigation",
    "nrp_core.world.sensors.navsat": "nrp_core.world.sensors.navigation",
    "nrp_core.world.sensors.retina": "nrp_core.world.sensors.event_camera",
    "nrp_core.world.sensors.segmentation": "nrp_core.world.sensors.camera",
    "nrp_core.world.sensors.sonar": "nrp_core.world.sensors.laser",
}
"""Old and new dotted names of modules, and of classes that changed their names or left their modules.

Only of classes that calls from outside pickle: messages, models and their parts, motions, lights, sensors
and drives.
"""


_PACKAGES: Final[dict[str, str]] = {
    "nrp_core.brain.changes": "nrp_core.network.changes",
    "nrp_core.brain.network": "nrp_core.network",
    "nrp_core.world.messages": "nrp_core.messages",
    "nrp_core.world.rigid": "nrp_core.scene.rigid",
    "nrp_core.world.scene": "nrp_core.scene",
}
"""Packages that moved with all of their modules, and single modules; applied after the others."""

WORLD_RESET: Final = "world_reset"
"""The recorded name of a reset of the world; ``reset`` is that of the run."""

RESETS: Final[dict[str, tuple[str, tuple[str, ...]]]] = {
    WORLD_RESET: ("reset", ()),
    "return_home": ("reset", ("poses",)),
    "repaint": ("reset", ("colors",)),
    "start_over": ("reset", ("state",)),
}
"""Recorded names of resets of a world, also of earlier versions: the method, and its first arguments."""


def loads(data: bytes) -> Any:
    """Return the object in a pickle of this or an earlier version.

    Args:
        data: the pickle; like the recorded experiment, it can run any code.
    """
    return _Unpickler(BytesIO(data)).load()


class _Unpickler(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> Any:
        full_name = f"{MOVED.get(module, module)}.{name}"
        module, _, name = MOVED.get(f"{module}.{name}", full_name).rpartition(".")
        old = next((old for old in _PACKAGES if f"{module}.".startswith(f"{old}.")), "")
        return super().find_class(_PACKAGES.get(old, "") + module[len(old) :], name)
