"""The sizes that an MJCF file announces, which are bounded before MuJoCo allocates anything."""

from __future__ import annotations

from collections.abc import Iterator
from math import prod
from pathlib import Path

from nrp_core.errors import SceneError
from nrp_core.scene.reading.context import Element, read_xml

MAX_SAMPLES = 1 << 26
"""The largest height field or texture: 8192 by 8192 numbers."""
MAX_POINTS = 1_000_000
"""The largest number of points of a flexible body, and of copies that nested ``<replicate>`` make."""


def check_sizes(path: Path) -> None:
    """Refuse a file whose height fields, textures, flexible bodies or copies would fill the memory.

    Raises:
        SceneError: one is too large; it names the file, the line, the element and the size.
    """
    files, seen = [path], set[Path]()
    while files:
        file = files.pop().resolve()
        if file in seen or not file.is_file():
            continue
        seen.add(file)
        try:
            root = read_xml(file)
        except SceneError:  # MuJoCo reports unreadable files
            continue
        files += [file.parent / each.attributes.get("file", "") for each in root.all("include")]
        _check(root)


def _check(root: Element) -> None:
    for element, copies in _walk(root, 1.0):
        size, most = _announced(element, copies)
        if size > most:
            message = f"<{element.tag}> announces {size:.3g} items; at most {most:.3g} are read"
            raise SceneError(message, path=element.path, line=element.line)


def _walk(element: Element, copies: float) -> Iterator[tuple[Element, float]]:
    """Yield an element and those in it, each with the number of copies that are made of it."""
    if element.tag == "replicate":
        copies *= _number(element, "count", 1.0)
    yield element, copies
    for child in element.children:
        yield from _walk(child, copies)


def _announced(element: Element, copies: float) -> tuple[float, float]:
    match element.tag:
        case "hfield":
            return _number(element, "nrow") * _number(element, "ncol"), MAX_SAMPLES
        case "texture":
            width = _number(element, "width")  # a cube without a height has six squares
            return width * (_number(element, "height") or 6 * width), MAX_SAMPLES
        case "flexcomp" | "composite":
            return copies * prod(_numbers(element, "count") or [0.0]), MAX_POINTS
        case "replicate":
            return copies, MAX_POINTS
    return 0.0, MAX_SAMPLES


def _number(element: Element, name: str, default: float = 0.0) -> float:
    return next(iter(_numbers(element, name)), default)


def _numbers(element: Element, name: str) -> list[float]:
    """Return the numbers of an attribute; MuJoCo itself reports invalid ones."""
    try:
        return [float(word) for word in element.attributes.get(name, "").split()]
    except ValueError:
        return []
