"""Worlds with one bug each in what belongs to each body, joint and camera; all are MuJoCo but for the bug."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
from nrp_world_mujoco.engine import MujocoEngine
from one_bug import ChangesTheScene, Opens, with_links, with_sensors
from registry import Found, register

from nrp_core.scene.model import Capsule, Cylinder, Joint, Link, Scene
from nrp_core.scene.rigid import (
    BodyPath,
    BodyVelocity,
    JointStates,
    ModelMotion,
    Pose,
    Quaternion,
    Touch,
    Wrench,
    rotation_by,
)

FOUND_BY: Found = {}
found_by = register(FOUND_BY, Opens, "world")


def _with_joints(scene: Scene, change: Callable[[Joint], Joint]) -> Scene:
    models = (replace(m, joints=tuple(map(change, m.joints))) for m in scene.models)
    return replace(scene, models=tuple(models))


def _with_shapes(scene: Scene, change: Callable[[Any], Any]) -> Scene:
    def changed(link: Link) -> Link:
        return replace(link, collisions=tuple(map(change, link.collisions)))

    return with_links(scene, changed)


def _w_first(pose: Pose) -> Pose:
    x, y, z, w = pose.orientation
    return Pose(pose.position, (w, x, y, z))


@found_by(
    "a_sliding_joint_is_held_by_its_friction",
    "a_sliding_body_is_slowed_by_the_friction_of_its_shape",
)
class KnowsOneFriction(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return _with_shapes(scene, lambda shape: replace(shape, friction=1.0))


@found_by(
    "a_shape_has_its_size_and_place",
)
class PutsShapesIntoTheMiddleOfTheirLink(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return _with_shapes(
            scene, lambda shape: replace(shape, pose=Pose((0.0, 0.0, 0.0), shape.pose.orientation))
        )


@found_by(
    "a_robot_in_a_corner_is_inside_neither_wall",
    "a_shape_has_its_exact_size",
    "a_shape_has_its_size_and_place",
)
class TakesLengthsForHalfLengths(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        def halved(shape: Any) -> Any:
            geometry = shape.geometry
            if not isinstance(geometry, Cylinder | Capsule):
                return shape
            return replace(shape, geometry=replace(geometry, length=geometry.length / 2))

        return _with_shapes(scene, halved)


@found_by(
    "a_shape_has_its_exact_size",
    "a_shape_has_its_size_and_place",
)
class CutsTheEndsOffCapsules(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        def cut(shape: Any) -> Any:
            geometry = shape.geometry
            if not isinstance(geometry, Capsule):
                return shape
            return replace(shape, geometry=Cylinder(geometry.radius, geometry.length))

        return _with_shapes(scene, cut)


@found_by(
    "a_torque_turns_by_the_moment_about_its_axis_of_the_world",
    "inertia_has_its_principal_axes_where_the_file_puts_them",
)
class TurnsEveryBodyAsIfItWereASphere(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        def round_(link: Link) -> Link:
            if link.inertial is None:
                return link
            mean = sum(link.inertial.inertia[:3]) / 3
            return replace(link, inertial=replace(link.inertial, inertia=(mean, mean, mean, 0.0, 0.0, 0.0)))

        return with_links(scene, round_)


@found_by(
    "a_joint_is_slowed_by_its_damping",
)
class DampsNoJoint(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return _with_joints(scene, lambda joint: replace(joint, damping=0.0))


@found_by(
    "a_joint_stops_at_its_lower_limit",
    "a_joint_stops_at_its_limit",
)
class KnowsUpperLimitsOnly(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return _with_joints(scene, lambda joint: replace(joint, lower=-3.0) if joint.lower > -inf else joint)


@found_by(
    "a_joint_limits_the_effort_of_commands",
    "a_servo_obeys_the_effort_limit_of_its_joint",
)
class KnowsNoLimitOfEffort(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return _with_joints(scene, lambda joint: replace(joint, effort=inf))


@found_by(
    "an_axis_is_given_in_the_frame_of_its_joint",
)
class TakesAxesInTheFrameOfTheModel(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return _with_joints(scene, lambda joint: replace(joint, pose=Pose(joint.pose.position)))


@found_by(
    "a_camera_has_its_pose_in_its_link",
)
class PutsCamerasIntoTheMiddleOfTheirLink(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return with_sensors(
            scene, lambda camera: replace(camera, pose=Pose((0.0, 0.0, 0.0), camera.pose.orientation))
        )


@found_by(
    "a_visual_has_its_pose_in_its_link",
)
class DoesNotTurnVisuals(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        def straight(link: Link) -> Link:
            return replace(link, visuals=tuple(replace(v, pose=Pose(v.pose.position)) for v in link.visuals))

        return with_links(scene, straight)


@found_by(
    "a_reset_restores_the_first_scene",
    "a_spawned_robot_drives_and_sees",
)
class SpawnsWithWFirst(MujocoEngine):
    known: frozenset[str] = frozenset()

    def _open(self, scene: Scene, built: Any) -> None:
        if self.known:
            models = (m if m.name in self.known else replace(m, pose=_w_first(m.pose)) for m in scene.models)
            scene = replace(scene, models=tuple(models))
        self.known = frozenset(model.name for model in scene.models)
        super()._open(scene, built)


@found_by(
    "an_imu_measures_gravity_at_rest_and_nothing_in_free_fall",
    "the_load_on_a_joint_is_the_weight_below_it_or_is_refused",
    "link_poses_are_reported_or_refused",
)
class TellsLinksWithWFirst(MujocoEngine):
    def _do_link_motion(self, model: str, link: str) -> ModelMotion:
        motion = super()._do_link_motion(model, link)
        return replace(motion, pose=_w_first(motion.pose))


@found_by(
    "a_link_turns_about_axes_of_the_world",
)
class ReportsTurnsOfLinksAlongTheirOwnAxes(MujocoEngine):
    def _do_link_motion(self, model: str, link: str) -> ModelMotion:
        motion = super()._do_link_motion(model, link)
        return replace(motion, angular=motion.pose.inverse().rotate(motion.angular))


@found_by(
    "models_can_be_moved_or_that_is_refused",
)
class PlacesWithoutTurning(MujocoEngine):
    def _do_place(self, model: str, motion: ModelMotion) -> None:
        orientation = self._do_model_motion(model).pose.orientation
        super()._do_place(model, replace(motion, pose=Pose(motion.pose.position, orientation)))


@found_by(
    "several_robots_each_follow_their_own_commands",
)
class TellsTheJointsOfTheFirstRobot(MujocoEngine):
    def _do_joint_states(self, model: str) -> JointStates:
        mine = self._built.joints[model].keys()
        alike = (m.name for m in self.scene.models if self._built.joints.get(m.name, {}).keys() == mine)
        return super()._do_joint_states(next(alike))


@found_by(
    "a_ball_joint_follows_orientations",
    "an_effort_accelerates_a_joint",
)
class TellsNoEfforts(MujocoEngine):
    def _do_joint_states(self, model: str) -> JointStates:
        states = super()._do_joint_states(model)
        return replace(states, efforts=np.zeros_like(states.efforts))


@found_by(
    "a_torque_turns_by_the_moment_about_its_axis_of_the_world",
    "inertia_has_its_principal_axes_where_the_file_puts_them",
)
class PushesWithoutTurning(MujocoEngine):
    def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        super()._do_set_wrench(body, Wrench(wrench.force))


@found_by(
    "a_snapshot_keeps_forces_and_targets",
    "a_torque_turns_by_the_moment_about_its_axis_of_the_world",
)
class PushesAlongTheAxesOfTheBody(MujocoEngine):
    def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        pose = self._do_model_motion(body[0]).pose
        super()._do_set_wrench(body, Wrench(pose.rotate(wrench.force), pose.rotate(wrench.torque)))


@found_by(
    "a_planar_drive_can_move_sideways",
    "a_planar_drive_moves_exactly_as_commanded",
)
class SlidesToTheWrongSide(MujocoEngine):
    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        super()._do_set_drive(model, drive, replace(velocity, left=-velocity.left))


@found_by(
    "contacts_report_the_weight_or_are_refused",
)
class TouchesAtTheOrigin(MujocoEngine):
    def _do_touches(self) -> Sequence[Touch]:
        return [replace(touch, position=(0.0, 0.0, 0.0)) for touch in super()._do_touches()]


@found_by(
    "a_light_link_between_two_joints_lets_its_child_turn_about_both",
)
class GivesEveryLinkSomeWeight(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        def heavier(link: Link) -> Link:
            if link.inertial is None or link.inertial.mass > 1e-3:
                return link
            return replace(link, inertial=replace(link.inertial, mass=0.1, inertia=(1.0,) * 3 + (0.0,) * 3))

        return with_links(scene, heavier)


@found_by("a_ball_joint_follows_orientations")
class LeadsBallJointsBackwards(MujocoEngine):
    def _do_set_ball_target(self, model: str, joint: str, orientation: Quaternion | None) -> None:
        x, y, z, w = orientation or (0.0, 0.0, 0.0, 1.0)
        super()._do_set_ball_target(model, joint, (-x, -y, -z, w))


@found_by(
    "a_ball_joint_follows_orientations",
    "a_ball_joint_turns_about_any_axis",
    "undeclared_ball_joints_are_refused",
    "the_turn_rate_of_a_ball_joint_is_along_the_axes_of_its_child",
)
class TakesBallJointsForFixedOnes(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return _with_joints(scene, lambda j: replace(j, kind="fixed") if j.kind == "ball" else j)


@found_by(
    "the_turn_rate_of_a_ball_joint_is_along_the_axes_of_its_child",
)
class TellsTheTurnRateOfBallJointsAlongTheParent(MujocoEngine):
    def _do_joint_states(self, model: str) -> JointStates:
        states = super()._do_joint_states(model)
        if any(name.endswith("_x") for name in states.names):
            child = Pose(orientation=rotation_by(tuple(states.positions)))
            states.velocities[:] = child.rotate(tuple(states.velocities))
        return states


@found_by(
    "a_mimic_joint_follows_its_leader",
)
class LetsNoJointFollowAnother(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return _with_joints(scene, lambda joint: replace(joint, mimic=None))


@found_by(
    "a_mimic_joint_follows_its_leader",
)
class LetsJointsFollowFromZero(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        def from_zero(joint: Joint) -> Joint:
            return joint if joint.mimic is None else replace(joint, mimic=replace(joint.mimic, offset=0.0))

        return _with_joints(scene, from_zero)


@found_by(
    "a_spring_swings_about_its_equilibrium",
)
class HasNoSprings(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return _with_joints(scene, lambda joint: replace(joint, stiffness=0.0))


@found_by(
    "a_spring_swings_about_its_equilibrium",
)
class LetsSpringsRestAtZero(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return _with_joints(scene, lambda joint: replace(joint, rest=0.0))
