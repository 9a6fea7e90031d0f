"""Images with light and shadows, on both engines: alike, and as the lights of now shine."""

from __future__ import annotations

import numpy as np
import pytest

from nrp_core.messages.gazebo_srvs import DeleteLightRequest, SetLightPropertiesRequest
from nrp_core.messages.std_msgs import ColorRGBA
from nrp_core.scene.model import Box, Finish, Light, Link, Model, Scene, Sphere, Visual
from nrp_core.scene.rigid import Pose
from nrp_core.world.render.realistic import AMBIENT
from nrp_core.world.sensors.camera import Camera

SUN = Light("sun", direction=(0.0, 0.0, -1.0), diffuse=(0.5, 0.5, 0.5, 1.0))
SHADED, LIT = (10, 16), (20, 16)  # rows and columns of the eye's image: under the plate, and before it
WHITE = (1.0, 1.0, 1.0, 1.0)


@pytest.fixture
def looking(open_world, parts):
    """Open a white floor, a plate over a part of it, and an eye that looks at its shadow."""

    def looking(*lights: Light, renderer: str = "realistic"):
        floor = parts.prop("floor", Box((20.0, 20.0, 0.1)), Pose((0, 0, -0.05)), rgba=WHITE)
        plate = parts.prop(
            "plate", Box((2.0, 8.0, 0.05)), Pose((4.0, 0, 2.0)), rgba=(1, 0, 0, 1), solid=False
        )
        camera = Camera("camera", "/eye", 30.0, 1.0, 32, 24, depth_topic="/depth")
        eye = Model(
            "eye", (Link("eye", sensors=(camera,)),), pose=Pose.from_rpy((0, 0, 1.5), 0, 0.4, 0), static=True
        )
        return open_world(Scene((floor, plate, eye), lights), renderer=renderer)

    return looking


def image(world):
    return world.engine.render("eye", "eye", "camera")


def grey(light: float) -> list[int]:
    return [round(255 * light)] * 3


def test_shadowed_surfaces_are_darker_than_lit_ones(looking):
    seen = image(looking(SUN))
    assert seen[LIT].tolist() == grey(AMBIENT + 0.5)
    assert seen[SHADED].tolist() == grey(AMBIENT)


def test_a_light_that_casts_no_shadows_shines_through(looking):
    seen = image(looking(Light("sun", diffuse=SUN.diffuse, casts_shadows=False)))
    assert seen[SHADED].tolist() == seen[LIT].tolist() == grey(AMBIENT + 0.5)


def test_a_light_that_is_changed_by_a_service_is_seen_in_the_next_image(looking, advance):
    world = looking(SUN)
    before = image(world)
    world.call(
        "/gazebo/set_light_properties", SetLightPropertiesRequest("sun", ColorRGBA(0.2, 0.0, 0.0, 1.0))
    )
    assert image(world)[LIT].tolist() == [*grey(AMBIENT + 0.2)[:1], *grey(AMBIENT)[:2]]
    world.call("/gazebo/delete_light", DeleteLightRequest("sun"))
    assert image(world)[LIT].tolist() == grey(AMBIENT)
    advance(world, 0.1)
    world.reset()
    assert (image(world) == before).all()


def test_a_snapshot_keeps_the_lights_of_its_time(looking):
    world = looking(SUN)
    world.call(
        "/gazebo/set_light_properties", SetLightPropertiesRequest("sun", ColorRGBA(0.1, 0.1, 0.1, 1.0))
    )
    dim, snapshot = image(world), world.snapshot()
    world.call("/gazebo/delete_light", DeleteLightRequest("sun"))
    world.restore(snapshot)
    assert (image(world) == dim).all()
    assert dim[LIT].tolist() == grey(AMBIENT + 0.1)


def test_a_colour_that_is_set_is_lit_as_well(looking):
    world = looking(SUN)
    world.engine.set_color("floor/link/visual", (0.0, 1.0, 0.0, 1.0))
    assert image(world)[LIT].tolist() == [0, *grey(AMBIENT + 0.5)[:1], 0]


