"""Worlds with one bug each in motion, time and state; all are MuJoCo but for the bug."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from nrp_world_mujoco.engine import MujocoEngine
from one_bug import ChangesTheScene, Opens, with_links
from registry import Found, register

from nrp_core.scene.model import Scene
from nrp_core.scene.rigid import BodyVelocity, JointStates, ModelMotion, Pose

FOUND_BY: Found = {}
found_by = register(FOUND_BY, Opens, "world")


@found_by(
    "a_curve_is_exactly_the_commanded_arc",
    "a_joint_turns_by_the_right_hand_about_its_axis_until_its_limit",
    "a_positive_turn_is_to_the_left",
    "a_quarter_turn_is_reported_as_x_y_z_w",
    "a_robot_keeps_its_roll_and_pitch_on_level_ground",
    "a_velocity_is_the_change_of_the_position",
    "an_axis_is_given_in_the_frame_of_its_joint",
    "forward_is_along_the_x_axis_of_the_robot",
    "models_can_be_moved_or_that_is_refused",
    "odometry_reports_the_velocity_in_the_robots_own_frame",
    "odometry_reports_the_displacement_since_the_start",
    "several_robots_each_follow_their_own_commands",
    "the_turn_rate_of_a_ball_joint_is_along_the_axes_of_its_child",
)
class ReportsQuaternionsWithWFirst(MujocoEngine):
    def _do_model_motion(self, model: str) -> ModelMotion:
        motion = super()._do_model_motion(model)
        x, y, z, w = motion.pose.orientation
        return replace(motion, pose=Pose(motion.pose.position, (w, x, y, z)))


@found_by(
    "a_torque_turns_by_the_moment_about_its_axis_of_the_world",
    "a_velocity_is_the_change_of_the_position",
    "odometry_reports_the_velocity_in_the_robots_own_frame",
)
class ReportsVelocitiesInTheBodysFrame(MujocoEngine):
    def _do_model_motion(self, model: str) -> ModelMotion:
        motion = super()._do_model_motion(model)
        to_body = motion.pose.inverse()
        return replace(motion, linear=to_body.rotate(motion.linear))


@found_by(
    "a_positive_turn_is_to_the_left",
    "a_torque_turns_by_the_moment_about_its_axis_of_the_world",
    "a_velocity_is_the_change_of_the_position",
    "inertia_has_its_principal_axes_where_the_file_puts_them",
    "models_can_be_moved_or_that_is_refused",
    "odometry_reports_the_velocity_in_the_robots_own_frame",
    "several_robots_each_follow_their_own_commands",
    "the_turn_rate_of_a_ball_joint_is_along_the_axes_of_its_child",
    "velocities_are_those_of_the_arc",
)
class ReportsTurnsInDegrees(MujocoEngine):
    def _do_model_motion(self, model: str) -> ModelMotion:
        motion = super()._do_model_motion(model)
        x, y, z = np.degrees(motion.angular).tolist()
        return replace(motion, angular=(x, y, z))


@found_by(
    "a_ball_joint_turns_about_any_axis",
    "a_mimic_joint_follows_its_leader",
    "a_light_link_between_two_joints_lets_its_child_turn_about_both",
    "a_body_falls_along_gravity_by_half_g_t_squared",
    "contacts_report_the_forces_on_a_box_on_a_slope",
    "the_turn_rate_of_a_ball_joint_is_along_the_axes_of_its_child",
    "a_sliding_joint_is_held_by_its_friction",
    "a_sliding_body_is_slowed_by_the_friction_of_its_shape",
)
class TakesGravityAlongZOnly(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return replace(scene, gravity=(0.0, 0.0, scene.gravity[2]))


@found_by(
    "a_ball_joint_turns_about_any_axis",
    "a_body_falls_along_gravity_by_half_g_t_squared",
    "a_joint_is_slowed_by_its_damping",
    "a_joint_limits_the_effort_of_commands",
    "a_joint_stops_at_its_limit",
    "a_joint_stops_at_its_lower_limit",
    "a_joint_turns_once_its_friction_is_overcome",
    "a_joint_without_limits_counts_its_turns",
    "a_light_link_between_two_joints_lets_its_child_turn_about_both",
    "a_mimic_joint_follows_its_leader",
    "a_muscle_pulls_its_limb_with_its_tension",
    "a_position_servo_swings_by_its_gains",
    "a_push_changes_a_velocity_by_force_times_time_over_mass_or_is_refused",
    "a_servo_obeys_the_effort_limit_of_its_joint",
    "a_sliding_body_is_slowed_by_the_friction_of_its_shape",
    "a_sliding_joint_is_held_by_its_friction",
    "a_torque_turns_by_the_moment_about_its_axis_of_the_world",
    "a_velocity_servo_reaches_its_velocity_by_its_gain",
    "a_world_that_is_not_finite_is_reported_and_a_reset_repairs_it",
    "an_effort_accelerates_a_joint",
    "an_effort_on_a_joint_accelerates_it_by_effort_over_inertia",
    "contacts_report_the_forces_on_a_box_on_a_slope",
    "the_turn_rate_of_a_ball_joint_is_along_the_axes_of_its_child",
    "without_gravity_nothing_moves",
)
class HasGravityOfItsOwn(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return replace(scene, gravity=(0.0, 0.0, -9.8))


@found_by(
    "a_position_servo_sags_by_load_over_gain",
    "a_robot_falls_like_everything_else",
    "a_spring_swings_about_its_equilibrium",
    "a_body_falls_along_gravity_by_half_g_t_squared",
    "an_imu_measures_gravity_at_rest_and_nothing_in_free_fall",
    "contacts_report_the_weight_or_are_refused",
    "contacts_report_the_forces_on_a_box_on_a_slope",
    "a_ball_joint_follows_orientations",
    "the_load_on_a_joint_is_the_weight_below_it_or_is_refused",
)
class HasALittleLessGravity(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        x, y, z = scene.gravity
        return replace(scene, gravity=(0.98 * x, 0.98 * y, 0.98 * z))


@found_by(
    "an_object_without_collision_shapes_does_not_stop_a_robot",
)
class MakesEverythingSolid(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        from nrp_core.scene.model import Collision

        return with_links(
            scene,
            lambda link: link if link.collisions or not link.visuals
            else replace(link, collisions=(Collision("c", link.visuals[0].geometry),)),
        )  # fmt: skip


@found_by(
    "a_robot_in_a_corner_is_inside_neither_wall",
    "a_laser_measures_the_distance_to_a_wall",
    "a_laser_measures_moving_bodies",
    "a_link_stands_on_any_of_its_shapes",
    "a_low_wall_stops_a_robot_and_a_bridge_does_not",
    "a_robot_ends_at_half_its_length_in_every_heading",
    "a_robot_pushes_obstacles",
    "a_shape_has_its_exact_size",
    "a_shape_has_its_size_and_place",
    "a_body_at_rest_stays_at_rest",
    "a_rotated_box_has_its_sides_in_the_right_places",
    "a_wall_stops_a_robot",
    "an_imu_measures_gravity_at_rest_and_nothing_in_free_fall",
    "contacts_report_the_weight_or_are_refused",
    "contacts_report_the_forces_on_a_box_on_a_slope",
    "a_sliding_joint_is_held_by_its_friction",
    "a_sliding_body_is_slowed_by_the_friction_of_its_shape",
)
class MakesNothingSolid(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        from nrp_core.scene.model import Plane

        return with_links(
            scene,
            lambda link: link if any(isinstance(c.geometry, Plane) for c in link.collisions)
            or (len(link.collisions) == 1 and link.name.endswith("wheel")) else replace(link, collisions=()),
        )  # fmt: skip


@found_by(
    "a_curve_is_a_circle_of_speed_over_turn",
    "a_curve_is_exactly_the_commanded_arc",
    "a_positive_turn_is_to_the_left",
    "odometry_reports_the_velocity_in_the_robots_own_frame",
    "several_robots_each_follow_their_own_commands",
    "turning_left_moves_what_is_ahead_to_the_right",
    "velocities_are_those_of_the_arc",
    "wheels_turn_in_the_direction_in_which_they_roll",
)
class TurnsTheWrongWay(MujocoEngine):
    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        super()._do_set_drive(model, drive, replace(velocity, turn=-velocity.turn))


@found_by(
    "a_wall_at_an_angle_leaves_the_room_beside_it",
    "a_curve_is_a_circle_of_speed_over_turn",
    "a_curve_is_exactly_the_commanded_arc",
    "a_planar_drive_moves_exactly_as_commanded",
    "a_spawned_robot_drives_and_sees",
    "forward_is_along_the_x_axis_of_the_robot",
    "odometry_reports_the_velocity_in_the_robots_own_frame",
    "several_robots_each_follow_their_own_commands",
    "the_commanded_speed_is_reached",
    "velocities_are_those_of_the_arc",
    "wheels_turn_in_the_direction_in_which_they_roll",
)
class DrivesATenthTooFast(MujocoEngine):
    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        super()._do_set_drive(model, drive, replace(velocity, forward=1.1 * velocity.forward))


@found_by(
    "a_snapshot_keeps_everything_that_moves",
    "several_robots_each_follow_their_own_commands",
)
class DrivesOneRobotForAll(MujocoEngine):
    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        first = next(m.name for m in self.scene.models if m.drives)
        super()._do_set_drive(first, drive, velocity)


@found_by(
    "a_command_holds_until_the_timeout_and_then_the_robot_stops",
    "a_command_of_zero_stops",
)
class NeverStopsADrive(MujocoEngine):
    def _do_set_drive(self, model: str, drive: str, velocity: BodyVelocity) -> None:
        if velocity != BodyVelocity() or not self.now_ns:
            super()._do_set_drive(model, drive, velocity)


@found_by(
    "a_ball_joint_follows_orientations",
    "a_ball_joint_turns_about_any_axis",
    "a_joint_is_slowed_by_its_damping",
    "a_joint_limits_the_effort_of_commands",
    "a_joint_reaches_its_target_except_for_its_sag_or_refuses",
    "a_joint_stops_at_its_limit",
    "a_joint_stops_at_its_lower_limit",
    "a_joint_turns_by_the_right_hand_about_its_axis_until_its_limit",
    "a_joint_turns_once_its_friction_is_overcome",
    "a_joint_without_limits_counts_its_turns",
    "a_light_link_between_two_joints_lets_its_child_turn_about_both",
    "a_link_stands_on_any_of_its_shapes",
    "a_link_turns_about_axes_of_the_world",
    "a_mimic_joint_follows_its_leader",
    "a_muscle_pulls_its_limb_with_its_tension",
    "a_muscle_reports_its_state_by_its_curves",
    "a_position_servo_sags_by_load_over_gain",
    "a_position_servo_swings_by_its_gains",
    "a_servo_obeys_the_effort_limit_of_its_joint",
    "a_shape_has_its_exact_size",
    "a_shape_has_its_size_and_place",
    "a_spring_swings_about_its_equilibrium",
    "a_velocity_servo_reaches_its_velocity_by_its_gain",
    "an_axis_is_given_in_the_frame_of_its_joint",
    "an_effort_accelerates_a_joint",
    "an_effort_on_a_joint_accelerates_it_by_effort_over_inertia",
    "link_poses_are_reported_or_refused",
    "several_robots_each_follow_their_own_commands",
    "the_turn_rate_of_a_ball_joint_is_along_the_axes_of_its_child",
    "wheels_turn_in_the_direction_in_which_they_roll",
)
class ReportsJointsBackwards(MujocoEngine):
    def _do_joint_states(self, model: str) -> JointStates:
        found = super()._do_joint_states(model)
        return replace(found, positions=-found.positions, velocities=-found.velocities)


@found_by(
    "a_ball_joint_follows_orientations",
    "joints_are_listed_in_the_order_of_the_file",
)
class SortsJoints(MujocoEngine):
    def _do_joint_states(self, model: str) -> JointStates:
        found = super()._do_joint_states(model)
        order = np.argsort(found.names)[::-1]
        return JointStates(tuple(found.names[i] for i in order), found.positions[order],
                           found.velocities[order], found.efforts[order])  # fmt: skip


@found_by(
    "a_body_falls_along_gravity_by_half_g_t_squared",
    "a_curve_is_a_circle_of_speed_over_turn",
    "a_curve_is_exactly_the_commanded_arc",
    "a_muscle_pulls_its_limb_with_its_tension",
    "a_positive_turn_is_to_the_left",
    "a_robot_falls_like_everything_else",
    "a_run_ends_exactly_at_the_requested_time",
    "a_spawned_robot_drives_and_sees",
    "a_velocity_is_the_change_of_the_position",
    "a_wall_at_an_angle_leaves_the_room_beside_it",
    "an_activation_follows_its_control_by_its_time_constants",
    "an_imu_measures_gravity_at_rest_and_nothing_in_free_fall",
    "forward_is_along_the_x_axis_of_the_robot",
    "splitting_a_run_is_invisible",
)
class TakesOneStepTooMany(MujocoEngine):
    def _do_advance(self, steps: int) -> None:
        super()._do_advance(steps + 1)


@found_by(
    "splitting_a_run_is_invisible",
)
class JoltsWithEveryCall(MujocoEngine):
    calls = 0

    def _do_advance(self, steps: int) -> None:
        super()._do_advance(steps)
        self._data.qvel[:] *= 1 - 1e-9


@found_by(
    "a_snapshot_keeps_a_command_and_its_timeout",
    "a_snapshot_keeps_everything_that_moves",
    "a_snapshot_keeps_forces_and_targets",
    "a_snapshot_keeps_joint_commands",
    "a_snapshot_keeps_spawned_models",
)
class ForgetsVelocitiesInASnapshot(MujocoEngine):
    def _do_restore(self, saved: Any) -> None:
        super()._do_restore(saved)
        self._data.qvel[:] = 0.0


@found_by(
    "a_reset_ends_forces_and_targets",
    "a_reset_stops_the_robots",
    "a_reset_world_equals_a_fresh_one",
    "a_reset_world_without_commands_equals_a_fresh_one",
)
class KeepsVelocitiesOverAReset(MujocoEngine):
    def _do_reset(self, seed: int) -> None:
        velocities = self._data.qvel.copy()
        super()._do_reset(seed)
        self._data.qvel[:] = velocities


@found_by(
    "a_world_that_is_not_finite_is_reported_and_a_reset_repairs_it",
)
class HidesThatItDiverged(MujocoEngine):
    def check_state(self, t_ns: int) -> None:
        """Take any state."""

    def _report_warnings(self) -> None:
        self._mute_warnings()

    def _do_model_motion(self, model: str) -> ModelMotion:
        motion = super()._do_model_motion(model)
        return motion if np.isfinite(motion.pose.position).all() else ModelMotion(Pose())
