"""Meshes of robots and rooms: Collada, STL, OBJ and glTF, converted once and kept in the user's cache.

Scenes then refer to one simple format, binary STL in metres, for every engine and for the rasteriser. The
file is named by a digest of all its sources, so that an edited mesh is converted again and equal meshes are
equal in any folder. Texture coordinates lie beside it; images stay where they are until someone looks.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from contextlib import suppress
from dataclasses import astuple, dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from nrp_core._support.cache import cached_folder
from nrp_core._support.used_files import SETTLED_NS
from nrp_core.errors import SceneError
from nrp_core.scene.meshes.concave import hull_excess
from nrp_core.scene.meshes.convert import KINDS, Wanted, parse, pieces_of
from nrp_core.scene.meshes.stl import write_coordinates, write_stl
from nrp_core.scene.meshes.triangles import Surface, concatenate
from nrp_core.scene.model import Rgba

MAX_BYTES = 200_000_000
MAX_BYTES_BESIDE = 50_000_000
"""Maximum size of a material file or a texture, bytes."""

_VERSION = 5  # of the cache; increased with each change of a conversion
_LISTING = "pieces.json"
LFS = b"version https://git-lfs"
"""How a pointer of Git LFS begins, which is in the place of a file that was not fetched."""


@dataclass(frozen=True, slots=True)
class Piece:
    """A part of a converted mesh.

    Args:
        path: a binary STL file.
        rgba: its colour; None if it has none.
        image: the image on it; None for none.
        left_out: number of triangles of the whole mesh that were omitted, because a corner is not a number.
        depth: thickness of the solid behind a concave surface, m; None for others.
        excess: the volume of the convex pieces of the whole mesh beyond its own, as a share of it.
    """

    path: Path
    rgba: Rgba | None
    image: Path | None = None
    left_out: int = 0
    depth: float | None = None
    excess: float = 0.0


def mesh_pieces(path: Path, wanted: Wanted) -> list[Piece]:
    """Return the pieces of a mesh, the largest first.

    Args:
        path: a Collada, STL, OBJ or glTF file.
        wanted: the part of it and the form.

    Raises:
        SceneError: it has another format, is too large, or cannot be used.
    """
    (data, facts), suffix = _contents(path), path.suffix.lower()
    key = _extended(_hashed(path, data, facts), suffix, *astuple(wanted), _VERSION)
    try:
        while True:
            fill = partial(_fill, key, data, suffix, path.parent, wanted)
            folder = cached_folder("meshes", key, fill, _is_whole)
            listing = json.loads((folder / _LISTING).read_text())
            beside = {name: digest(_beside(path.parent, name)) for name in listing["beside"]}
            if beside == listing["beside"]:
                break
            key = digest(key, sorted(beside.items()))
            _parsed.cache_clear()
    except (ValueError, IndexError) as error:
        raise SceneError(f"cannot be read: {error}", path=path) from error
    return [
        Piece(
            folder / name,
            tuple(rgba) if rgba else None,
            _found(image, listing["files"], folder, path.parent),
            listing.get("left_out", 0),
            listing.get("depths", {}).get(name),
            listing.get("excess", 0.0),
        )
        for name, rgba, image in listing["pieces"]
    ]


def _found(image: str | None, kept: list[str], folder: Path, home: Path) -> Path | None:
    """Return the file of an image, which is with the converted mesh if it was inside of the file."""
    if image is None:
        return None
    return folder / image if image in kept else _placed(home, image)


def _fill(key: str, data: bytes, suffix: str, home: Path, wanted: Wanted, folder: Path) -> None:
    """Write the pieces of a mesh and a list of them with all source files."""
    surfaces, left_out, beside = _parsed(data, suffix, home)
    pieces, depths = [], {}
    found = pieces_of(surfaces, wanted)
    for number, piece in enumerate(found):
        image = piece.image if piece.held is None else f"{key}-{number}.image"
        pieces.append((f"{key}-{number}.stl", piece.rgba, image))
        if image is not None and piece.held is not None:
            (folder / image).write_bytes(piece.held)
        write_stl(folder / pieces[-1][0], piece.triangles)
        if piece.depth is not None:
            depths[pieces[-1][0]] = piece.depth
        if piece.coordinates is not None:
            write_coordinates(folder / pieces[-1][0], piece.coordinates)
    files = sorted(file.name for file in folder.iterdir())
    listing = {"pieces": pieces, "files": files, "beside": beside, "left_out": left_out}
    listing |= {"depths": depths} if depths else {}
    if wanted.form == "convex":
        listing["excess"] = hull_excess(concatenate(surfaces), [piece.triangles for piece in found])
    (folder / _LISTING).write_text(json.dumps(listing))


def _is_whole(folder: Path) -> bool:
    try:
        listing = json.loads((folder / _LISTING).read_text())
        return all((folder / name).is_file() for name in listing["files"])
    except (OSError, ValueError, LookupError, TypeError):
        return False


@lru_cache(maxsize=1)  # visuals and collisions often use the same file
def _parsed(data: bytes, suffix: str, home: Path) -> tuple[list[Surface], int, dict[str, str]]:
    """Return the surfaces of a mesh, the triangles left out, and a digest of each file that it refers to."""
    beside: dict[str, str] = {}

    def read(name: str) -> bytes | None:
        contents = _beside(home, name)
        beside[name] = digest(contents)
        return contents

    return *parse(data, suffix, read), beside


def _contents(path: Path) -> tuple[bytes, os.stat_result]:
    """Return the contents of a file, and its status in the file system before it was read."""
    if path.suffix.lower() not in KINDS:
        raise SceneError(f"is not of a supported type; supported: {', '.join(KINDS)}", path=path)
    try:
        facts = path.stat()
        if facts.st_size > MAX_BYTES:
            size = f"{facts.st_size / 1e6:.0f} MB"
            raise SceneError(f"is larger than {MAX_BYTES / 1e6:.0f} MB ({size})", path=path)
        data = path.read_bytes()
    except OSError as error:
        raise SceneError(f"cannot be read: {error.strerror}", path=path) from error
    if data.startswith(LFS):
        raise SceneError("is a Git LFS pointer: fetch the file itself with `git lfs pull`", path=path)
    return data, facts


def _beside(home: Path, name: str) -> bytes | None:
    """Return the contents of a file that a mesh in the folder ``home`` refers to, None if it is missing."""
    with suppress(OSError, ValueError):
        path = _placed(home, name)
        if path.is_file() and path.stat().st_size <= MAX_BYTES_BESIDE:
            return path.read_bytes()
    return None


def _placed(home: Path, name: str) -> Path:
    return home / unquote(name.removeprefix("file://")).replace("\\", "/")


def _hashed(path: Path, data: bytes, facts: os.stat_result) -> Any:
    """Return the hash of a file, which is not to be changed; the legs of a robot use files in turn."""
    if time.time_ns() - facts.st_mtime_ns < SETTLED_NS:
        return _updated(hashlib.blake2b(digest_size=16), data)
    known = _known_hash(path, facts.st_ino, facts.st_size, facts.st_mtime_ns)
    if not known:
        known.append(_updated(hashlib.blake2b(digest_size=16), data))
    return known[0]


@lru_cache(maxsize=1024)
def _known_hash(_path: Path, _inode: int, _size: int, _changed_ns: int) -> list[Any]:
    """Return the cached hash of an unchanged file, in a list that is empty at first."""
    return []


def digest(*parts: object) -> str:
    """Return a hash of the sources of a mesh, as the name of a file."""
    return _extended(hashlib.blake2b(digest_size=16), *parts)


def _extended(begun: Any, *parts: object) -> str:
    """Return a hash with more parts, as the name of a file."""
    return str(_updated(begun.copy(), *parts).hexdigest())


def _updated(total: Any, *parts: object) -> Any:
    for part in parts:
        data = part if isinstance(part, bytes) else repr(part).encode()
        total.update(len(data).to_bytes(8, "little"))
        total.update(data)
    return total
