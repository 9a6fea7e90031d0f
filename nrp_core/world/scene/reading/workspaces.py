"""Packages of the ROS workspace that a file is in: sources and installed ones, by colcon and catkin.

A workspace has its sources below ``src``, at any depth, and the installed packages below ``install``, each in
``share/NAME`` of one common folder or of a folder of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path

from nrp_core.errors import SceneError
from nrp_core.world.scene.reading.xml import read_xml

MANIFEST = "package.xml"
_SOURCES = "src"
_DEPTH = 4
"""Folders between a workspace's ``src`` and a package."""


def in_workspace(name: str, user: Path) -> Iterator[Path]:
    """Yield the folders of a package in the workspace of a file, sources first.

    Args:
        name: the name of the package.
        user: the file that refers to it.
    """
    above = user.absolute().parents
    own = next((folder for folder in above if (folder / MANIFEST).is_file()), None)
    if own is None:
        return
    if package_name(own) == name:
        yield own
    sources = next((folder for folder in own.parents if folder.name == _SOURCES), own.parent)
    if name in (found := _packages(sources)):
        yield found[name]
    if own.parent.name == "share":
        prefix = own.parent.parent
        yield from (prefix / "share" / name, prefix.parent / name / "share" / name)


def package_name(folder: Path) -> str:
    """Return the name in the manifest of a package; empty without a manifest that can be read."""
    try:
        manifest = folder / MANIFEST
        return read_xml(manifest).word("name") if manifest.is_file() else ""
    except SceneError:
        return ""


@lru_cache(maxsize=8)
def _packages(sources: Path) -> Mapping[str, Path]:
    """Return the packages below a folder; of several with one name the least deep, the first by name."""
    found: dict[str, Path] = {}
    for depth in range(1, _DEPTH + 1):
        for manifest in sorted(sources.glob("*/" * depth + MANIFEST)):
            found.setdefault(package_name(manifest.parent), manifest.parent)
    return found
