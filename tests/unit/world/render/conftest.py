"""Images of a few models with light, and what is seen in them by hand."""

from __future__ import annotations

import numpy as np
import pytest

from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.model import Link, Model, Scene, Visual
from nrp_core.scene.rigid import Pose, matrix_of
from nrp_core.world.render.cameras import looking, optics_of
from nrp_core.world.render.realistic import RealisticCameras
from nrp_core.world.sensors.camera import Camera

EYE = Pose.from_rpy((-2.0, 0.3, 2.5), 0.0, 0.7, 0.0)
CAMERA = ("eye", "link", "camera")
WHITE = (1.0, 1.0, 1.0, 1.0)


@pytest.fixture(scope="session")
def prop():
    """Make a model of one visual; white and matt, unless something else is said."""

    def prop(name: str, geometry, pose: Pose = Pose(), rgba=WHITE, finish=None) -> Model:
        visual = Visual("v", geometry, rgba=rgba, finish=finish)
        return Model(name, (Link("link", visuals=(visual,)),), pose=pose, static=True)

    return prop


@pytest.fixture(scope="session")
def seen():
    """Return an image of the models, and the rays through its pixels, row by row, in the world."""

    def seen(lights, *models: Model, eye: Pose = EYE):
        camera = Camera("camera", "/camera", 30.0, 1.2, 60, 45, 0.05, 100.0)
        models = (*models, Model("eye", (Link("link", sensors=(camera,)),), pose=eye, static=True))
        optics = optics_of(Scene(models), 1.0)
        bodies = {model.name: bodies_of(model) for model in models}
        cameras = RealisticCameras(bodies, optics, lambda paths: lambda frames: None, lights)
        return cameras.image(CAMERA), _rays(optics[CAMERA], eye)

    return seen


def _rays(optics, eye: Pose):
    across, down = np.meshgrid(np.arange(optics.width) + 0.5, np.arange(optics.height) + 0.5)
    x, y = (across - optics.width / 2) / optics.focal, (optics.height / 2 - down) / optics.focal
    return np.stack([x, y, -np.ones_like(x)], axis=-1) @ matrix_of(looking(eye))[:, :3].T


@pytest.fixture(scope="session")
def floor_points():
    """Return where rays meet the floor, NaN where they do not."""

    def floor_points(rays, eye: Pose = EYE):
        with np.errstate(all="ignore"):
            length = (-eye.position[2]) / rays[..., 2]
        return np.where((length > 0)[..., None], eye.position + rays * length[..., None], np.nan)

    return floor_points
