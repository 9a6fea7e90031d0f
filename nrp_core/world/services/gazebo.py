"""The services of Gazebo, ``/gazebo/...``, in any world: each a topic that takes its request, and a call.

:meth:`nrp_core.world.world.World.call` returns the answer; published on the topic of the same name, a
request is done all the same, so that events and recordings can ask, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any

from nrp_core.errors import NrpError, TopicError, did_you_mean
from nrp_core.world.live import LiveScene
from nrp_core.world.messages import base
from nrp_core.world.messages import gazebo_srvs as srv
from nrp_core.world.messages.base import type_name
from nrp_core.world.messages.std_srvs import EmptyRequest
from nrp_core.world.part import Part
from nrp_core.world.services.bodies import BodyRequests
from nrp_core.world.services.physics import PhysicsRequests
from nrp_core.world.services.scenes import SceneRequests
from nrp_core.world.topics import Direction, TopicInfo

PREFIX = "/gazebo/"
Answer = Callable[[Any], Any]


class Services(Part):
    """All services of a world.

    Args:
        live: the scene of now.
    """

    def __init__(self, live: LiveScene) -> None:
        self._live = live
        bodies, scenes, physics = BodyRequests(live), SceneRequests(live), PhysicsRequests(live)
        table: Mapping[str, tuple[type, Answer]] = {
            "get_model_state": (srv.GetModelStateRequest, bodies.model_state),
            "set_model_state": (srv.SetModelStateRequest, bodies.set_model_state),
            "get_link_state": (srv.GetLinkStateRequest, bodies.link_state),
            "set_link_state": (srv.SetLinkStateRequest, bodies.set_link_state),
            "get_joint_properties": (srv.GetJointPropertiesRequest, bodies.joint_properties),
            "set_model_configuration": (srv.SetModelConfigurationRequest, bodies.set_configuration),
            "apply_body_wrench": (srv.ApplyBodyWrenchRequest, bodies.apply_wrench),
            "clear_body_wrenches": (srv.BodyRequestRequest, bodies.clear_wrenches),
            "apply_joint_effort": (srv.ApplyJointEffortRequest, bodies.apply_effort),
            "clear_joint_forces": (srv.JointRequestRequest, bodies.clear_efforts),
            "get_model_properties": (srv.GetModelPropertiesRequest, scenes.model_properties),
            "get_world_properties": (srv.GetWorldPropertiesRequest, scenes.world_properties),
            "spawn_sdf_model": (srv.SpawnModelRequest, scenes.spawn),
            "spawn_urdf_model": (srv.SpawnModelRequest, scenes.spawn),
            "spawn_sdf_entity": (srv.SpawnModelRequest, scenes.spawn),
            "delete_model": (srv.DeleteModelRequest, scenes.delete),
            "set_visual_properties": (srv.SetVisualPropertiesRequest, scenes.set_visual),
            "get_lights_name": (srv.GetLightsNameRequest, scenes.light_names),
            "get_light_properties": (srv.GetLightPropertiesRequest, scenes.light),
            "set_light_properties": (srv.SetLightPropertiesRequest, scenes.set_light),
            "delete_light": (srv.DeleteLightRequest, scenes.delete_light),
            "get_physics_properties": (srv.GetPhysicsPropertiesRequest, physics.properties),
            "set_physics_properties": (srv.SetPhysicsPropertiesRequest, physics.set_properties),
            "pause_physics": (EmptyRequest, scenes.pause),
            "unpause_physics": (EmptyRequest, scenes.unpause),
            "reset_world": (EmptyRequest, scenes.reset_world),
            "reset_simulation": (EmptyRequest, scenes.reset_simulation),
        }
        self._table = {PREFIX + name: entry for name, entry in table.items()}
        self.topics = tuple(
            TopicInfo(name, kind, Direction.IN, what=f"service: {kind.__doc__}")
            for name, (kind, _) in self._table.items()
        )

    def write(self, topic: str, message: Any, now_ns: int) -> None:
        answer = self.answer(topic, message)
        if not getattr(answer, "success", True):
            self._live.warnings.append(f"{topic}: {answer.status_message}")

    def request(self, name: str, values: tuple[Any, ...], named: Mapping[str, Any]) -> Any:
        """Return the request that values and fields make.

        Raises:
            TopicError: there is no such service, or it has no such field.
        """
        if name not in self._table:
            raise TopicError(f"no service '{name}'{did_you_mean(name, self._table)}")
        kind = self._table[name][0]
        if len(values) == 1 and not named and type_name(type(values[0])) == type_name(kind):
            return values[0]
        try:
            return kind(*values, **named)
        except TypeError as error:
            raise TopicError(f"{name}: {error}".replace("__init__() ", "")) from None

    def answer(self, name: str, request: Any) -> Any:
        """Do what is asked and return the answer; what cannot be done is said there."""
        kind, answer = self._table[name]
        try:
            return answer(request)
        except NrpError as error:
            response = response_of(kind)
            if not fields(response):
                raise  # there is no room for a reason
            return response(success=False, status_message=getattr(error, "message", str(error)))


def response_of(request: type) -> type:
    """Return the class of the answers to requests of a class."""
    found = base.type_of(type_name(request).removesuffix("Request") + "Response")
    assert found is not None
    return found
