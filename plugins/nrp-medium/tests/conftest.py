"""Models and worlds as SDF, on both physics engines."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import pytest

from nrp_core.scene.model import Scene
from nrp_core.scene.sdf import read_scene
from nrp_core.world.backends import worlds
from nrp_core.world.world import World

Opener = Callable[..., World]


@pytest.fixture(params=["mujoco", "pybullet"])
def engine(request: pytest.FixtureRequest) -> str:
    if importlib.util.find_spec(request.param) is None:
        pytest.skip(f"{request.param} is not installed")
    return str(request.param)


@pytest.fixture
def open_in(tmp_path: Path) -> Iterator[Opener]:
    """Open the contents of a ``<world>`` in an engine."""
    with ExitStack() as opened:

        def open_in(
            engine: str, text: str, step: str = "2 ms", change: Callable[[Scene], Scene] = lambda scene: scene
        ) -> World:
            path = tmp_path / "world.sdf"
            path.write_text(
                f'<sdf version="1.11"><world name="w"><gravity>0 0 -9.8</gravity>{text}</world></sdf>'
            )
            backend = worlds().load(engine)
            world = backend.open(change(read_scene(path)), seed=1, options=backend.options(timestep=step))
            return opened.enter_context(world)

        yield open_in


@pytest.fixture
def open_world(engine: str, open_in: Opener) -> Opener:
    return partial(open_in, engine)
