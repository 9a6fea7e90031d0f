"""Shapes in SDF: their textures, replacements of missing meshes, and the collisions of contact sensors."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from nrp_core.errors import SceneError, did_you_mean
from nrp_core.findings import Code
from nrp_core.scene.bodies import Shape
from nrp_core.scene.consistency import rigid_groups
from nrp_core.scene.devices import MountedSensor
from nrp_core.scene.meshes import MAX_BYTES_BESIDE, Piece, digest, mesh_pieces
from nrp_core.scene.meshes.convert import Form, Wanted
from nrp_core.scene.meshes.shapes import (
    Heights,
    cached_meshes,
    extrude,
    heights_in,
    terrain,
    unit_solid,
)
from nrp_core.scene.model import (
    Box,
    Capsule,
    ConcaveMesh,
    Cylinder,
    Geometry,
    Heightmap,
    Joint,
    Link,
    Mesh,
    Plane,
    Sphere,
    Texture,
)
from nrp_core.scene.reading.context import Element, Reading
from nrp_core.scene.rigid import Pose, Vector

_UNSCALED: Final = (1.0, 1.0, 1.0)
_LUMP: Final = "_fixed_joint_lump__"
"""What Gazebo Classic writes into the name of a collision of a link that is fixed to another one."""
_ADDED: Final = re.compile(r"(_collision)?(_\d+)?$")
"""What it adds at the end of such a name."""


def with_contact_collisions(links: Sequence[Link], joints: Sequence[Joint]) -> tuple[Link, ...]:
    """Return links whose contact sensors use the collision names of this scene.

    A sensor has them in a field ``collisions``. One of another link is ``link::collision``, and the name of
    a missing one does not change.
    """
    fixed = [(joint.parent, joint.child) for joint in joints if joint.kind == "fixed"]
    groups = rigid_groups({each for ends in fixed for each in ends} | {link.name for link in links}, fixed)
    owned = {link.name: [each.name for each in link.collisions] for link in links}

    def resolve(sensor: MountedSensor, link: str) -> MountedSensor:
        names: Sequence[str] = getattr(sensor, "collisions", ())
        kept: dict[str, Any] = {
            "collisions": tuple(_found(name, link, groups[link], owned) or name for name in names)
        }
        return replace(sensor, **kept) if names and kept["collisions"] != names else sensor

    return tuple(
        replace(link, sensors=tuple(resolve(each, link.name) for each in link.sensors)) for link in links
    )


def _found(name: str, link: str, fixed: set[str], owned: Mapping[str, Sequence[str]]) -> str:
    """Return the name of a collision from the link of its sensor; empty if it does not exist."""
    if name in owned[link]:
        return name
    for candidate in _candidates(name):
        for owner in (link, *sorted(fixed - {link})):
            if candidate in owned.get(owner, ()):
                return candidate if owner == link else f"{owner}::{candidate}"
    return ""


def _candidates(name: str) -> Iterator[str]:
    """Yield the names in a file that a name of Gazebo Classic may refer to."""
    inner = name.rpartition(_LUMP)[2]
    yield inner
    yield re.sub(r"_\d+$", "", inner)
    yield _ADDED.sub("", inner)


def texture_of(image: Path | None, tint: Vector = (1.0, 1.0, 1.0)) -> Texture | None:
    """Return the texture of an image file; None for none."""
    if image is None:
        return None
    try:
        return Texture(image, tint, _digest(image, image.stat().st_mtime_ns))
    except OSError:
        return Texture(image, tint)


@lru_cache(maxsize=256)
def _digest(image: Path, _changed_ns: int) -> str:
    return digest(image.read_bytes())


_SHAPES = (
    "box", "cylinder", "capsule", "cone", "ellipsoid", "sphere", "plane", "mesh", "polyline", "heightmap",
    "empty",
)  # fmt: skip
_NOT_READ = ("image",)
MAX_EXCESS = 0.02
"""Maximum volume of convex hulls beyond that of a mesh, as a share of it, without a warning."""
DEFAULT_SIZES = {
    "box": {"size": "1 1 1"},
    "sphere": {"radius": "1"},
    "cylinder": {"radius": "1", "length": "1"},
    "capsule": {"radius": "0.5", "length": "1"},
    "cone": {"radius": "0.5", "length": "1"},
    "ellipsoid": {"radii": "1 1 1"},
}
"""The sizes of shapes that do not state them, from the specification (``sdf/1.11/*_shape.sdf``)."""


def read_geometry(
    element: Element,
    form: Form,
    reading: Reading,
    *,
    static: bool,
    alone: bool = False,
    weighed: bool = False,
) -> list[Shape]:
    """Read a ``<geometry>``.

    Args:
        element: the element.
        form: the form of meshes.
        reading: the context of the reading.
        static: whether it belongs to a static model.
        alone: whether its link is the only one of its model; other objects may then be in or under it.
        weighed: whether its link has an inertia, so that the shapes need not have the volume of the body.

    Returns:
        The shapes in the element's frame (a plane's normal need not be z): several if a mesh has several
        colours or convex pieces; none, with a warning, if they cannot be read.

    Raises:
        SceneError: a size is missing or not positive, or the shape is unknown.
    """
    shape = _shape(element)
    others = [child.tag for child in element.children if child.tag in _SHAPES and child.tag != shape.tag]
    if others:
        ignored = ", ".join(f"<{tag}>" for tag in others)
        message = f"a <geometry> has one shape: <{shape.tag}> is used, and not {ignored}"
        reading.notes.warn(element, Code.NRP383, message)
    if shape.tag == "plane":
        return [_plane(shape)]
    if shape.tag == "mesh":
        form = "solid" if static and form == "convex" else form
        alone = alone and form == "convex"
        return _mesh(shape, form, reading, alone=alone, hollow=alone and weighed)
    if shape.tag == "polyline":
        return _polyline(element.all("polyline"), form, reading)
    if shape.tag == "heightmap":
        return _heightmap(shape, form, reading, static)
    if shape.tag in _NOT_READ:
        reading.notes.warn(
            shape,
            Code.NRP258,
            f"shapes of kind <{shape.tag}> are not supported: replaced by a simple shape",
            subject=shape.tag,
        )
        return []
    return [Shape(_solid(_with_sizes(shape, reading)), Pose())]


def is_empty(element: Element) -> bool:
    """Return whether a ``<geometry>`` is without a shape on purpose."""
    return _shape(element).tag == "empty"


def is_point(element: Element) -> bool:
    """Return whether all sizes of the shape in a ``<geometry>`` are 0, or a factor of a mesh is.

    Some files have such for frames; Gazebo saves a mesh of scale 0 unchanged.
    """
    shape = _shape(element)
    if shape.tag == "mesh":
        scale = shape.find("scale")
        return scale is not None and not all(scale.numbers(3))
    sizes = DEFAULT_SIZES.get(shape.tag, {})
    stated = [(size, default) for tag, default in sizes.items() if (size := shape.find(tag)) is not None]
    if not stated or len(stated) < len(sizes):  # a default size is none of 0
        return False
    return not any(any(size.numbers(len(default.split()))) for size, default in stated)


def _shape(element: Element) -> Element:
    shapes = [child for child in element.children if ":" not in child.tag]
    element.find(*(child.tag for child in shapes[:1]))
    element.pass_over(*{*_SHAPES, *_NOT_READ} - {child.tag for child in shapes[:1]})
    if not shapes:
        raise element.error(f"<geometry> needs a shape; valid: {', '.join(_SHAPES)}")
    return shapes[0]


def _with_sizes(shape: Element, reading: Reading) -> Element:
    """Return a shape with all its sizes; one that is missing causes a warning."""
    sizes = DEFAULT_SIZES.get(shape.tag, {})
    missing = {tag: size for tag, size in sizes.items() if shape.find(tag) is None}
    for tag, size in missing.items():
        message = f"<{shape.tag}> has no <{tag}>: {size} m is used"
        reading.notes.warn(shape, Code.NRP264, message, subject=tag)
    added = [
        Element(tag, {}, shape.path, shape.line, text=size, kind=shape.kind) for tag, size in missing.items()
    ]
    return replace(shape, children=[*shape.children, *added])


def _solid(shape: Element) -> Geometry:
    match shape.tag:
        case "box":
            x, y, z = shape.require("size").all_positive(3)
            return Box((x, y, z))
        case "sphere":
            return Sphere(shape.positive("radius"))
        case "cylinder":
            return Cylinder(shape.positive("radius"), shape.positive("length"))
        case "capsule":
            return Capsule(shape.positive("radius"), shape.positive("length"))
        case "cone":
            radius = shape.positive("radius")
            return Mesh(unit_solid("cone"), (radius, radius, shape.positive("length")))
        case "ellipsoid":
            x, y, z = shape.require("radii").all_positive(3)
            return Mesh(unit_solid("ellipsoid"), (x, y, z))
        case tag:
            raise shape.error(f"unknown shape <{tag}>{did_you_mean(tag, _SHAPES)}")


def _plane(shape: Element) -> Shape:
    size = shape.find("size")
    width, depth = size.all_positive(2) if size else (100.0, 100.0)
    return Shape(Plane((width, depth)), Pose.pointing(shape.direction("normal", (0.0, 0.0, 1.0))))


def _mesh(shape: Element, form: Form, reading: Reading, *, alone: bool, hollow: bool) -> list[Shape]:
    """Return the pieces of a mesh, or none with a warning; another volume causes one, too."""
    uri = shape.require("uri")
    scale = shape.find("scale")
    x, y, z = scale.numbers(3) if scale else (1.0, 1.0, 1.0)
    size = (abs(x), abs(y), abs(z)) if x and y and z else _UNSCALED
    try:
        pieces = _pieces(uri, _wanted(shape, "hollow", size), reading) if hollow and x and y and z else []
        pieces = pieces or _pieces(uri, _wanted(shape, form, size if form == "solid" else _UNSCALED), reading)
    except SceneError as error:
        subject = _missing_package(uri, reading)
        message = f"the package '{subject}' is not there: its meshes are replaced by simple shapes"
        if not subject:
            subject = uri.text
            message = f"the mesh '{subject}' {error.message}: replaced by a simple shape"
        alike = "missing mesh" if reading.resources.find(uri) is None else f"mesh {error.message}"
        reading.notes.warn(uri, Code.NRP258, message, subject=subject, alike=alike)
        return []
    if pieces[0].left_out:
        left_out = f"{pieces[0].left_out} triangles of the mesh '{uri.text}' are left out"
        message = f"{left_out}: a corner is not a number below 1e9"
        reading.notes.warn(uri, Code.NRP258, message, subject=uri.text)
    if alone and pieces[0].excess > MAX_EXCESS:
        more = f"{100 * pieces[0].excess:.0f} % more volume, because it moves"
        message = f"the mesh '{uri.text}' collides as convex hulls with {more}"
        reading.notes.warn(uri, Code.NRP258, message, subject=uri.text)
    return [
        Shape(_geometry(piece, (x, y, z)), Pose(), piece.rgba, texture_of(piece.image)) for piece in pieces
    ]


def _missing_package(uri: Element, reading: Reading) -> str:
    """Return the package of a mesh if it is missing, else nothing."""
    scheme, _, rest = uri.text.partition("://")
    package, _, inner = rest.partition("/")
    if scheme not in ("package", "model") or not package or not inner:
        return ""
    try:
        reading.resources.package(package, uri.path)
    except SceneError:
        return package
    return ""


def _geometry(piece: Piece, scale: Vector) -> Mesh:
    if piece.depth is None:
        return Mesh(piece.path, scale)
    return ConcaveMesh(piece.path, scale, piece.depth)


def _polyline(lines: Sequence[Element], form: Form, reading: Reading) -> list[Shape]:
    """Return the area within lines, extruded to the height of the first one, or none with a warning."""
    height = lines[0].positive("height", 1.0)
    rings = [np.array([point.numbers(2) for point in line.all("point")]).reshape(-1, 2) for line in lines]
    convex = form == "convex"
    key = digest("polyline", [ring.tolist() for ring in rings], height, convex)
    try:
        paths = cached_meshes(key, lambda: extrude(rings, height, convex=convex))
    except ValueError as error:
        reading.notes.warn(
            lines[0], Code.NRP258, f"the polyline is not usable, {error}: replaced by a simple shape"
        )
        return []
    return [Shape(Mesh(path), Pose()) for path in paths]


def _heightmap(shape: Element, form: Form, reading: Reading, static: bool) -> list[Shape]:
    """Return the terrain of a height map, or none with a warning."""
    uri = shape.require("uri")
    size, pos = shape.find("size"), shape.find("pos")
    x, y, z = size.all_positive(3) if size else (1.0, 1.0, 1.0)
    across, along, up = pos.numbers(3) if pos else (0.0, 0.0, 0.0)
    try:
        heights = _heights(uri, reading, static)
    except (SceneError, ValueError) as error:
        reason = error.message if isinstance(error, SceneError) else error
        reading.notes.warn(
            uri,
            Code.NRP258,
            f"the height map '{uri.text}' {reason}: replaced by a simple shape",
            subject=uri.text,
        )
        return []
    (path,) = cached_meshes(digest("terrain", heights.shape, heights.tobytes()), lambda: [terrain(heights)])
    ground = Heightmap(path, (x, y, z), *heights.shape) if form == "convex" else Mesh(path, (x, y, z))
    return [Shape(ground, Pose((across, along, up)))]


def _heights(uri: Element, reading: Reading, static: bool) -> Heights:
    if not static:
        raise SceneError("belongs to a model that is not <static>")
    path = reading.resources.find(uri)
    if path is None:
        raise SceneError("is not there")
    if path.stat().st_size > MAX_BYTES_BESIDE:
        raise SceneError(f"is larger than {MAX_BYTES_BESIDE / 1e6:.0f} MB")
    return np.load(path).astype(np.float64) if path.suffix == ".npy" else heights_in(path.read_bytes())


def _pieces(uri: Element, wanted: Wanted, reading: Reading) -> list[Piece]:
    path = reading.resources.find(uri)
    if path is None:
        raise SceneError("is not there")
    return mesh_pieces(path, wanted)


def _wanted(shape: Element, form: Form, scale: Vector) -> Wanted:
    submesh = shape.section("submesh")
    if form in ("convex", "hollow", "solid") and shape.attributes.get("optimization") == "convex_hull":
        form = "hull"
    return Wanted(form, submesh.word("name"), submesh.flag("center", False), scale)
