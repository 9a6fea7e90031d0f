"""A room, and the fake world engine with it."""

from collections.abc import Iterator

import pytest

from nrp_core.scene.model import Box, Link, Model, Scene, Visual
from nrp_core.scene.rigid import Pose
from nrp_core.world.drives.wheels import WheelDrive
from nrp_core.world.world import World


@pytest.fixture
def room() -> Scene:
    """A husky at the origin, a wall whose glass is 2 m wide at x = 3 m, and a cart that nobody drives."""
    glass = Visual("glass", Box((0.02, 2.0, 1.0)), Pose((0.0, 0.0, 1.0)))
    drive = WheelDrive("drive", "/husky/cmd_vel", (), (), separation=0.5, wheel_diameter=0.3, timeout=0.1)
    return Scene(
        (
            Model("wall", (Link("body", visuals=(glass,)),), pose=Pose((3.0, 0.0, 0.0)), static=True),
            Model("husky", (Link("base", visuals=(glass,)),), drives=(drive,)),
            Model("cart", (Link("base", visuals=(glass,)),), pose=Pose((0.0, 4.0, 0.0))),
        )
    )


@pytest.fixture
def world(fakes: None, room: Scene) -> Iterator[World]:
    """The room in the fake world engine."""
    from experiment_fakes import DiscBackend, DiscOptions

    with DiscBackend().open(room, seed=1, options=DiscOptions()) as world:
        yield world
