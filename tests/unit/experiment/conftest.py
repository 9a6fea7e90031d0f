"""Two engines without a simulator, installed as anybody would install theirs, and a room for them."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from nrp_core.world.interface import World
from nrp_core.world.scene.model import Box, Link, Model, Scene, Visual, WheelDrive
from nrp_core.world.scene.pose import Pose

FAKES = Path(__file__).parent / "fakes"


@pytest.fixture
def fakes(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Install the brain ``counting``, the world ``disc`` and a brain ``broken`` that does not import."""
    site = tmp_path_factory.mktemp("site")
    info = site / "fakes-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: fakes\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[nrp_core.brain]\ncounting = experiment_fakes:CountingBackend\nbroken = no_such_module:Backend\n"
        "[nrp_core.world]\ndisc = experiment_fakes:DiscBackend\n"
    )
    monkeypatch.syspath_prepend(site)
    monkeypatch.syspath_prepend(FAKES)


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


@pytest.fixture
def drive_to_the_wall(tmp_path: Path) -> Path:
    """A folder with a whole experiment: a robot drives to a wall that turns red."""
    folder = tmp_path / "drive_to_the_wall"
    shutil.copytree(FAKES, folder, ignore=shutil.ignore_patterns("__pycache__", "experiment_fakes.py"))
    return folder
