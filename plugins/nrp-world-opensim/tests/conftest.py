"""Worlds of own models."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from nrp_core.world import Pose, Scene, World, read_scene

from nrp_world_opensim import OpensimBackend
from own_models import MODELS, written

pytest_plugins = ["cases", "golden"]  # in tests/shared

Open = Callable[..., World]


@pytest.fixture
def file_of(tmp_path: Path) -> Callable[[str], Path]:
    """Write one of the models to a file."""
    return lambda name: written(MODELS[name](), tmp_path)


@pytest.fixture
def open_world() -> Iterator[Open]:
    """Open the world of a file, or of a scene."""
    with ExitStack() as opened:

        def open_(what: Path | Scene, *, pose: Pose | None = None, **options: Any) -> World:
            scene = read_scene(what) if isinstance(what, Path) else what
            if pose is not None:
                from dataclasses import replace

                scene = replace(scene, models=tuple(replace(each, pose=pose) for each in scene.models))
            backend = OpensimBackend()
            chosen = backend.options.model_validate(options)
            return opened.enter_context(backend.open(scene, seed=1, options=chosen))

        yield open_
