"""Worlds with one bug each in what they sense, push and change; all are MuJoCo but for the bug."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from nrp_world_mujoco.engine import MujocoEngine
from one_bug import Opens
from registry import Found, register

from nrp_core.scene.rigid import BodyPath, ModelMotion, ReadFrames, ServoTarget, Touch, Wrench
from nrp_core.world.backend import WorldOptions
from nrp_core.world.capabilities import WorldCapabilities

FOUND_BY: Found = {}
found_by = register(FOUND_BY, Opens, "world")


@found_by(
    "a_camera_looks_along_the_x_axis_of_its_robot",
    "a_laser_measures_the_distance_to_a_wall",
    "turning_left_moves_what_is_ahead_to_the_right",
)
class TurnsWhatSeesBackwards(MujocoEngine):
    def _do_frames(self, paths: Sequence[BodyPath]) -> ReadFrames:
        read = super()._do_frames(paths)

        def transposed(frames: Any) -> None:
            read(frames)
            frames[:, :, :3] = frames[:, :, :3].transpose(0, 2, 1).copy()

        return transposed


@found_by(
    "a_laser_measures_moving_bodies",
    "a_nearer_object_is_larger",
    "turning_left_moves_what_is_ahead_to_the_right",
)
class ShowsThePast(MujocoEngine):
    def _do_frames(self, paths: Sequence[BodyPath]) -> ReadFrames:
        read = super()._do_frames(paths)
        kept: list[Any] = []

        def first(frames: Any) -> None:
            if not kept:
                read(frames)
                kept.append(frames.copy())
            frames[:] = kept[0]

        return first


@found_by(
    "an_imu_measures_gravity_at_rest_and_nothing_in_free_fall",
)
class ReportsVelocitiesOfLinksWithoutTheTurn(MujocoEngine):
    def _do_link_motion(self, model: str, link: str) -> ModelMotion:
        return replace(super()._do_link_motion(model, link), linear=(0.0, 0.0, 0.0))


@found_by(
    "contacts_report_the_weight_or_are_refused",
    "contacts_report_the_forces_on_a_box_on_a_slope",
)
class FeelsTheOtherSideOfAContact(MujocoEngine):
    def _do_touches(self) -> Sequence[Touch]:
        return [replace(touch, bodies=touch.bodies[::-1]) for touch in super()._do_touches()]


@found_by(
    "contacts_report_the_weight_or_are_refused",
    "a_body_that_hangs_free_touches_nothing",
)
class TouchesWhatIsNear(MujocoEngine):
    def _do_touches(self) -> Sequence[Touch]:
        touch = Touch((("carrier", 0), ("floor", 0)), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.0, (0.0, 0.0, 0.0))
        return [*super()._do_touches(), touch]


@found_by(
    "the_load_on_a_joint_is_the_weight_below_it_or_is_refused",
)
class TellsLoadsFromTheOtherSide(MujocoEngine):
    def _do_joint_wrench(self, model: str, joint: str) -> Wrench:
        wrench = super()._do_joint_wrench(model, joint)
        return Wrench(*(tuple(-x for x in part) for part in (wrench.force, wrench.torque)))  # type: ignore[arg-type]


@found_by(
    "a_push_changes_a_velocity_by_force_times_time_over_mass_or_is_refused",
    "a_torque_turns_by_the_moment_about_its_axis_of_the_world",
    "inertia_has_its_principal_axes_where_the_file_puts_them",
)
class PullsInsteadOfPushing(MujocoEngine):
    def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
        super()._do_set_wrench(body, Wrench(tuple(-x for x in wrench.force)))  # type: ignore[arg-type]


@found_by(
    "a_joint_reaches_its_target_except_for_its_sag_or_refuses",
    "a_joint_is_slowed_by_its_damping",
    "a_joint_stops_at_its_limit",
    "a_joint_limits_the_effort_of_commands",
    "a_joint_turns_once_its_friction_is_overcome",
    "a_joint_without_limits_counts_its_turns",
    "a_position_servo_sags_by_load_over_gain",
    "a_position_servo_swings_by_its_gains",
    "a_servo_obeys_the_effort_limit_of_its_joint",
    "an_effort_accelerates_a_joint",
)
class TurnsJointsBackwards(MujocoEngine):
    def _do_set_servo_target(self, model: str, joint: str, aim: ServoTarget) -> None:
        super()._do_set_servo_target(model, joint, replace(aim, position=-aim.position, effort=-aim.effort))


@found_by(
    "a_joint_reaches_its_target_except_for_its_sag_or_refuses",
    "a_push_changes_a_velocity_by_force_times_time_over_mass_or_is_refused",
)
class IgnoresJointsSilently(Opens):
    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        return replace(super().capabilities(options), joint_control=False)

    class world(MujocoEngine):  # noqa: N801 - what a wrong backend opens
        def _do_set_servo_target(self, model: str, joint: str, aim: ServoTarget) -> None:
            pass

        def _do_set_wrench(self, body: BodyPath, wrench: Wrench) -> None:
            pass


@found_by(
    "models_can_be_added_and_removed_without_effect_on_others_or_that_is_refused",
)
class StartsAllOverWhenSomethingComes(MujocoEngine):
    def _do_configure(self, model: str, configuration: Any) -> None:
        pass


@found_by(
    "models_can_be_moved_or_that_is_refused",
)
class PlacesModelsAtRest(MujocoEngine):
    def _do_place(self, model: str, motion: ModelMotion) -> None:
        super()._do_place(model, ModelMotion(motion.pose))
