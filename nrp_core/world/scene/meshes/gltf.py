"""glTF 2.0, as one binary file or with files beside it (https://registry.khronos.org/glTF/specs/2.0/).

As in Gazebo, coordinates are used as they are: the file's convention that y is up is not applied.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote_to_bytes

import numpy as np
import numpy.typing as npt

from nrp_core.world.rigid.matrices import matrix_of
from nrp_core.world.rigid.pose import Pose
from nrp_core.world.scene.meshes.images import mean_color
from nrp_core.world.scene.meshes.triangles import Coordinates, Surface

if TYPE_CHECKING:
    from nrp_core.world.scene.meshes.obj import ReadBeside
    from nrp_core.world.scene.model import Rgba

_MAGIC, _HEADER, _CHUNK, _JSON = b"glTF", 12, 8, b"JSON"
_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_PARTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_UNDERSTOOD = ("KHR_materials", "KHR_texture_transform", "KHR_lights", "KHR_mesh_quantization")
_GAMMA = 2.2  # factors are linear, colours here are sRGB
_MAX_NODES = 100_000


def parse_gltf(data: bytes, beside: ReadBeside) -> list[Surface]:
    """Return the surfaces of the scene of a file.

    Raises:
        ValueError: it cannot be read, or is compressed.
    """
    try:
        file = _File(data, beside)
        with np.errstate(invalid="ignore", over="ignore"):  # triangles without numbers are left out later
            return [each for node in file.roots for each in file.surfaces(node, np.eye(4), frozenset())]
    except (LookupError, TypeError, AttributeError, OverflowError, RecursionError) as error:
        raise ValueError(f"it is not valid glTF: {type(error).__name__}: {error}") from error


class _File:
    """The document of a file, its buffers and its images."""

    def __init__(self, data: bytes, beside: ReadBeside) -> None:
        text, self._binary = _chunks(data) if data[:4] == _MAGIC else (data, b"")
        self._document: dict[str, Any] = json.loads(text)
        self._beside = beside
        self._visited: set[int] = set()
        for name in self._document.get("extensionsRequired", ()):
            if not name.startswith(_UNDERSTOOD):
                raise ValueError(f"it needs the extension {name}, which is not supported: export without it")
        self._buffers = [self._buffer(each) for each in self._all("buffers")]

    def _all(self, what: str) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = self._document.get(what, [])
        return found

    @property
    def roots(self) -> list[int]:
        """The nodes at the top of the scene."""
        scenes = self._all("scenes")
        if scenes:
            return list(scenes[self._document.get("scene", 0)].get("nodes", []))
        below = {child for node in self._all("nodes") for child in node.get("children", [])}
        return [number for number in range(len(self._all("nodes"))) if number not in below]

    def _buffer(self, buffer: dict[str, Any]) -> bytes:
        if "uri" not in buffer:
            return self._binary
        data = self._contents(buffer["uri"])
        if data is None:
            raise ValueError(f"its file '{buffer['uri']}' is missing")
        return data

    def _contents(self, uri: str) -> bytes | None:
        if not uri.startswith("data:"):
            return self._beside(uri)
        head, _, body = uri.partition(",")
        return base64.b64decode(body) if head.endswith(";base64") else unquote_to_bytes(body)

    def surfaces(
        self, number: int, above: npt.NDArray[np.float64], names: frozenset[str]
    ) -> Iterator[Surface]:
        """Yield the surfaces of a node and of those below it.

        Args:
            number: the node.
            above: the transform of its parent, shape ``(4, 4)``.
            names: names of its parent.
        """
        if number in self._visited or len(self._visited) > _MAX_NODES:
            raise ValueError(f"its nodes are not a tree of at most {_MAX_NODES:,}")
        self._visited.add(number)
        node = self._all("nodes")[number]
        names = frozenset({node["name"]}) if node.get("name") else names
        matrix = above @ _transform(node)
        if "mesh" in node:
            mesh = self._all("meshes")[node["mesh"]]
            called = names | frozenset(filter(None, [mesh.get("name")]))
            for primitive in mesh["primitives"]:
                yield from self._primitive(primitive, matrix, called)
        for child in node.get("children", []):
            yield from self.surfaces(child, matrix, names)

    def _primitive(
        self, primitive: dict[str, Any], matrix: npt.NDArray[np.float64], names: frozenset[str]
    ) -> Iterator[Surface]:
        points = self._numbers(primitive["attributes"]["POSITION"]).astype(float)
        order = np.arange(len(points))
        if "indices" in primitive:
            order = self._numbers(primitive["indices"]).ravel().astype(np.int64)
        faces = _faces(order, primitive.get("mode", _TRIANGLES))
        if not len(faces):
            return
        if np.linalg.det(matrix[:3, :3]) < 0:
            faces = faces[:, ::-1]
        placed = points @ matrix[:3, :3].T + matrix[:3, 3]
        rgba, image, held, channel = self._look(primitive)
        places = primitive["attributes"].get(f"TEXCOORD_{channel}")
        mapped: Coordinates | None = None
        if places is not None:
            mapped = self._numbers(places).astype(np.float32)[faces]
            mapped[..., 1] = 1 - mapped[..., 1]  # it counts from the top
        yield Surface(names, placed[faces], rgba, mapped, image, held)

    def _look(self, primitive: dict[str, Any]) -> tuple[Rgba | None, str | None, bytes | None, int]:
        """Return colour, name of the image, its contents if they are in the file, and its coordinates."""
        if "material" not in primitive:
            return None, None, None, 0
        material = self._all("materials")[primitive["material"]]
        base = material.get("pbrMetallicRoughness", {})
        *factor, alpha = base.get("baseColorFactor", [1.0] * 4)
        red, green, blue = (min(max(part, 0.0), 1.0) ** (1 / _GAMMA) for part in factor)
        alpha = 1.0 if material.get("alphaMode", "OPAQUE") == "OPAQUE" else alpha
        texture = base.get("baseColorTexture")
        if texture is None:
            return (red, green, blue, alpha), None, None, 0
        source = self._all("textures")[texture["index"]].get("source")
        name, data, held = self._image(source) if source is not None else ("", None, False)
        mean = mean_color(data)
        if mean is None:
            return (red, green, blue, alpha), None, None, 0
        rgba = red * mean[0], green * mean[1], blue * mean[2], alpha
        return rgba, name, data if held else None, texture.get("texCoord", 0)

    def _image(self, number: int) -> tuple[str, bytes | None, bool]:
        """Return the name of an image, its contents, and whether they are in the file."""
        image = self._all("images")[number]
        if "bufferView" in image:
            view = self._all("bufferViews")[image["bufferView"]]
            start = view.get("byteOffset", 0)
            data = self._buffers[view["buffer"]][start : start + view["byteLength"]]
            return f"image {number}", data, True
        uri = image["uri"]
        inside = uri.startswith("data:")
        return f"image {number}" if inside else uri, self._contents(uri), inside

    def _numbers(self, number: int) -> npt.NDArray[Any]:
        """Return the numbers of an accessor, a row for each element; normalised integers as 0..1."""
        accessor = self._all("accessors")[number]
        if "sparse" in accessor or "bufferView" not in accessor:
            raise ValueError("it has sparse numbers, which are not supported")
        view = self._all("bufferViews")[accessor["bufferView"]]
        kind, parts = np.dtype(_TYPES[accessor["componentType"]]), _PARTS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        step, count = view.get("byteStride") or kind.itemsize * parts, accessor["count"]
        data = self._buffers[view["buffer"]]
        if count and start + step * (count - 1) + kind.itemsize * parts > len(data):
            raise ValueError("its data are shorter than it says")
        rows = np.ndarray((count, parts), kind, data, start, (step, kind.itemsize))
        return rows / np.iinfo(kind).max if accessor.get("normalized") else rows


def _chunks(data: bytes) -> tuple[bytes, bytes]:
    """Return the document and the binary data of a binary file."""
    found: list[tuple[bytes, bytes]] = []
    at = _HEADER
    while at + _CHUNK <= len(data):
        length = int.from_bytes(data[at : at + 4], "little")
        found.append((data[at + 4 : at + _CHUNK], data[at + _CHUNK : at + _CHUNK + length]))
        at += _CHUNK + length
    if not found or found[0][0] != _JSON:
        raise ValueError("it is not binary glTF of version 2")
    return found[0][1], found[1][1] if len(found) > 1 else b""


def _transform(node: dict[str, Any]) -> npt.NDArray[np.float64]:
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z = node.get("translation", (0, 0, 0))
    qx, qy, qz, qw = node.get("rotation", (0, 0, 0, 1))
    result = np.eye(4)
    result[:3] = matrix_of(Pose((x, y, z), (qx, qy, qz, qw)))
    result[:3, :3] *= node.get("scale", (1, 1, 1))
    return result


def _faces(order: npt.NDArray[np.int64], mode: int) -> npt.NDArray[np.int64]:
    """Return the corners of triangles, shape ``(m, 3)``; points and lines have none."""
    if mode == _TRIANGLES:
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    if mode == _FAN:
        return np.stack([np.full(len(order) - 2, order[0]), order[1:-1], order[2:]], axis=1)
    if mode == _STRIP:
        faces = np.stack([order[:-2], order[1:-1], order[2:]], axis=1)
        faces[1::2] = faces[1::2, [1, 0, 2]]
        return faces
    return np.empty((0, 3), np.int64)
