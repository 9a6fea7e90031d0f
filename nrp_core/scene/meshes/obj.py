"""Wavefront OBJ: polygons, names of objects and groups, and the colours of its material files."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from nrp_core.scene.meshes.stl import mean_color
from nrp_core.scene.meshes.triangles import Coordinates, Surface
from nrp_core.scene.model import Rgba

ReadBeside = Callable[[str], bytes | None]
"""Returns the contents of a file that a mesh refers to, None if it is missing."""

Kind = tuple[frozenset[str], str]
"""Names of the object and group, and the material."""


def parse_obj(data: bytes, beside: ReadBeside) -> list[Surface]:
    """Return the surfaces of an OBJ file.

    Raises:
        ValueError: it is not well-formed, or a face names a vertex that does not exist.
    """
    vertices, mapped, parts, libraries = _sorted(_lines(data))
    points = np.loadtxt(vertices, usecols=(1, 2, 3), ndmin=2) if vertices else np.empty((0, 3))
    places = np.loadtxt(mapped, np.float32, usecols=(1, 2), ndmin=2) if mapped else None
    looks = _materials(libraries, beside)
    surfaces = []
    for (names, material), polygons in parts.items():
        faces = polygons.triangles()
        if len(faces) and not (faces.min() >= 0 and faces.max() < len(points)):
            raise ValueError("a face names a vertex that does not exist")
        if len(faces):
            rgba, image = looks.get(material, (None, None))
            surfaces.append(Surface(names, points[faces], rgba, _coordinates(polygons, places), image))
    return surfaces


def _coordinates(polygons: _Polygons, places: npt.NDArray[np.float32] | None) -> Coordinates | None:
    """Return the texture coordinates of faces, None if not each corner has one."""
    if places is None:
        return None
    with suppress(ValueError, IndexError):  # a corner without one
        corners = polygons.triangles(1)
        if corners.min(initial=0) >= 0 and corners.max(initial=-1) < len(places):
            return places[corners]
    return None


def _lines(data: bytes) -> list[str]:
    text = data.decode(errors="replace").replace("\\\n", " ").replace("\\\r\n", " ")
    return list(map(str.lstrip, (re.sub("#.*", "", text) if "#" in text else text).splitlines()))


@dataclass
class _Polygons:
    """Faces with the same name and material.

    Args:
        lines: ``f`` and corners as ``vertex/texture/normal``, counted from 1 or, negative, from the end.
        counts: how many vertices and texture coordinates the file had before each of them.
    """

    lines: list[str] = field(default_factory=list)
    counts: list[tuple[int, int]] = field(default_factory=list)

    def triangles(self, part: Literal[0, 1] = 0) -> npt.NDArray[np.int64]:
        """Return indices of vertices from 0, shape ``(m, 3)``; polygons of two corners have no triangle.

        Args:
            part: 0 for vertices, 1 for texture coordinates.
        """
        rows = [line.split()[1:] for line in self.lines]
        lengths = np.array(list(map(len, rows)))
        numbers = np.array([int(corner.split("/")[part]) for row in rows for corner in row], np.int64)
        if (numbers == 0).any():
            raise ValueError("a face names the vertex 0; vertices are numbered from 1")
        before = [count[part] for count in self.counts]
        corners = np.where(numbers > 0, numbers - 1, numbers + np.repeat(before, lengths))
        starts = np.cumsum(lengths) - lengths
        fans = [np.empty((0, 3), np.int64)]
        for number in range(2, int(lengths.max(initial=0))):
            first = starts[lengths > number]
            fans.append(
                np.stack([corners[first], corners[first + number - 1], corners[first + number]], axis=1)
            )
        return np.concatenate(fans)


def _sorted(lines: Iterable[str]) -> tuple[list[str], list[str], dict[Kind, _Polygons], list[str]]:
    """Return the lines of vertices and of texture coordinates, the faces by kind, and the libraries."""
    names = {"o": "", "g": "", "usemtl": ""}
    vertices: list[str] = []
    mapped: list[str] = []
    libraries: list[str] = []
    found: dict[Kind, _Polygons] = {}
    current = None
    for line in lines:
        keyword = line[0] if line[1:2] == " " else "".join(line.split(None, 1)[:1])
        if keyword == "v":
            vertices.append(line)
        elif keyword == "f":
            if current is None:
                owner = frozenset(filter(None, (names["o"], names["g"])))
                current = found.setdefault((owner, names["usemtl"]), _Polygons())
            current.lines.append(line)
            current.counts.append((len(vertices), len(mapped)))
        elif keyword == "vt":
            mapped.append(line)
        elif keyword in names:
            names[keyword] = _rest(line)
            current = None
        elif keyword == "mtllib":
            libraries.append(_rest(line))
    return vertices, mapped, found, libraries


def _rest(line: str) -> str:
    return " ".join(line.split()[1:])


def _materials(libraries: Iterable[str], beside: ReadBeside) -> dict[str, tuple[Rgba, str | None]]:
    return {
        name: _look(properties, beside)
        for library in libraries
        for name, properties in _library(beside(library) or b"").items()
    }


def _library(data: bytes) -> dict[str, dict[str, list[str]]]:
    """Return the properties of each material in a material file, by name."""
    materials: dict[str, dict[str, list[str]]] = {}
    properties: dict[str, list[str]] = {}
    for row in filter(None, map(str.split, _lines(data))):
        if row[0] == "newmtl":
            properties = materials.setdefault(" ".join(row[1:]), {})
        properties[row[0]] = row[1:]
    return materials


def _look(properties: dict[str, list[str]], beside: ReadBeside) -> tuple[Rgba, str | None]:
    """Return the colour of a material, and its image if it can be read."""
    image = properties["map_Kd"][-1] if properties.get("map_Kd") else None
    mean = mean_color(beside(image)) if image else None
    r, g, b = mean or _numbers(properties, "Kd", 3, 0.8)
    (opacity,) = _numbers(properties, "d", 1, 1.0)
    return (r, g, b, opacity), image if mean else None


def _numbers(properties: dict[str, list[str]], name: str, count: int, default: float) -> tuple[float, ...]:
    values = [float(word) for word in properties.get(name, ())[:count]]
    values += [default] * (count - len(values))
    return tuple(min(max(value, 0.0), 1.0) for value in values)
