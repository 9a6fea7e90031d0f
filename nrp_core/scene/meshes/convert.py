"""Convert mesh files of robots to visuals and collisions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from nrp_core.scene.meshes.collada import parse_collada
from nrp_core.scene.meshes.concave import concave_parts
from nrp_core.scene.meshes.convex import convex_pieces, whole_hull
from nrp_core.scene.meshes.gltf import parse_gltf
from nrp_core.scene.meshes.obj import ReadBeside, parse_obj
from nrp_core.scene.meshes.stl import parse_stl
from nrp_core.scene.meshes.triangles import Surface, area_of, concatenate, merge_surfaces
from nrp_core.scene.model import Rgba

MAX_COLORS = 16
"""Maximum number of colours and images of a mesh; the last one is used for all others."""

Form = Literal["whole", "colored", "convex", "hollow", "solid", "hull"]
"""One piece, one piece for each colour or image, convex pieces, or the convex hull of all.

``hollow`` are few convex pieces that leave the inside free, or none if that is not possible;
``solid`` are convex pieces if these have the shape of the mesh, and else parts of its surface.
"""


@dataclass(frozen=True, slots=True)
class Wanted:
    """The part of a mesh to convert, and the form.

    Args:
        form: the pieces.
        submesh: the part of the file to take, empty for all.
        centered: whether the middle of its bounding box is moved to the origin.
        scale: the size of the file's unit along each axis, m; hollow pieces have a thickness in m.
    """

    form: Form
    submesh: str = ""
    centered: bool = False
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


def parse(data: bytes, suffix: str, beside: ReadBeside) -> tuple[list[Surface], int]:
    """Return the surfaces of a mesh file, and the number of omitted triangles.

    A triangle is omitted if a corner is not a number or too far away.

    Args:
        data: its contents.
        suffix: suffix of its name in lower case: one of :data:`KINDS`.
        beside: reads the files that it refers to.

    Raises:
        ValueError: it cannot be read, or has no triangles, or none with an area.
    """
    given = KINDS[suffix](data, beside)
    surfaces = [surface for surface in map(_whole, given) if len(surface.triangles)]
    total, kept = (sum(len(surface.triangles) for surface in some) for some in (given, surfaces))
    if not surfaces:
        raise ValueError(
            f"it has no triangles whose corners are numbers below 1e9 ({total} others)"
            if total
            else "it has no triangles"
        )
    if not any(area_of(surface.triangles) for surface in surfaces):
        raise ValueError("its triangles have no area; is a scale in it 0?")
    return surfaces, total - kept


def pieces_of(surfaces: Sequence[Surface], wanted: Wanted) -> list[Surface]:
    """Return the pieces of a mesh, the largest first.

    Raises:
        ValueError: it has no such submesh.
    """
    if wanted.submesh:
        surfaces = _named(surfaces, wanted.submesh)
    if wanted.centered:
        surfaces = _centered(surfaces)
    if wanted.form == "whole":
        return [replace(merge_surfaces(surfaces), rgba=None, image=None, held=None)]
    if wanted.form == "solid" and (parts := concave_parts(concatenate(surfaces) * wanted.scale)):
        return [replace(part, triangles=part.triangles / wanted.scale) for part in parts]
    if wanted.form == "hollow":
        from nrp_core.scene.meshes.cells import hollow_pieces  # compiled code takes time to load

        found = hollow_pieces(concatenate(surfaces) * wanted.scale)
        return [Surface(frozenset(), piece / wanted.scale) for piece in found]
    if wanted.form in ("convex", "solid"):
        return [Surface(frozenset(), piece) for piece in convex_pieces(concatenate(surfaces))]
    if wanted.form == "hull":
        return [Surface(frozenset(), whole_hull(concatenate(surfaces)))]
    return _by_color(surfaces)


def _stl(data: bytes, _beside: ReadBeside) -> list[Surface]:
    return [Surface(frozenset(), parse_stl(data))]


KINDS: dict[str, Callable[[bytes, ReadBeside], list[Surface]]] = {
    ".stl": _stl,
    ".obj": parse_obj,
    ".dae": parse_collada,
    ".glb": parse_gltf,
    ".gltf": parse_gltf,
}
"""Readers of the file formats."""


def _whole(surface: Surface) -> Surface:
    """Leave out triangles with a corner that is not a number or too far away."""
    usable = (np.abs(surface.triangles) < 1e9).all(axis=(1, 2))
    if usable.all():
        return surface
    mapped = surface.coordinates
    left = None if mapped is None else mapped[usable]
    return replace(surface, triangles=surface.triangles[usable], coordinates=left)


def _named(surfaces: Sequence[Surface], name: str) -> list[Surface]:
    found = [surface for surface in surfaces if name in surface.names]
    if not found:
        valid = ", ".join(sorted({name for surface in surfaces for name in surface.names})) or "none"
        raise ValueError(f"it has no submesh '{name}'; it has: {valid}")
    return found


def _centered(surfaces: Sequence[Surface]) -> list[Surface]:
    points = concatenate(surfaces).reshape(-1, 3)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    return [replace(surface, triangles=surface.triangles - middle) for surface in surfaces]


def _by_color(surfaces: Sequence[Surface]) -> list[Surface]:
    alike: dict[tuple[Rgba | None, str | None], list[Surface]] = {}
    for surface in surfaces:
        alike.setdefault((surface.rgba, surface.image), []).append(surface)
    pieces = sorted(map(merge_surfaces, alike.values()), key=lambda piece: -area_of(piece.triangles))
    shown, rest = pieces[:MAX_COLORS], pieces[MAX_COLORS:]
    return [*shown[:-1], merge_surfaces([shown[-1], *rest])] if rest else shown