def test_an_emissive_surface_keeps_its_colour_in_the_shadow_and_under_coloured_light(open_world, parts):
    floor = parts.prop("floor", Box((20.0, 20.0, 0.1)), Pose((0, 0, -0.05)), rgba=WHITE)
    screen = Visual("screen", Box((1.0, 1.0, 1.0)), rgba=(1.0, 0.0, 0.0, 1.0), glows=True)
    camera = Camera("camera", "/eye", 30.0, 1.0, 32, 24)
    models = (
        Model("lamp", (Link("link", visuals=(screen,)),), pose=Pose((2.0, 0.0, 0.5)), static=True),
        Model("eye", (Link("eye", sensors=(camera,)),), pose=Pose((0.0, 0.0, 0.5)), static=True),
    )
    world = open_world(Scene((floor, *models), (SUN,)), renderer="realistic")
    assert image(world)[12, 16].tolist() == [255, 0, 0]
    world.engine.set_color("lamp/link/screen", (0.0, 0.5, 0.0, 1.0))
    assert image(world)[12, 16].tolist() == [0, 128, 0]


@pytest.mark.parametrize(
    ("kind", "value", "seen"),
    [
        ("material:script:name", "Gazebo/GreenGlow", [0, 255, 0]),
        ("material:emissive", "0 0.5 0 1", [0, 128, 0]),
        ("material:diffuse", "0 1 0 1", [0, 102, 0]),
    ],
)
def test_a_visual_that_is_given_a_glowing_material_glows_until_it_is_reset(
    open_world, parts, kind, value, seen
):
    screen = parts.prop("screen", Box((1.0, 1.0, 1.0)), Pose((2.0, 0.0, 0.5)), rgba=WHITE)
    camera = Camera("camera", "/eye", 30.0, 1.0, 32, 24)
    eye = Model("eye", (Link("eye", sensors=(camera,)),), pose=Pose((0.0, 0.0, 0.5)), static=True)
    world = open_world(Scene((screen, eye)), renderer="realistic")
    request = ("screen", "link", "visual", kind, value)
    assert world.call("/gazebo/set_visual_properties", *request).success
    assert image(world)[12, 16].tolist() == seen
    kept = world.snapshot()
    world.reset()
    assert image(world)[12, 16].tolist() == grey(AMBIENT)
    world.restore(kept)
    assert image(world)[12, 16].tolist() == seen


@pytest.mark.parametrize("kind", ["directional", "point", "spot"])
def test_each_kind_of_light_throws_the_shadow_of_what_is_before_it(looking, kind):
    lamp = Light("lamp", kind, Pose((4.0, 0.0, 6.0)), diffuse=SUN.diffuse, cone=(1.5, 1.6))
    seen = image(looking(lamp))
    assert seen[SHADED].tolist() == grey(AMBIENT)
    assert seen[LIT][0] > grey(AMBIENT + 0.3)[0]


def test_a_shadow_goes_with_what_throws_it(open_world, parts, advance):
    floor = parts.prop("floor", Box((20.0, 20.0, 0.1)), Pose((0, 0, -0.05)), rgba=WHITE)
    plate = parts.prop("plate", Box((2.0, 8.0, 0.05)), Pose((4.0, 0, 2.0)), mass=1.0, solid=False)
    camera = Camera("camera", "/eye", 30.0, 1.0, 32, 24)
    eye = Model(
        "eye", (Link("eye", sensors=(camera,)),), pose=Pose.from_rpy((0, 0, 1.5), 0, 0.4, 0), static=True
    )
    world = open_world(Scene((floor, plate, eye), (SUN,), gravity=(0.0, 4.0, 0.0)), renderer="realistic")
    assert image(world)[SHADED].tolist() == grey(AMBIENT)
    advance(world, 2.0)  # by 8 m to the left
    assert image(world)[SHADED].tolist() == grey(AMBIENT + 0.5)
    world.engine.set_color("plate/link/visual", (0.0, 0.0, 0.0, 0.0))
    world.reset()
    assert image(world)[SHADED].tolist() == grey(AMBIENT)


