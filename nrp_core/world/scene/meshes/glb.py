"""Textured meshes for viewers, in binary glTF 2.0 (https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html)."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from nrp_core.world.rigid.pose import Vector
from nrp_core.world.scene.meshes.mapped import Mapped

MAX_SIDE_PX = 2048
"""A larger image is reduced to this, which every graphics card shows."""

_MAGIC, _JSON, _BINARY = b"glTF", b"JSON", b"BIN\0"
_FLOAT, _ARRAY_BUFFER = 5126, 34962
_READY = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg"}
_GAMMA = 2.2  # from sRGB to the linear factors of glTF
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
    """Return an image as PNG or JPEG, reduced to what is shown, and its media type."""
    import cv2

    data = path.read_bytes()
    try:
        pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        return None
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
