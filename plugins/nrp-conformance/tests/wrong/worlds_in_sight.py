"""Worlds with one bug each in their images and colours; all are MuJoCo but for the bug."""

from __future__ import annotations

from dataclasses import replace

from nrp_world_mujoco.backend import MujocoBackend
from nrp_world_mujoco.engine import MujocoEngine
from one_bug import ChangesTheScene, Opens, with_sensors, with_visuals
from registry import Found, register

from nrp_core.scene.model import Rgba, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.world.backend import WorldOptions
from nrp_core.world.capabilities import WorldCapabilities
from nrp_core.world.engine import Engine
from nrp_core.world.render.cameras import ImageArray

FOUND_BY: Found = {}
found_by = register(FOUND_BY, Opens, "world")


@found_by(
    "a_camera_has_its_pose_in_its_link",
    "a_colour_changes_only_its_visual_and_can_be_read_back",
    "a_visual_has_its_pose_in_its_link",
    "every_visual_of_a_link_is_rendered",
    "left_is_left",
    "turning_left_moves_what_is_ahead_to_the_right",
)
class SwapsLeftAndRight(MujocoEngine):
    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        return super()._do_render(model, link, camera)[:, ::-1].copy()


@found_by(
    "a_camera_has_its_pose_in_its_link",
    "a_camera_that_is_tilted_down_sees_what_is_ahead_further_up",
    "up_is_up",
)
class IsUpsideDown(MujocoEngine):
    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        return super()._do_render(model, link, camera)[::-1].copy()


@found_by(
    "a_camera_looks_along_the_x_axis_of_its_robot",
    "a_camera_has_its_pose_in_its_link",
    "a_camera_that_is_tilted_down_sees_what_is_ahead_further_up",
    "a_colour_changes_only_its_visual_and_can_be_read_back",
    "an_image_shows_the_moment_of_its_stamp",
    "a_new_colour_is_seen_within_one_period",
    "an_object_has_the_width_given_by_its_distance_and_the_field_of_view",
    "a_visual_has_its_pose_in_its_link",
    "channels_are_red_green_blue",
    "a_nearer_object_is_larger",
    "each_robot_sees_with_its_own_camera",
    "edges_are_in_the_pixels_of_a_pinhole",
    "every_visual_of_a_link_is_rendered",
    "left_is_left",
    "turning_left_moves_what_is_ahead_to_the_right",
    "up_is_up",
    "a_near_object_hides_those_behind_it",
)
class GivesBlueFirst(MujocoEngine):
    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        return super()._do_render(model, link, camera)[:, :, ::-1].copy()


@found_by(
    "an_old_image_does_not_change_when_a_new_one_is_taken",
)
class UsesOneBufferForAllImages(MujocoEngine):
    buffer: ImageArray | None = None

    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        image = super()._do_render(model, link, camera)
        if self.buffer is None or self.buffer.shape != image.shape:
            self.buffer = image.copy()
        self.buffer.flags.writeable = True
        self.buffer[:] = image
        return self.buffer


@found_by(
    "a_new_colour_is_seen_within_one_period",
    "an_image_shows_the_moment_of_its_stamp",
    "a_nearer_object_is_larger",
    "turning_left_moves_what_is_ahead_to_the_right",
)
class ShowsTheImageBefore(MujocoEngine):
    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        before = getattr(self, "_before", {})
        image = super()._do_render(model, link, camera)
        shown = before.get((model, camera), image)
        self._before = {**before, (model, camera): image}
        return shown.copy()


@found_by(
    "each_robot_sees_with_its_own_camera",
)
class SeesWithTheFirstCamera(MujocoEngine):
    def _do_render(self, model: str, link: str, camera: str) -> ImageArray:
        first = next(m.name for m, part in self.scene.links() if part.sensors)
        return super()._do_render(first, link, camera)


@found_by(
    "a_colour_changes_only_its_visual_and_can_be_read_back",
    "an_object_has_the_width_given_by_its_distance_and_the_field_of_view",
    "depth_is_the_distance_along_the_line_of_sight",
    "edges_are_in_the_pixels_of_a_pinhole",
    "left_is_left",
)
class TakesTheFieldOfViewForVertical(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return with_sensors(scene, lambda c: replace(c, horizontal_fov=c.horizontal_fov * 1.3))


@found_by(
    "a_camera_has_its_pose_in_its_link",
    "a_camera_that_is_tilted_down_sees_what_is_ahead_further_up",
)
class IgnoresThePoseOfCameras(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return with_sensors(scene, lambda c: replace(c, pose=Pose()))


@found_by(
    "channels_are_red_green_blue",
    "each_robot_sees_with_its_own_camera",
    "every_visual_of_a_link_is_rendered",
    "left_is_left",
    "a_near_object_hides_those_behind_it",
)
class SeesThroughThings(ChangesTheScene):
    def changed(self, scene: Scene) -> Scene:
        return with_visuals(scene, lambda v: replace(v, rgba=(*v.rgba[:3], 0.0)) if v.rgba[2] > 0.9 else v)


@found_by(
    "a_colour_changes_only_its_visual_and_can_be_read_back",
    "a_new_colour_is_seen_within_one_period",
)
class IgnoresColours(MujocoEngine):
    def _do_set_color(self, visual: str, rgba: Rgba) -> None:
        pass


@found_by(
    "a_colour_changes_only_its_visual_and_can_be_read_back",
    "a_reset_restores_the_first_colours",
)
class ColoursEverything(MujocoEngine):
    def _do_set_color(self, visual: str, rgba: Rgba) -> None:
        for each in self.scene.visuals:
            super()._do_set_color(each, rgba)


@found_by(
    "a_reset_restores_the_first_colours",
)
class KeepsColoursOverAReset(MujocoEngine):
    def _do_reset(self, seed: int) -> None:
        super()._do_reset(seed)
        self.resetting = True

    def _do_set_color(self, visual: str, rgba: Rgba) -> None:
        if not getattr(self, "resetting", False) or self.now_ns:
            super()._do_set_color(visual, rgba)


@found_by(
    "undeclared_cameras_are_refused",
    "capabilities_are_the_same_at_every_call",
)
class HidesItsCameras(Opens):
    def capabilities(self, options: WorldOptions) -> WorldCapabilities:
        return replace(super().capabilities(options), renderers=())

    def engine(self, scene: Scene, *, seed: int, options: WorldOptions) -> Engine:
        return MujocoBackend().engine(scene, seed=seed, options=options)
