"""A square with an image in glTF, written by hand as the format describes it."""

from __future__ import annotations

import base64
import json
import struct

import cv2
import numpy as np

CORNERS = np.array([(0, 0, 0), (2, 0, 0), (2, 0, 1), (0, 0, 1)], "<f4")
PLACES = np.array([(0, 1), (1, 1), (1, 0), (0, 0)], "<f4")  # from the upper left
ORDER = np.array([0, 1, 2, 0, 2, 3], "<u2")
GREEN = cv2.imencode(".png", np.full((4, 4, 3), (0, 255, 0), np.uint8))[1].tobytes()
PARTS = [CORNERS.tobytes(), PLACES.tobytes(), ORDER.tobytes(), GREEN]


def document(node: dict, *, order: np.ndarray = ORDER, mode: int = 4, **more: object) -> tuple[dict, bytes]:
    """Return a square with an image, without its buffer, and the buffer."""
    parts = [*PARTS[:2], order.tobytes(), GREEN]
    starts = np.cumsum([0, *map(len, parts)]).tolist()
    views = [
        {"buffer": 0, "byteOffset": at, "byteLength": len(part)}
        for at, part in zip(starts, parts, strict=False)
    ]
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
        {"bufferView": 2, "componentType": 5123, "count": len(order), "type": "SCALAR"},
    ]
    primitive = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0, "mode": mode}
    skin = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    return {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "door"} | node],
        "meshes": [{"name": "square", "primitives": [primitive]}],
        "materials": [skin],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 3, "mimeType": "image/png"}],
        "accessors": accessors,
        "bufferViews": views,
    } | more, b"".join(parts)


def text_file(node: dict, **more: object) -> bytes:
    found, buffer = document(node, **more)  # type: ignore[arg-type]
    uri = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    return json.dumps(found | {"buffers": [{"byteLength": len(buffer), "uri": uri}]}).encode()


def binary_file(node: dict) -> bytes:
    found, buffer = document(node)
    text = json.dumps(found | {"buffers": [{"byteLength": len(buffer)}]}).encode()
    text += b" " * (-len(text) % 4)
    buffer += bytes(-len(buffer) % 4)
    chunks = (
        struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(buffer), b"BIN\0") + buffer
    )
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
