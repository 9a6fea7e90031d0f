"""Collada, with pycollada.

As in Gazebo and RViz, the unit of the file is used and its up axis is ignored.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from nrp_core.scene.meshes.stl import mean_color
from nrp_core.scene.meshes.triangles import Coordinates, Surface
from nrp_core.xml import strict_xml

if TYPE_CHECKING:
    from nrp_core.scene.meshes.obj import ReadBeside
    from nrp_core.scene.model import Rgba

_MAX_DEPTH = 100
_INPUT = re.compile(r"<input\b[^<>]*>")
_SHINE = re.compile(r"<(specular|reflective)>.*?</\1>", re.DOTALL)
"""Colours that nothing here uses; a faulty one would cost the shapes of its material."""
_COMMENT = re.compile(r"<!--\s*-->")  # as strict_xml leaves them; pycollada stumbles over them
_UNUSED = re.compile(r"(\ssemantic=[\"'])(?:NORMAL|(?:TEX)?(?:TANGENT|BINORMAL))([\"'])")
_SOURCE = re.compile(r"\ssource=[\"']#([^\"'<>]*)[\"']")
_NUMBERS = re.compile(
    r"(<source\b[^<>]*\sid=[\"']([^\"'<>]*)[\"'][^<>]*>\s*<float_array\b[^<>]*[^/<>]>)[^<]*(?=<)"
)


def parse_collada(data: bytes, beside: ReadBeside) -> list[Surface]:
    """Return the surfaces of a Collada file.

    Raises:
        ValueError: it cannot be read.
    """
    import collada
    from collada.common import DaeError

    text = _without_normals(_SHINE.sub("", _COMMENT.sub("", strict_xml(data))))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PendingDeprecationWarning)  # pycollada uses NumPy's matrices
            document = collada.Collada(io.BytesIO(text.encode()), ignore=[DaeError])
            meter = float(document.assetInfo.unitmeter or 1.0)
            matrix = np.diag([meter, meter, meter, 1.0])
            roots = document.scene.nodes if document.scene else []
            return [part for root in roots for part in _surfaces(root, matrix, frozenset(), beside)]
    except Exception as error:  # pycollada does not wrap errors of its XML library and NumPy
        raise ValueError(f"{type(error).__name__}: {error}") from error


def _without_normals(text: str) -> str:
    """Return a file without the numbers of normals and tangents: unused here, and half of most files.

    Their inputs stay, with another meaning: the places of the other inputs count them.
    """
    unused, used = set[str](), set[str]()

    def renamed(given: re.Match[str]) -> str:
        marked, count = _UNUSED.subn(r"\1UNUSED\2", given[0])
        (unused if count else used).update(_SOURCE.findall(given[0]))
        return marked

    text = _INPUT.sub(renamed, text)
    emptied = unused - used
    return _NUMBERS.sub(lambda found: found[1] if found[2] in emptied else found[0], text)


def _surfaces(
    node: Any, matrix: Any, names: frozenset[str], beside: ReadBeside, depth: int = 0
) -> Iterator[Surface]:
    """Yield the surfaces below a node with the transform ``matrix``, which may be any affine one."""
    if depth > _MAX_DEPTH:
        raise ValueError(f"nodes are nested more than {_MAX_DEPTH} deep")
    if hasattr(node, "children"):
        own = frozenset(filter(None, (node.id, getattr(node, "name", None))))
        for child in node.children:
            yield from _surfaces(child, matrix @ np.asarray(node.matrix), own or names, beside, depth + 1)
    elif hasattr(node, "geometry"):
        geometry = node.geometry
        called = names | frozenset(filter(None, (geometry.id, geometry.name)))
        for bound in node.objects("geometry", matrix):
            for primitive in bound.primitives():
                if hasattr(primitive, "triangleset"):
                    primitive = primitive.triangleset()
                triangles = _triangles(primitive)
                if len(triangles):
                    rgba, image = _look(primitive.material, beside)
                    yield Surface(called, triangles, rgba, _coordinates(primitive), image)


def _triangles(primitive: Any) -> Any:
    """Return the triangles of a primitive; lines have none."""
    if primitive.vertex is None or np.shape(primitive.vertex_index)[1:] != (3,):
        return np.empty((0, 3, 3))
    return np.asarray(primitive.vertex, np.float64)[primitive.vertex_index]


def _coordinates(primitive: Any) -> Coordinates | None:
    """Return the first texture coordinates of triangles, None if they have none."""
    if not len(primitive.texcoordset):
        return None
    places: Coordinates = np.asarray(primitive.texcoordset[0], np.float32)[primitive.texcoord_indexset[0]]
    return places[..., :2]


def _look(material: Any, beside: ReadBeside) -> tuple[Rgba | None, str | None]:
    """Return the emissive or else the diffuse colour of a material, and its image."""
    effect = getattr(material, "effect", None)
    if effect is None:
        return None, None
    for shade in (effect.emission, effect.diffuse):
        image = shade.sampler.surface.image.path if hasattr(shade, "sampler") else None
        color = mean_color(beside(image)) if image else _color(shade)
        if color is not None and (shade is effect.diffuse or any(color)):
            r, g, b = color
            return (r, g, b, _opacity(effect)), image
    return None, None


def _color(shade: Any) -> tuple[float, float, float] | None:
    if shade is None:
        return None
    r, g, b = (min(max(float(part), 0.0), 1.0) for part in shade[:3])
    return r, g, b


def _opacity(effect: Any) -> float:
    """Return the opacity; exporters that write "fully transparent" mean "opaque"."""
    share, color = effect.transparency, effect.transparent
    if color is None or not isinstance(share, (int, float)) or not isinstance(color, (tuple, list)):
        return 1.0
    opacity = 1 - share * sum(color[:3]) / 3 if effect.opaque_mode == "RGB_ZERO" else share * color[3]
    return min(max(float(opacity), 0.0), 1.0) or 1.0