def test_an_object_that_appears_later_throws_a_shadow_from_then_on(open_world, parts):
    ground = parts.prop("ground", Box((100.0, 100.0, 0.1)), Pose((0, 0, -0.05)), rgba=WHITE)
    stone = parts.prop("stone", Box((0.1, 0.1, 0.1)), Pose((0.0, 0.0, 0.05)))
    hidden = Visual("visual", Box((2.0, 8.0, 0.05)), rgba=(1.0, 0.0, 0.0, 0.0))
    plate = Model("plate", (Link("link", visuals=(hidden,)),), pose=Pose((4.0, 0.0, 2.0)), static=True)
    sensors = (Camera("camera", "/eye", 30.0, 1.0, 32, 24),)
    eye = Model(
        "eye", (Link("eye", sensors=sensors),), pose=Pose.from_rpy((0, 0, 1.5), 0, 0.4, 0), static=True
    )
    world = open_world(Scene((ground, stone, plate, eye), (SUN,)), renderer="realistic")
    assert image(world)[SHADED].tolist() == grey(AMBIENT + 0.5)
    world.engine.set_color("plate/link/visual", (1.0, 0.0, 0.0, 1.0))
    assert image(world)[SHADED].tolist() == grey(AMBIENT)


def test_an_invisible_object_throws_no_shadow(looking):
    world = looking(SUN)
    assert image(world)[SHADED].tolist() == grey(AMBIENT)
    world.engine.set_color("plate/link/visual", (1.0, 0.0, 0.0, 0.0))
    assert image(world)[SHADED].tolist() == grey(AMBIENT + 0.5)


def test_both_engines_make_the_same_realistic_image(engines, parts):
    shapes = (parts.floor(), parts.wall(3.0), parts.husky("other", Pose((1.5, 0.5, parts.standing))))
    scene = Scene((*shapes, parts.husky(width=160, height=120)), (Light("sun", direction=(0.5, -0.4, -1.0)),))
    images = []
    for backend in engines:
        with backend.open(scene, seed=1, options=backend.options(renderer="realistic")) as world:
            images.append(world.engine.render("husky", "eye", "camera"))
    assert (images[0] == images[1]).all(axis=2).mean() > 0.99


def shining(parts, finish: Finish, rgba=(1.0, 0.0, 0.0, 1.0)) -> Scene:
    ball = Model(
        "ball",
        (Link("link", visuals=(Visual("v", Sphere(0.8), rgba=rgba, finish=finish),)),),
        pose=Pose((3.0, 0.0, 1.0)),
        static=True,
    )
    camera = Camera("camera", "/eye", 30.0, 1.0, 64, 48)
    eye = Model("eye", (Link("eye", sensors=(camera,)),), pose=Pose((0.0, 0.0, 1.5)), static=True)
    return Scene((parts.floor(), ball, eye), (Light("sun", direction=(1.0, 0.3, -1.0)),))


@pytest.mark.parametrize("finish", [Finish(0.3, 1.0), Finish(0.3, 0.0), Finish(1.0, 0.5)], ids=str)
def test_both_engines_show_what_shines_alike_and_not_as_matt(engines, parts, finish):
    images = []
    for backend in engines:
        for chosen in (finish, None):
            scene = shining(parts, chosen)
            with backend.open(scene, seed=1, options=backend.options(renderer="realistic")) as world:
                images.append(image(world))
    assert (images[0] == images[2]).all(axis=2).mean() > 0.999
    assert (images[0] != images[1]).any(axis=2).mean() > 0.05


def test_metal_shines_in_the_colour_that_it_is_given(open_world, parts):
    world = open_world(shining(parts, Finish(0.4, 1.0)), renderer="realistic")
    red = image(world)
    world.engine.set_color("ball/link/v", (0.0, 0.0, 1.0, 1.0))
    blue = image(world)
    changed = (blue != red).any(axis=2)
    assert changed.mean() > 0.05
    assert (blue[changed] == red[changed][:, ::-1]).all()


def test_flat_images_do_not_show_how_things_shine(open_world, parts):
    shiny, matt = (open_world(shining(parts, finish)) for finish in (Finish(0.3, 1.0), None))
    assert (image(shiny) == image(matt)).all()


def test_flat_images_do_not_depend_on_lights(looking):
    assert (image(looking(SUN, renderer="raster")) == image(looking(renderer="raster"))).all()


def test_depth_is_the_same_with_every_renderer(looking, backend):
    depths = {}
    for renderer in backend.capabilities(backend.options()).renderers:
        world = looking(SUN, renderer=renderer)
        world.engine.set_color("plate/link/visual", (0.0, 0.0, 0.0, 0.0))  # as before the depth is asked for
        heard = world.subscribe("/depth")
        world.run_until(20_000_000)
        depths[renderer] = heard.latest.message.data
    first = depths.pop("raster")
    assert np.isfinite(first).any()
    for renderer, depth in depths.items():
        assert (depth == first).all(), renderer
