"""Shapes as SDF writes them, and what stands in for a mesh that cannot be had."""

from __future__ import annotations

from nrp_core.errors import did_you_mean
from nrp_core.world.scene.model import Box, Capsule, Cylinder, Geometry, Mesh, Plane, Sphere
from nrp_core.world.scene.pose import Pose
from nrp_core.world.scene.reading import Reading
from nrp_core.world.scene.xml_tree import Element

MESH_KINDS = (".stl", ".obj")
MAX_MESH_BYTES = 200_000_000

_SHAPES = ("box", "cylinder", "capsule", "sphere", "plane", "mesh", "empty")
_NOT_READ = ("cone", "ellipsoid", "heightmap", "image", "polyline")


def read_geometry(element: Element, reading: Reading) -> tuple[Geometry, Pose] | None:
    """Read a ``<geometry>``.

    Returns:
        The shape and its pose in the element's frame (a plane's normal need not be z); None, with a
        warning, where it cannot be had.

    Raises:
        SceneError: a size is missing or not positive, or there is no such shape.
    """
    shape = _shape(element)
    if shape.tag == "plane":
        return _plane(shape)
    if shape.tag == "mesh":
        mesh = _mesh(shape, reading)
        return (mesh, Pose()) if mesh else None
    if shape.tag in _NOT_READ:
        reading.notes.warn(shape, f"shapes of kind <{shape.tag}> are not read: a simple shape stands in")
        return None
    return _solid(shape), Pose()


def is_empty(element: Element) -> bool:
    """Tell whether a ``<geometry>`` is without a shape on purpose."""
    return _shape(element).tag == "empty"


def _shape(element: Element) -> Element:
    shapes = [child for child in element.children if ":" not in child.tag]
    if not shapes:
        raise element.error(f"<geometry> needs a shape; valid: {', '.join(_SHAPES)}")
    return shapes[0]


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
        case tag:
            raise shape.error(f"there is no shape <{tag}>{did_you_mean(tag, _SHAPES)}")


def _plane(shape: Element) -> tuple[Geometry, Pose]:
    size = shape.find("size")
    width, depth = size.all_positive(2) if size else (100.0, 100.0)
    return Plane((width, depth)), Pose.pointing(shape.direction("normal", (0.0, 0.0, 1.0)))


def _mesh(shape: Element, reading: Reading) -> Mesh | None:
    """Return a mesh, or None with a warning."""
    uri = shape.require("uri")
    scale = shape.find("scale")
    x, y, z = scale.numbers(3) if scale else (1.0, 1.0, 1.0)
    if not x * y * z:
        raise shape.error(f"the scale of the mesh is '{x:g} {y:g} {z:g}'; no factor may be 0")
    path = reading.resources.find(uri)
    reason = ""
    if path is None:
        reason = "is not there"
    elif path.suffix.lower() not in MESH_KINDS:
        reason = f"is not of a kind that is read ({', '.join(MESH_KINDS)})"
    elif path.stat().st_size > MAX_MESH_BYTES:
        reason = f"is larger than {MAX_MESH_BYTES / 1e6:.0f} MB"
    if path is None or reason:
        reading.notes.warn(uri, f"the mesh '{uri.text}' {reason}: a simple shape stands in")
        return None
    if shape.find("submesh") is not None:
        reading.notes.warn(shape, "a <submesh> is not picked out: the whole mesh is used")
    return Mesh(path, (x, y, z))
