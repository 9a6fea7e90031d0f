"""Wavefront OBJ: polygons, names of objects and groups, and the colours of its material files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from nrp_core.world.scene.meshes.pictures import mean_color
from nrp_core.world.scene.meshes.triangles import Surface
from nrp_core.world.scene.model import Rgba

ReadBeside = Callable[[str], bytes | None]
"""Returns the contents of a file that a mesh refers to, None where it is not there."""

Kind = tuple[frozenset[str], str]
"""Names of the object and group, and the material."""


def parse_obj(data: bytes, beside: ReadBeside) -> list[Surface]:
    """Return the surfaces of an OBJ file.

    Raises:
        ValueError: it is not well-formed, or a face names a vertex that is not there.
    """
    rows = list(_rows(data))
    vertices = np.array([row[1:4] for row in rows if row[0] == "v"], float).reshape(-1, 3)
    colors = _materials(rows, beside)
    surfaces = []
    for (names, material), polygons in _polygons(rows).items():
        faces = polygons.triangles()
        if len(faces) and not (faces.min() >= 0 and faces.max() < len(vertices)):
            raise ValueError("a face names a vertex that is not there")
        if len(faces):
            surfaces.append(Surface(names, vertices[faces], colors.get(material)))
    return surfaces


def _rows(data: bytes) -> Iterator[list[str]]:
    for line in data.decode(errors="replace").replace("\\\n", " ").splitlines():
        row = (line.partition("#")[0] if "#" in line else line).split()
        if row:
            yield row


@dataclass
class _Polygons:
    """Faces of one name and material.

    Args:
        rows: their corners as ``vertex/texture/normal``, counted from 1 or, negative, from the end.
        counts: how many vertices the file had before each of them.
    """

    rows: list[list[str]] = field(default_factory=list)
    counts: list[int] = field(default_factory=list)

    def triangles(self) -> npt.NDArray[np.int64]:
        """Return indices of vertices from 0, shape ``(m, 3)``; polygons of two corners have no triangle."""
        lengths = np.array([len(row) for row in self.rows])
        numbers = np.array([corner.partition("/")[0] for row in self.rows for corner in row], np.int64)
        if (numbers == 0).any():
            raise ValueError("a face names the vertex 0; they count from 1")
        corners = np.where(numbers > 0, numbers - 1, numbers + np.repeat(self.counts, lengths))
        starts = np.cumsum(lengths) - lengths
        fans = [np.empty((0, 3), np.int64)]
        for number in range(2, int(lengths.max(initial=0))):
            first = starts[lengths > number]
            fans.append(
                np.stack([corners[first], corners[first + number - 1], corners[first + number]], axis=1)
            )
        return np.concatenate(fans)


def _polygons(rows: Iterable[list[str]]) -> dict[Kind, _Polygons]:
    """Return the faces by the name and material that they come under."""
    names = {"o": "", "g": "", "usemtl": ""}
    count = 0
    found: dict[Kind, _Polygons] = {}
    current = None
    for row in rows:
        if row[0] == "v":
            count += 1
        elif row[0] in names:
            names[row[0]] = " ".join(row[1:])
            current = None
        elif row[0] == "f":
            if current is None:
                owner = frozenset(filter(None, (names["o"], names["g"])))
                current = found.setdefault((owner, names["usemtl"]), _Polygons())
            current.rows.append(row[1:])
            current.counts.append(count)
    return found


def _materials(rows: Iterable[list[str]], beside: ReadBeside) -> dict[str, Rgba]:
    colors: dict[str, Rgba] = {}
    for row in rows:
        if row[0] == "mtllib":
            for name, properties in _library(beside(" ".join(row[1:])) or b"").items():
                colors[name] = _color(properties, beside)
    return colors


def _library(data: bytes) -> dict[str, dict[str, list[str]]]:
    """Return what a material file says of each material, by its name."""
    materials: dict[str, dict[str, list[str]]] = {}
    properties: dict[str, list[str]] = {}
    for row in _rows(data):
        if row[0] == "newmtl":
            properties = materials.setdefault(" ".join(row[1:]), {})
        properties[row[0]] = row[1:]
    return materials


def _color(properties: dict[str, list[str]], beside: ReadBeside) -> Rgba:
    picture = properties.get("map_Kd")
    r, g, b = (mean_color(beside(picture[-1])) if picture else None) or _numbers(properties, "Kd", 3, 0.8)
    (opacity,) = _numbers(properties, "d", 1, 1.0)
    return r, g, b, opacity


def _numbers(properties: dict[str, list[str]], name: str, count: int, default: float) -> tuple[float, ...]:
    values = [float(word) for word in properties.get(name, ())[:count]]
    values += [default] * (count - len(values))
    return tuple(min(max(value, 0.0), 1.0) for value in values)
