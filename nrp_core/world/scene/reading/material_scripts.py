"""Materials in OGRE material scripts, as Gazebo's models have them.

Only the colour of a material is read: the emissive one, else the image and mean of its texture, else the
diffuse one.
See https://ogrecave.github.io/ogre/api/latest/_material-_scripts.html.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from nrp_core.world.scene.meshes.images import mean_color
from nrp_core.world.scene.model import Rgba

MAX_BYTES = 10_000_000
"""Maximum size of a script, bytes; five times as much for an image."""

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_HEAD = re.compile(r"^\s*material\s+(\S+)", re.MULTILINE)
_PROPERTY = re.compile(r"^\s*(ambient|diffuse|emissive|texture)\s+(.+?)\s*$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Material:
    """The colour of a material, whether it glows, and the image whose mean it is."""

    rgba: Rgba
    glows: bool = False
    image: Path | None = None


def script_material(name: str, places: Iterable[Path], textures: Iterable[Path] = ()) -> Material | None:
    """Return a material; None if no script has it or it has no colour.

    Args:
        name: its name in the script.
        places: scripts, or folders of scripts and images.
        textures: folders in which images are looked for last.
    """
    places = list(places)
    folders = [place if place.is_dir() else place.parent for place in places]
    for script in _scripts(places):
        text = _COMMENT.sub("", _contents(script, MAX_BYTES).decode(errors="replace"))
        heads = list(_HEAD.finditer(text))
        ends = [*(head.start() for head in heads), len(text)][1:]
        for head, end in zip(heads, ends, strict=False):  # a missing brace counts as the end
            if head[1] == name:
                return _material(
                    text[head.end() : end], [*folders, script.parent.parent / "textures", *textures]
                )
    return None


def image_material(name: str, folders: Iterable[Path]) -> Material | None:
    """Return the material of the image with a name; None if it is in none of the folders."""
    image = next((path for folder in folders if (path := folder / name).is_file()), None)
    mean = mean_color(_contents(image, 5 * MAX_BYTES)) if image else None
    return Material((*mean, 1.0), image=image) if mean else None


def _scripts(places: Iterable[Path]) -> Iterator[Path]:
    for place in places:
        if place.is_dir():
            yield from sorted(place.glob("*.material"))
        elif place.suffix == ".material":
            yield place


def _material(body: str, folders: Iterable[Path]) -> Material | None:
    found: dict[str, str] = {}
    for match in _PROPERTY.finditer(body):
        found.setdefault(match[1], match[2])
    emissive = _numbers(found.get("emissive", ""))
    if emissive and any(emissive[:3]):
        return Material(emissive, glows=True)
    textured = image_material(found["texture"].split()[0], folders) if "texture" in found else None
    lit = _numbers(found.get("diffuse", "")) or _numbers(found.get("ambient", ""))
    return textured or (Material(lit) if lit else None)


def _numbers(text: str) -> Rgba | None:
    """Return three or four numbers as a colour; a fifth one is another property's."""
    with suppress(ValueError):
        r, g, b, *alpha = (min(max(float(word), 0.0), 1.0) for word in text.split()[:4])
        return r, g, b, alpha[0] if alpha else 1.0
    return None


def _contents(path: Path, limit: int) -> bytes:
    with suppress(OSError):
        if path.stat().st_size <= limit:
            return path.read_bytes()
    return b""
