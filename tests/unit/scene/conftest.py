"""SDF texts as files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from nrp_core.scene.meshes.triangles import Triangles
from nrp_core.scene.model import Model, Scene
from nrp_core.scene.sdf import read_model, read_scene


@pytest.fixture(scope="session")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(autouse=True)
def _own_cache(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep what is converted or unpacked apart from the user's."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))


@pytest.fixture
def tetrahedron() -> Triangles:
    """The one with three edges of 1 m along the axes, from outside; its volume is 1/6 m^3."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], float)
    return corners[[(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]]


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Write the contents of an <sdf> to a file."""

    def write_sdf(body: str, *, version: str = "1.9", name: str = "robot.sdf") -> Path:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f'<?xml version="1.0"?>\n<sdf version="{version}">\n{body}\n</sdf>\n')
        return path

    return write_sdf


@pytest.fixture
def model(write: Callable[..., Path]) -> Callable[..., Model]:
    """Read the contents of a <model>, the first line of which is line 4 of the file."""

    def read(body: str, *, version: str = "1.9", **options: object) -> Model:
        path = write(f'<model name="robot">\n{body}\n</model>', version=version)
        return read_model(path, **options)  # type: ignore[arg-type]

    return read


@pytest.fixture
def link(model: Callable[..., Model]) -> Callable[..., object]:
    """Read the contents of a <link>, the first line of which is line 5 of the file."""

    def read(body: str) -> object:
        return model(f'<link name="base">\n{body}\n</link>').links[0]

    return read


@pytest.fixture
def world(write: Callable[..., Path]) -> Callable[..., Scene]:
    """Read the contents of a <world>, the first line of which is line 4 of the file."""

    def read(body: str, *, version: str = "1.9", **options: object) -> Scene:
        path = write(f'<world name="room">\n{body}\n</world>', version=version, name="room.sdf")
        return read_scene(path, **options)  # type: ignore[arg-type]

    return read
