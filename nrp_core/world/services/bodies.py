"""Requests about bodies and joints: states, commands and forces."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrp_core.errors import SceneError
from nrp_core.messages import gazebo_srvs as srv
from nrp_core.messages.base import Time, ns_of
from nrp_core.messages.gazebo_msgs import LinkState
from nrp_core.messages.std_msgs import Header
from nrp_core.scene.model import Model
from nrp_core.scene.rigid import ModelMotion, Pose, Wrench
from nrp_core.scene.scoped_names import find_joint, find_link
from nrp_core.world.forces import Push
from nrp_core.world.model_states import pose_of, relative_motion, state_messages, vector_of, world_motion
from nrp_core.world.service import PREFIX, Service
from nrp_core.world.world import World

_WORLD = ("", "world", "map", "/world", "/map")


def body_services(world: World) -> list[Service]:
    """Return the services of :class:`BodyRequests`."""
    bodies = BodyRequests(world)
    return [
        Service(PREFIX + "get_model_state", srv.GetModelStateRequest, bodies.model_state),
        Service(PREFIX + "set_model_state", srv.SetModelStateRequest, bodies.set_model_state),
        Service(PREFIX + "get_link_state", srv.GetLinkStateRequest, bodies.link_state),
        Service(PREFIX + "set_link_state", srv.SetLinkStateRequest, bodies.set_link_state),
        Service(PREFIX + "get_joint_properties", srv.GetJointPropertiesRequest, bodies.joint_properties),
        Service(
            PREFIX + "set_model_configuration", srv.SetModelConfigurationRequest, bodies.set_configuration
        ),
        Service(PREFIX + "apply_body_wrench", srv.ApplyBodyWrenchRequest, bodies.apply_wrench),
        Service(PREFIX + "clear_body_wrenches", srv.BodyRequestRequest, bodies.clear_wrenches),
        Service(PREFIX + "apply_joint_effort", srv.ApplyJointEffortRequest, bodies.apply_effort),
        Service(PREFIX + "clear_joint_forces", srv.JointRequestRequest, bodies.clear_efforts),
    ]


class BodyRequests:
    """Answers requests about bodies and joints.

    Args:
        world: the world.
    """

    def __init__(self, world: World) -> None:
        self._world = world

    def model_state(self, request: srv.GetModelStateRequest) -> srv.GetModelStateResponse:
        """Return the state of a model."""
        model = self._world.scene.model(request.model_name)
        motion = self._relative_motion(self._motion(model), request.relative_entity_name)
        header = Header(Time.from_ns(self._world.now_ns), request.relative_entity_name)
        return srv.GetModelStateResponse(header, *state_messages(motion))

    def set_model_state(self, request: srv.SetModelStateRequest) -> srv.SetModelStateResponse:
        """Set the state of a model."""
        state = request.model_state
        self._world.place(state.model_name, self._world_motion_of(state))
        return srv.SetModelStateResponse()

    def link_state(self, request: srv.GetLinkStateRequest) -> srv.GetLinkStateResponse:
        """Return the state of a link."""
        motion = self._relative_motion(self._link_motion(request.link_name), request.reference_frame)
        state = LinkState(request.link_name, *state_messages(motion), request.reference_frame)
        return srv.GetLinkStateResponse(state)

    def set_link_state(self, request: srv.SetLinkStateRequest) -> srv.SetLinkStateResponse:
        """Set the state of the base link of a model; the others follow."""
        state = request.link_state
        model, link = self._link(state.link_name)
        base = model.links[0]
        if link != base.name:
            raise SceneError(
                f"only the base link '{base.name}' of '{model.name}' can be placed, not '{link}'"
            )
        self._world.place(model.name, self._world_motion_of(state).at(base.pose.inverse()))
        return srv.SetLinkStateResponse()

    def joint_properties(self, request: srv.GetJointPropertiesRequest) -> srv.GetJointPropertiesResponse:
        """Return the properties and the state of a joint."""
        model, joint = self._joint(request.joint_name)
        joints = self._world.engine.joint_states(model)
        index = joints.names.index(joint)
        position, rate = float(joints.positions[index]), float(joints.velocities[index])
        found = next(each for each in self._world.scene.model(model).joints if joint in each.coordinates)
        kind = getattr(srv.GetJointPropertiesResponse, found.kind.upper())
        return srv.GetJointPropertiesResponse(kind, [found.damping], [position], [rate])

    def set_configuration(
        self, request: srv.SetModelConfigurationRequest
    ) -> srv.SetModelConfigurationResponse:
        """Set the positions of joints."""
        names, positions = request.joint_names, request.joint_positions
        if len(names) != len(positions):
            raise SceneError(f"{len(names)} joints need {len(names)} positions, not {len(positions)}")
        models = [self._world.scene.model(request.model_name)]
        joints = [find_joint(models, name)[1] for name in names]
        self._world.set_joints(request.model_name, dict(zip(joints, map(float, positions), strict=True)))
        return srv.SetModelConfigurationResponse()

    def apply_wrench(self, request: srv.ApplyBodyWrenchRequest) -> srv.ApplyBodyWrenchResponse:
        """Apply a wrench to a link at one of its points; it keeps its direction in the world."""
        model, link = self._link(request.body_name)
        here = self._world.engine.link_motion(model.name, link).pose
        reference = request.reference_frame
        frame = ModelMotion(Pose()) if reference in _WORLD else self._reference(reference)
        force = frame.pose.rotate(vector_of(request.wrench.force))
        torque = frame.pose.rotate(vector_of(request.wrench.torque))
        inertial = model.link(link).inertial
        centre = (here @ inertial.pose).position if inertial else here.position
        # in Gazebo the point is relative to the link if the world is the frame of reference
        origin = here.position if reference in _WORLD else frame.pose.position
        offset = frame.pose.rotate(vector_of(request.reference_point))
        lever = np.add(origin, offset) - centre if any(offset) else np.zeros(3)
        x, y, z = (np.cross(lever, force) + torque).tolist()
        self._push(model.name, link, Wrench(force, (x, y, z)), request)
        return srv.ApplyBodyWrenchResponse()

    def clear_wrenches(self, request: srv.BodyRequestRequest) -> srv.BodyRequestResponse:
        """End all wrenches on a link."""
        model, link = self._link(request.body_name)
        self._world.forces.clear(model.name, link, Wrench, self._world.now_ns)
        return srv.BodyRequestResponse()

    def apply_effort(self, request: srv.ApplyJointEffortRequest) -> srv.ApplyJointEffortResponse:
        """Apply an effort to a joint."""
        self._push(*self._joint(request.joint_name), float(request.effort), request)
        return srv.ApplyJointEffortResponse()

    def clear_efforts(self, request: srv.JointRequestRequest) -> srv.JointRequestResponse:
        """End all efforts on a joint."""
        self._world.forces.clear(*self._joint(request.joint_name), float, self._world.now_ns)
        return srv.JointRequestResponse()

    # -- names

    def _link(self, name: str) -> tuple[Model, str]:
        return find_link(self._world.scene.models, name)

    def _joint(self, name: str) -> tuple[str, str]:
        model, joint = find_joint(self._world.scene.models, name)
        return model.name, joint

    # -- motions

    def _motion(self, model: Model) -> ModelMotion:
        return ModelMotion(model.pose) if model.static else self._world.engine.model_motion(model.name)

    def _link_motion(self, link: str) -> ModelMotion:
        model, name = self._link(link)
        if model.static:
            return ModelMotion(model.pose @ model.link(name).pose)
        return self._world.engine.link_motion(model.name, name)

    def _reference(self, name: str) -> ModelMotion:
        """Return the motion of a frame of reference: a model or a link."""
        names = [model.name for model in self._world.scene.models]
        return self._motion(self._world.scene.model(name)) if name in names else self._link_motion(name)

    def _relative_motion(self, motion: ModelMotion, reference: str) -> ModelMotion:
        return motion if reference in _WORLD else relative_motion(self._reference(reference), motion)

    def _world_motion_of(self, state: Any) -> ModelMotion:
        """Return the motion in the world for a model's or link's state."""
        twist = state.twist
        motion = ModelMotion(pose_of(state.pose), vector_of(twist.linear), vector_of(twist.angular))
        reference = state.reference_frame
        return motion if reference in _WORLD else world_motion(self._reference(reference), motion)

    def _push(self, model: str, name: str, load: Wrench | float, request: Any) -> None:
        now_ns = self._world.now_ns
        start_ns = max(now_ns, ns_of(request.start_time))
        lasts_ns = ns_of(request.duration)
        end_ns = None if lasts_ns < 0 else start_ns + lasts_ns
        if end_ns == start_ns:
            raise SceneError(
                f"a force on '{name}' that lasts 0 s has no effect: give it a 'duration', or -1 s for ever"
            )
        if end_ns is None or end_ns > start_ns:
            self._world.forces.add(Push(model, name, load, start_ns, end_ns), now_ns)
