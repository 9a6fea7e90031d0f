"""Solids that engines do not all have, as meshes of unit size that a scene scales."""

from __future__ import annotations

from math import pi
from pathlib import Path

from nrp_core.cache import kept_folder
from nrp_core.world.scene.meshes.stl import write_stl
from nrp_core.world.scene.meshes.turned import Profile, arc, turned

_PROFILES: dict[str, Profile] = {
    "ellipsoid": arc(1.0, -pi / 2, 0.0) + arc(1.0, 0.0, pi / 2)[1:],
    "cone": [(0.0, -0.5), (1.0, -0.5), (0.0, 0.5)],
}
_VERSION = 1


def unit_solid(kind: str) -> Path:
    """Return the file of an ``ellipsoid`` or a ``cone`` about its centre, of radius 1; a cone is 1 m high."""

    def fill(folder: Path) -> None:
        vertices, faces = turned(_PROFILES[kind])
        write_stl(folder / name, vertices[faces])

    name = f"unit-{kind}-{_VERSION}.stl"
    kept = kept_folder("meshes", Path(name).stem, fill, lambda folder: (folder / name).is_file())
    return kept / name
