"""Requests about the settings of physics."""

from __future__ import annotations

from math import isclose

from nrp_core.clock import seconds
from nrp_core.errors import TimestepError
from nrp_core.world.live import LiveScene
from nrp_core.world.messages import gazebo_srvs as srv
from nrp_core.world.messages.geometry_msgs import Vector3
from nrp_core.world.pose_messages import vector_of
from nrp_core.world.services.service import PREFIX, Service


def physics_services(live: LiveScene) -> list[Service]:
    """Return the services of :class:`PhysicsRequests`."""
    physics = PhysicsRequests(live)
    return [
        Service(PREFIX + "get_physics_properties", srv.GetPhysicsPropertiesRequest, physics.properties),
        Service(PREFIX + "set_physics_properties", srv.SetPhysicsPropertiesRequest, physics.set_properties),
    ]


class PhysicsRequests:
    """Answers requests about physics.

    Args:
        live: the current scene.
    """

    def __init__(self, live: LiveScene) -> None:
        self._live = live

    def properties(self, _request: srv.GetPhysicsPropertiesRequest) -> srv.GetPhysicsPropertiesResponse:
        """Return the physics step and gravity; for Gazebo's other settings, their defaults."""
        step_s, gravity = seconds(self._live.engine.step_ns), Vector3(*self._live.scene.gravity)
        return srv.GetPhysicsPropertiesResponse(step_s, self._live.paused, 1.0 / step_s, gravity)

    def set_properties(self, request: srv.SetPhysicsPropertiesRequest) -> srv.SetPhysicsPropertiesResponse:
        """Set gravity."""
        step_s, asked_s = seconds(self._live.engine.step_ns), float(request.time_step)
        if asked_s and not isclose(asked_s, step_s):
            raise TimestepError(
                f"the physics step is {step_s:g} s for the whole run and cannot be changed to {asked_s:g} s; "
                "set it with the option timestep of the experiment's world"
            )
        self._live.set_gravity(vector_of(request.gravity))
        return srv.SetPhysicsPropertiesResponse()
