"""Rays of ODE itself: they agree with geometry and with nrp-core's own rays, and meet what ODE has."""

from dataclasses import replace
from importlib.resources import files
from math import cos, pi
from pathlib import Path

import numpy as np
import pytest
from nrp_conformance.world.kit import at, floor, prop
from nrp_conformance.world.sensors import LASER, SensorTests, carrier
from nrp_world_gazebo import GazeboBackend

from nrp_core.world import Box, Cylinder, ModelMotion, Scene, Sphere, read_model, read_scene
from nrp_core.world.raycast.collisions import CollisionSpace

pytestmark = [pytest.mark.heavy, pytest.mark.usefixtures("gazebo")]
AROUND = replace(LASER, samples=180, angle_min=-pi, angle_max=pi * (1 - 2 / 180), range_max=9.0)


def opened(scene, rays="gazebo"):
    backend = GazeboBackend()
    return backend.open(scene, seed=1, options=backend.options.model_validate({"rays": rays}))


class TestSensingByGazebosRays(SensorTests):
    """The conformance tests of lasers, with rays of ODE."""

    options = {"rays": "gazebo"}  # noqa: RUF012

    @classmethod
    def make_backend(cls) -> GazeboBackend:
        return GazeboBackend()


def test_nrp_core_casts_no_ray_when_gazebo_does(monkeypatch):
    def refuse(*_):
        raise AssertionError("cast by nrp-core")

    monkeypatch.setattr(CollisionSpace, "scan", refuse)
    wall = prop("wall", Box((0.2, 20.0, 2.0)), at(3.1, 0, 1))
    static = replace(carrier(LASER), static=True)
    with opened(Scene((wall, static))) as world:
        assert world.engine.scan("carrier", "link", LASER.beams)[45] == pytest.approx(3.0, abs=1e-9)
    with opened(Scene((wall, static)), "shared") as world, pytest.raises(AssertionError, match="by nrp-core"):
        world.engine.scan("carrier", "link", LASER.beams)


def test_rays_follow_the_scanner_and_the_bodies_and_keep_their_reach():
    near = replace(LASER, range_min=0.5, range_max=4.0).beams
    ball = prop("ball", Sphere(0.5), at(3, 0, 0.5), mass=1.0)
    with opened(Scene((ball, carrier(LASER)), gravity=(0.0, 0.0, 0.0))) as world:

        def ahead():
            return float(world.engine.scan("carrier", "link", near)[45])

        assert ahead() == pytest.approx(2.5, abs=1e-9)
        world.engine.place("ball", ModelMotion(at(1.5, 0.3, 0.5)))
        assert ahead() == pytest.approx(1.5 - (0.5**2 - 0.3**2) ** 0.5, abs=1e-9)
        world.engine.place("carrier", ModelMotion(at(0, 0, 0.5, yaw=pi)))
        assert ahead() == float("inf")
        world.engine.place("ball", ModelMotion(at(-6, 0, 0.5)))
        assert ahead() == float("inf")  # beyond the reach


@pytest.mark.parametrize("shape", [Box((1.0, 0.6, 1.0)), Sphere(0.5), Cylinder(0.4, 1.0)])
def test_the_rays_of_both_agree_on_shapes_and_on_the_room(shape):
    things = floor(), prop("thing", shape, at(2, 0.2, 0.6, yaw=0.4)), replace(carrier(AROUND), static=True)
    for scene in (Scene(things), room_with_scanner()):
        with opened(scene) as ours, opened(scene, "shared") as theirs:
            of_ode, of_core = (each.engine.scan("carrier", "link", AROUND.beams) for each in (ours, theirs))
        assert np.isfinite(of_core).any()
        unlike = ~np.isclose(of_ode, of_core, atol=1e-4)
        assert unlike.mean() < 0.02  # rays that graze an edge


def room_with_scanner():
    folder = Path(str(files("nrp_experiments.braitenberg_husky")))
    return read_scene(folder / "room.sdf").with_model(
        replace(carrier(AROUND, pose=at(0, 0, 0.8)), static=True)
    )


def test_rays_meet_a_wall_that_a_plugin_of_gazebo_has_moved(tmp_path):
    file = tmp_path / "wall.sdf"
    file.write_text(
        '<sdf version="1.6"><model name="wall"><pose>3 0 0.5 0 0 0</pose><link name="link">'
        "<inertial><mass>1</mass></inertial><gravity>0</gravity><collision name='c'><geometry><box>"
        "<size>1 4 1</size></box></geometry></collision></link>"
        '<plugin name="throw" filename="libInitialVelocityPlugin.so"><linear>1 0 0</linear></plugin>'
        "</model></sdf>"
    )
    scene = Scene((read_model(file), replace(carrier(LASER), static=True)))
    with opened(scene) as world:
        world.run_until(1_000_000_000)
        assert world.engine.scan("carrier", "link", LASER.beams)[45] == pytest.approx(3.5, abs=5e-3)
        edge = LASER.beams.angles[1]
        assert world.engine.scan("carrier", "link", LASER.beams)[40] == pytest.approx(
            3.5 / cos(edge / 9), rel=5e-3
        )
