"""Solids that not all engines have, as cached meshes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import pi
from pathlib import Path

from nrp_core._support.disk_cache import kept_folder
from nrp_core.world.scene.meshes.stl import write_stl
from nrp_core.world.scene.meshes.triangles import Triangles
from nrp_core.world.scene.meshes.turned import Profile, arc, turned

_PROFILES: dict[str, Profile] = {
    "ellipsoid": arc(1.0, -pi / 2, 0.0) + arc(1.0, 0.0, pi / 2)[1:],
    "cone": [(0.0, -0.5), (1.0, -0.5), (0.0, 0.5)],
}
_VERSION = 1


def kept_meshes(key: str, make: Callable[[], Sequence[Triangles]]) -> list[Path]:
    """Return the files of meshes, which are created at the first request.

    Args:
        key: names them and everything that they depend on.
        make: creates them.
    """

    def fill(folder: Path) -> None:
        for number, triangles in enumerate(make()):
            write_stl(folder / f"{key}-{number:04}.stl", triangles)

    folder = kept_folder("meshes", key, fill, lambda folder: any(folder.glob("*.stl")))
    return sorted(folder.glob("*.stl"))


def unit_solid(kind: str) -> Path:
    """Return the file of an ``ellipsoid`` or a ``cone`` about its centre, of radius 1; a cone is 1 m high."""

    def make() -> list[Triangles]:
        vertices, faces = turned(_PROFILES[kind])
        return [vertices[faces]]

    (path,) = kept_meshes(f"unit-{kind}-{_VERSION}", make)
    return path
