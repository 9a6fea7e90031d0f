"""Images with light and shadows from any place."""

from __future__ import annotations

from math import radians, tan

import numpy as np
import pytest

from nrp_core.scene.merged_bodies import bodies_of
from nrp_core.scene.model import Box, Light, Link, Model, Visual
from nrp_core.scene.rigid import Pose
from nrp_core.world.render.realistic import AMBIENT, LitView

GREY = (0.5, 0.5, 0.5, 1.0)
HEIGHT_M, FOV, SIZE = 20.0, radians(40), 200


def still(name, size, pose):
    return Model(name, (Link("l", visuals=(Visual("v", Box(size), rgba=GREY),)),), pose=pose, static=True)


@pytest.mark.parametrize("slope", [-0.75, 0.75])
def test_a_shadow_falls_where_light_along_its_direction_puts_it(slope):
    """It moves by the slope of the light on the way down; there only ambient light is left."""
    models = still("floor", (12, 12, 0.2), Pose((0, 0, -0.1))), still("thing", (1, 1, 0.2), Pose((0, 0, 2)))
    light = Light("sun", direction=(0.8 * slope, 0.0, -0.8))
    view = LitView({m.name: bodies_of(m) for m in models}, [light], SIZE, SIZE, vertical_fov=FOV)
    above = np.column_stack([np.eye(3), (0.0, 0.0, HEIGHT_M)])  # it looks along -z
    image = view.draw(np.empty((0, 3, 4)), above)

    def at(x_m):
        place = SIZE / 2 * (1 + x_m / (HEIGHT_M * tan(FOV / 2)))
        return image[SIZE // 2, round(place)].astype(int)

    lit, shadow = at(-2 * slope), at(2 * slope)
    assert lit == pytest.approx((AMBIENT + 0.8) * 0.5 * 255, abs=2)  # by the cosine (Lambert)
    assert shadow == pytest.approx(AMBIENT * 0.5 * 255, abs=2)
