"""glTF 2.0, as one binary file or with files beside it (https://registry.khronos.org/glTF/specs/2.0/).

As in Gazebo, coordinates are used unchanged: the file's convention that y is up is not applied.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote_to_bytes

import numpy as np
import numpy.typing as npt

from nrp_core._support.small_matrices import product
from nrp_core.scene.meshes.stl import mean_color
from nrp_core.scene.meshes.triangles import Coordinates, Mapped, Surface
from nrp_core.scene.rigid import Pose, Vector, matrix_of, transform

if TYPE_CHECKING:
    from nrp_core.scene.meshes.obj import ReadBeside
    from nrp_core.scene.model import Rgba

MAX_SIDE_PX = 2048
"""A larger image is reduced to this, which every graphics card shows."""

_BINARY = b"BIN\0"
_FLOAT, _ARRAY_BUFFER = 5126, 34962
_READY = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg"}

_TURN = (-0.5, -0.5, -0.5, 0.5)  # from x forward, z up to z forward, y up


def glb(mapped: Mapped, image: Path, tint: Vector, *, turned: bool = True) -> bytes | None:
    """Return a mesh with an image on it; None if the image cannot be read.

    Args:
        mapped: its triangles and their texture coordinates.
        image: a file of any format that OpenCV reads.
        tint: factors of red, green and blue, as sRGB.
        turned: whether its node turns it to the axes of glTF.
    """
    ready = _ready(image)
    if ready is None:
        return None
    picture, kind = ready
    triangles, coordinates = mapped
    corners = triangles.reshape(-1, 3).astype("<f4")
    places = coordinates.reshape(-1, 2).astype("<f4") * (1, -1) + (0, 1)  # glTF counts from the top
    parts = [corners.tobytes(), places.astype("<f4").tobytes(), picture]
    r, g, b = (part**_GAMMA for part in tint)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "rotation": _TURN}] if turned else [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
        "materials": [
            {
                "pbrMetallicRoughness": {
                    "baseColorTexture": {"index": 0},
                    "baseColorFactor": [r, g, b, 1.0],
                    "metallicFactor": 0.0,
                }
            }
        ],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 2, "mimeType": kind}],
        "accessors": [
            _accessor(0, len(corners), "VEC3", min=corners.min(0).tolist(), max=corners.max(0).tolist()),
            _accessor(1, len(corners), "VEC2"),
        ],
        **_buffers(parts),
    }
    binary = b"".join(_padded(part, b"\0") for part in parts)
    return _file(_padded(json.dumps(document).encode(), b" "), binary)


def contents_of(data: bytes) -> tuple[Mapped, bytes, Vector]:
    """Return the contents of a file that :func:`glb` wrote.

    Returns:
        The triangles with their texture coordinates; the file of the image; the tint.

    Raises:
        ValueError: it is another file.
    """
    if data[:4] != _MAGIC:
        raise ValueError("it is not a binary glTF file")
    length = int.from_bytes(data[12:16], "little")
    document = json.loads(data[20 : 20 + length])
    starts = ((28 + length + view["byteOffset"], view["byteLength"]) for view in document["bufferViews"])
    corners, places, picture = (data[start : start + size] for start, size in starts)
    triangles = np.frombuffer(corners, "<f4").astype(np.float64).reshape(-1, 3, 3)
    from_the_top = np.frombuffer(places, "<f4").reshape(-1, 3, 2)
    coordinates = np.stack([from_the_top[..., 0], 1 - from_the_top[..., 1]], axis=-1)
    r, g, b, _ = document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"]
    return (triangles, coordinates), picture, (r ** (1 / _GAMMA), g ** (1 / _GAMMA), b ** (1 / _GAMMA))


@lru_cache(maxsize=16)
def _ready_image(path: Path, _changed_ns: int) -> tuple[bytes, str] | None:
    """Return an image as PNG or JPEG, reduced to the displayed size, and its media type."""
    from nrp_core._support.opencv import cv2, decode

    data = path.read_bytes()
    pixels = decode(data, cv2.IMREAD_UNCHANGED)
    if pixels is None:
        return None
    kind = next((kind for start, kind in _READY.items() if data.startswith(start)), None)
    large = max(pixels.shape[:2]) / MAX_SIDE_PX
    if kind and large <= 1:
        return data, kind
    if large > 1:
        size = [max(1, round(length / large)) for length in pixels.shape[1::-1]]
        pixels = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    return cv2.imencode(".png", pixels)[1].tobytes(), "image/png"


def _ready(path: Path) -> tuple[bytes, str] | None:
    try:
        return _ready_image(path, path.stat().st_mtime_ns)
    except OSError:
        return None


def _accessor(view: int, count: int, kind: str, **limits: list[float]) -> dict[str, Any]:
    return {"bufferView": view, "componentType": _FLOAT, "count": count, "type": kind, **limits}


def _buffers(parts: list[bytes]) -> dict[str, Any]:
    """Return the buffer and its views, one for each part; the image, the last one, has no target."""
    ends = np.cumsum([len(_padded(part, b"\0")) for part in parts]).tolist()
    views = [
        {"buffer": 0, "byteOffset": start, "byteLength": len(part), "target": _ARRAY_BUFFER}
        for part, start in zip(parts, [0, *ends], strict=False)
    ]
    del views[-1]["target"]
    return {"bufferViews": views, "buffers": [{"byteLength": ends[-1]}]}


def _padded(part: bytes, filler: bytes) -> bytes:
    return part + filler * (-len(part) % 4)


def _file(document: bytes, binary: bytes) -> bytes:
    chunks = [
        len(data).to_bytes(4, "little") + kind + data for kind, data in ((_JSON, document), (_BINARY, binary))
    ]
    length = 12 + sum(map(len, chunks))
    return _MAGIC + (2).to_bytes(4, "little") + length.to_bytes(4, "little") + b"".join(chunks)


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
        with np.errstate(invalid="ignore", over="ignore"):  # triangles without numbers are omitted later
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
        matrix = product(above, _transform(node))
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
        placed = transform(points, matrix)
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
