"""The services of Gazebo that tell and set how its physics computes."""

from __future__ import annotations

from typing import Any

from nrp_core.clock import seconds
from nrp_core.world.interface import World
from nrp_core.world.messages.geometry_msgs import Vector3
from nrp_legacy.shims.modules import OpenMessage

_ODE = {
    "auto_disable_bodies": False, "sor_pgs_precon_iters": 0, "sor_pgs_iters": 50, "sor_pgs_w": 1.3,
    "sor_pgs_rms_error_tol": 0.0, "contact_surface_layer": 0.001, "contact_max_correcting_vel": 100.0,
    "cfm": 0.0, "erp": 0.2, "max_contacts": 20,
}  # fmt: skip
"""What Gazebo's engine, which no world here has, is set to unless told otherwise."""
_SETTINGS = ("time_step", "max_update_rate", "gravity", "ode_config")
"""The fields of a request to set them, in their order."""


def physics_properties(world: World, *_values: Any, **_fields: Any) -> OpenMessage:
    """Return time step and gravity of a world, and for what else Gazebo tells its defaults."""
    step_s = seconds(world.capabilities.step_ns)
    return OpenMessage(
        time_step=step_s, pause=world.paused, max_update_rate=1.0 / step_s,
        gravity=Vector3(*world.scene.gravity), ode_config=OpenMessage(**_ODE),
        success=True, status_message="",
    )  # fmt: skip


def set_physics_properties(world: World, *values: Any, **fields: Any) -> OpenMessage:
    """Return whether a world computes as is asked: its time step and gravity stay as they are."""
    present = physics_properties(world)
    asked = {**dict(zip(_SETTINGS, values, strict=False)), **fields}
    wrong = [
        f"{name} stays {_numbers(getattr(present, name))} {unit}"
        for name, unit in (("time_step", "s"), ("gravity", "m/s^2"))
        if _numbers(asked.get(name, getattr(present, name))) != _numbers(getattr(present, name))
    ]
    if wrong:
        world.warnings.append(f"/gazebo/set_physics_properties: {', '.join(wrong)}")
    return OpenMessage(success=not wrong, status_message=", ".join(wrong))


def _numbers(value: Any) -> Any:
    """Return a number, or those of a vector, whose axes are 0 unless told."""
    if isinstance(value, OpenMessage):
        return tuple(float(vars(value).get(axis, 0.0)) for axis in "xyz")
    return (value.x, value.y, value.z) if isinstance(value, Vector3) else float(value)


SERVICES = {
    "/gazebo/get_physics_properties": physics_properties,
    "/gazebo/set_physics_properties": set_physics_properties,
}
"""What answers, by the names of the services."""
